"""Triangular systems, in parts small enough for one thread."""

import numpy as np
import pytest

from impulsekit.impact.lapack import WITH_THREADS, WITHOUT_THREADS, dtrsm, solve_triangle


@pytest.mark.parametrize(
    ("n", "m"), [(6, 3), (32, 32), (32, 33), (30, 90), (7, 500), (WITH_THREADS + 1, 2), (5, 0)]
)
def test_all_columns_are_solved_for(n, m):
    rng = np.random.default_rng(n + m)
    lower = np.tril(rng.normal(size=(n, n))) / n + 2.0 * np.eye(n)
    columns = rng.normal(size=(n, m))
    found = solve_triangle(dtrsm, lower, columns.copy(), lower=1)
    np.testing.assert_allclose(lower @ found, columns, atol=1e-12)
    turned = solve_triangle(dtrsm, lower, columns.copy(), lower=1, trans_a=1)
    np.testing.assert_allclose(lower.T @ turned, columns, atol=1e-12)
    assert n * m <= WITHOUT_THREADS or n > WITH_THREADS or WITHOUT_THREADS // n < m
