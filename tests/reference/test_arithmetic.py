"""The same elimination in every precision."""

from __future__ import annotations

import sys
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from benchmarks.truths.maximal import solve_general
from impulsekit.errors import MissingExtraError, NotFiniteError, RangeError
from impulsekit.reference import Arithmetic, rotation

ALL = [
    Arithmetic.double(), Arithmetic.long_double(), Arithmetic.mpmath(50),
]  # fmt: skip
each = pytest.mark.parametrize("numbers", ALL, ids=lambda a: a.name)


def never(pivot):
    raise AssertionError(f"singular at {pivot}")


def hilbert(numbers, size):
    """1 / (i + j + 1): symmetric, positive, ill-conditioned; its inverse is known."""
    return numbers.array([[Fraction(1, i + j + 1) for j in range(size)] for i in range(size)])


@each
def test_a_symmetric_system_is_solved_to_the_precision_at_hand(numbers):
    matrix, wanted = hilbert(numbers, 5), numbers.array([[1, 6], [2, -7], [-3, 8], [4, 9], [5, 0]])
    found = numbers.solve_symmetric(matrix, matrix @ wanted, never)
    assert np.abs(found - wanted).max() < 1e6 * numbers.epsilon  # cond is 5e5
    assert np.abs(numbers.solve_symmetric(matrix, matrix @ wanted[:, 0], never)
                  - wanted[:, 0]).max() < 1e6 * numbers.epsilon  # fmt: skip


@each
def test_a_general_system_is_solved_with_row_exchanges(numbers):
    matrix = numbers.array([[0, 2, 1], [1, 0, 3], [4, -1, 0]])
    wanted = numbers.array([1, -2, 3])
    assert np.abs(solve_general(numbers, matrix, matrix @ wanted, never) - wanted).max() < (
        100 * numbers.epsilon
    )


@each
def test_the_vanishing_pivot_is_named(numbers):
    matrix = numbers.array([[1, 2, 0], [2, 4, 0], [0, 0, 1]])
    with pytest.raises(LookupError, match="1"):
        numbers.solve_symmetric(matrix, numbers.zeros(3), lambda pivot: LookupError(pivot))
    with pytest.raises(LookupError):
        solve_general(numbers, matrix, numbers.zeros(3), lambda pivot: LookupError(pivot))


@each
def test_the_shortest_of_many_solutions(numbers):
    """Against the pseudo-inverse of a matrix of rank 2 whose rows differ in size by 1e5."""
    factor = numbers.array([[1, 2], [100000, 3], [0, 0], [2, 4]])
    matrix = factor @ factor.T
    right = matrix @ numbers.array([1, 1, 1, 1])
    found, rank = numbers.solve_minimum_norm(matrix, right)
    assert rank == 2
    assert np.abs(matrix @ found - right).max() < 1e13 * numbers.epsilon
    # Shortest: it has no part along the null vectors (2, 0, 0, -1) and (0, 0, 1, 0).
    assert abs(2 * found[0] - found[3]) < 1e3 * numbers.epsilon
    assert found[2] == 0


@each
def test_rotations_are_orthogonal_and_turn_the_right_way(numbers):
    turned = rotation.of_roll_pitch_yaw(numbers.array([0.3, -1.2, 2.5]), numbers)
    assert np.abs(turned @ turned.T - numbers.eye(3)).max() < 8 * numbers.epsilon
    roll, pitch, yaw = (
        rotation.about_axis(numbers.eye(3)[i], numbers.cos(angle), numbers.sin(angle), numbers)
        for i, angle in enumerate(numbers.array([0.3, -1.2, 2.5]))
    )
    assert np.abs(turned - yaw @ pitch @ roll).max() < 8 * numbers.epsilon
    half = numbers.array([0.35])[0]
    quaternion = numbers.array([0, numbers.sin(half), 0, numbers.cos(half)])
    by_axis = rotation.about_axis(
        numbers.eye(3)[1], numbers.cos(2 * half), numbers.sin(2 * half), numbers
    )
    assert np.abs(rotation.of_quaternion(3 * quaternion, numbers) - by_axis).max() < (
        8 * numbers.epsilon
    )


def test_the_users_mpmath_is_left_alone():
    before = mpmath.mp.dps
    numbers = Arithmetic.mpmath(80)
    assert (
        abs(numbers.sin(numbers.number(1)) ** 2 + numbers.cos(numbers.number(1)) ** 2 - 1) < 1e-79
    )
    with mpmath.workdps(20):
        assert abs(numbers.number(1) / 3 * 3 - 1) < 1e-79
    assert mpmath.mp.dps == before


def test_without_mpmath_the_way_to_it_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "mpmath", None)
    with pytest.raises(MissingExtraError, match=r"pip install .\.\[reference\]. in impulsekit"):
        Arithmetic.mpmath(50)


@pytest.mark.parametrize("digits", [0, 15, 20.5])
def test_digits_are_checked(digits):
    with pytest.raises(RangeError, match="a whole number from 16 up"):
        Arithmetic.mpmath(digits)


@each
def test_what_is_no_finite_number_is_found(numbers):
    for value in ([1, float("nan")], [[1.0, float("inf")]], ["one", 2]):
        with pytest.raises(NotFiniteError, match="speeds"):
            numbers.finite_array(value, "speeds")
