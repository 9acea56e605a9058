"""Factors of M: exact fractions, M filled up by rows, and the joints that nothing holds."""

from fractions import Fraction

import mpmath
import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import SingularMassError
from impulsekit.impact.factor import DenseFactor, MassFactor, SparseFactor
from impulsekit.robot.mass_matrix import symmetric
from tests.robots import random_state


def solved(matrix, right):
    """A⁻¹ B in 50 digits."""
    with mpmath.workdps(50):
        columns = [mpmath.lu_solve(mpmath.matrix(matrix), column) for column in right.T.tolist()]
        return np.array([[float(x) for x in column] for column in columns]).T


def of_two_joints():
    """A model with two degrees of freedom."""
    model = pin.buildSampleModelManipulator()
    return pin.buildReducedModel(model, [3, 4, 5, 6], pin.neutral(model))


@pytest.fixture
def talos():
    return ik.Robot.from_example("talos", root="freeflyer")


def factor_at(robot, q, **options):
    model = robot.model
    data = model.createData()
    factor = MassFactor(model, data, **{"singular": False, **options})
    pin.crba(model, data, q)
    return factor.at(None), symmetric(data.M)


@pytest.mark.slow
def test_sparse_and_dense_factor_have_the_digits_of_the_mass_matrix(talos):
    q, _ = random_state(talos, 1)
    sparse, masses = factor_at(talos, q)
    assert isinstance(sparse, SparseFactor)
    dense = DenseFactor(talos.model, masses)
    rng = np.random.default_rng(2)
    rows = rng.normal(size=(50, talos.nv))
    truth = solved(masses, rows.T)
    size = np.abs(truth).max(axis=0)
    one = np.array([sparse.solve(row) for row in rows]).T
    other = np.array([dense.solve(row) for row in rows]).T
    for found in (one, other, dense.solve(rows.T)):
        assert (np.abs(found - truth) <= 2e-13 * size).all()
    # Rows beside rows: W = Cᵀ C.
    delassus = rows @ truth
    for factor in (sparse, dense):
        half = factor.half(rows[:20], rows[20:])
        np.testing.assert_allclose(half.T @ half, delassus, atol=1e-12 * np.abs(delassus).max())
    np.testing.assert_allclose(dense.back(dense.half(rows)), truth, atol=2e-13 * size.max())


def test_rows_make_up_for_what_the_mass_matrix_lacks():
    # Two speeds, of which only their difference moves mass, and a row that holds a sum of both.
    model = of_two_joints()
    masses = np.array([[2.0, -2.0], [-2.0, 2.0]])
    row, wanted = np.array([[1.0, 3.0]]), np.array([5.0])
    with pytest.raises(SingularMassError):
        DenseFactor(model, masses)
    for singular in (False, True):
        factor = DenseFactor(model, masses, row, singular=singular)
        assert factor.is_filled
        impulse = np.array([7.0, -1.0])
        start = factor.solve(factor.filled(impulse, wanted))
        half = factor.half(row)[:, 0]
        multiplier = (wanted[0] - row[0] @ start) / (half @ half)
        dv = start + factor.solve(multiplier * row[0])
        # 2 (a − b) = 7 + λ, −2 (a − b) = −1 + 3 λ, a + 3 b = 5.
        λ = Fraction(-6, 4)
        difference = (7 + λ) / 2
        truth = [(5 + 3 * difference) / 4, (5 - difference) / 4]
        np.testing.assert_allclose(dv, [float(x) for x in truth], rtol=1e-14)
        assert multiplier == pytest.approx(float(λ), rel=1e-14)
        many = factor.solve(factor.filled(np.column_stack([impulse, impulse]), wanted * [[1, 1]]))
        np.testing.assert_allclose(many, np.column_stack([start, start]), rtol=1e-14)


def test_what_needs_no_rows_is_not_filled(talos):
    q, _ = random_state(talos, 1)
    _, masses = factor_at(talos, q)
    rows = np.ones((2, talos.nv))
    assert not DenseFactor(talos.model, masses, rows).is_filled
    assert DenseFactor(talos.model, masses, rows, singular=True).is_filled


def test_a_pivot_that_is_rounding_names_its_joint():
    model = of_two_joints()
    with pytest.raises(SingularMassError) as caught:
        DenseFactor(model, np.diag([1.0, 0.0]))
    assert caught.value.joints == (model.names[2],)
