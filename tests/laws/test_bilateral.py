"""Which bilateral rows count, what they imply and how they share, against exact fractions."""

from fractions import Fraction

import numpy as np

from impulsekit.laws.bilateral import are_shared, find_rank, is_implied, spread

# Rows of unit length, the third 3/5 of the first and 4/5 of
# the second; the fourth stands by itself.
ROWS = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0.6, 0.8, 0, 0], [0, 0, 0.28, 0.96]], dtype=float)


def ranked(rows):
    count = len(rows)
    order, lower, shares = np.arange(count), np.zeros((count, count)), np.zeros((count, count))
    rank = find_rank(rows.copy(), order, lower, shares)
    return rank, order, lower, shares


def test_rows_that_others_imply_are_set_aside_with_their_shares():
    rank, order, lower, shares = ranked(ROWS)
    assert rank == 3 and set(order) == {0, 1, 2, 3}
    kept, left = order[:3], order[3]
    np.testing.assert_allclose(shares[0, :3] @ ROWS[kept], ROWS[left], atol=1e-15)
    gram = ROWS[kept] @ ROWS[kept].T
    np.testing.assert_allclose(np.tril(lower)[:3, :3] @ np.tril(lower)[:3, :3].T, gram, atol=1e-15)
    # Lᵀ is written above the diagonal.
    np.testing.assert_array_equal(lower[:3, :3], lower[:3, :3].T)


def test_rows_nearly_dependent_are_in_doubt():
    rows = ROWS.copy()
    rows[2, 2] = 1e-4
    assert ranked(rows)[0] == -1
    rows[2, 2] = 1e-2
    assert ranked(rows)[0] == 4


def test_impulses_are_shared_by_least_norm():
    # (x, 0) less its part along (−s, 1), with s = (3/5, 4/5, 0): z = s·x / (1 + s·s).
    s = [Fraction(3, 5), Fraction(4, 5), Fraction(0)]
    x = [Fraction(7), Fraction(-2), Fraction(5)]
    z = sum(a * b for a, b in zip(s, x, strict=True)) / (1 + sum(a * a for a in s))
    truth = [float(b - a * z) for a, b in zip(s, x, strict=True)]
    found, others = np.array([float(b) for b in x]), np.zeros(1)
    shares = np.array([[0.6, 0.8, 0.0]])
    factor, column = np.empty((1, 1)), np.empty(1)
    spread(3, shares, found, others, factor)
    np.testing.assert_allclose(found, truth, rtol=1e-15)
    np.testing.assert_allclose(others, [float(z)], rtol=1e-15)
    shared = np.zeros(3, np.bool_)
    are_shared(3, shares, factor, column, shared)
    assert shared.tolist() == [True, True, False]


def test_several_rows_share_by_least_norm():
    # Row by row of S; x is what (1, Sᵀ) P comes to, P of least norm: x₁ = (1 + Sᵀ S)⁻¹ x.
    shares = np.array([[1.0, 0.0], [2.0, -1.0]])
    x = np.array([3.0, 4.0])
    found, others, factor = x.copy(), np.empty(2), np.empty((3, 3))
    spread(2, shares, found, others, factor)
    # 1 + Sᵀ S = [[6, -2], [-2, 2]], of which the inverse is [[1/4, 1/4], [1/4, 3/4]].
    np.testing.assert_allclose(found, [7 / 4, 15 / 4], rtol=1e-14)
    np.testing.assert_allclose(others, [7 / 4, -1 / 4], rtol=1e-14)


def test_what_is_implied_is_told_to_rounding():
    share, known = np.array([0.6, 0.8]), np.array([2.0, -1.0])
    implied = 0.6 * 2.0 - 0.8
    assert is_implied(implied, share, known, 2, 2.0)
    assert not is_implied(implied + 1e-12, share, known, 2, 2.0)
