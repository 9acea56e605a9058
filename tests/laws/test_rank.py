"""Systems whose rank is found, held against pseudoinverses and eigenvectors."""

import numpy as np
import pytest

from impulsekit.laws.rank import gauss_of_rank, null_parts, null_projector, pivoted_cholesky


def of_rank(n, rank, seed):
    """A positive semidefinite matrix (n, n), its diagonal being 1."""
    half = np.random.default_rng(seed).normal(size=(rank, n))
    matrix = half.T @ half
    unit = 1.0 / np.sqrt(matrix.diagonal())
    return matrix * unit * unit[:, None]


@pytest.mark.parametrize("rank", [1, 3, 8, 11, 12])
def test_the_shortest_solution_is_the_pseudoinverse(rank):
    n = 12
    rng = np.random.default_rng(rank)
    matrix = of_rank(n, rank, rank) @ np.diag(rng.uniform(0.5, 2.0, n))
    right = matrix @ rng.normal(size=n)
    x = right.copy()
    gauss_of_rank(matrix.copy(), n, x, 1e-10, np.zeros(n), np.zeros(n))
    truth = np.linalg.pinv(matrix, rcond=1e-10) @ right
    assert np.abs(x - truth).max() < 1e-11 * np.abs(truth).max()


@pytest.mark.parametrize("rank", [1, 3, 8, 11])
def test_parts_in_the_null_space_are_those_of_the_eigenvectors(rank):
    n = 12
    matrix = of_rank(n, rank, rank)
    factor, order, room, part = matrix.copy(), np.empty(n, int), np.empty((n, n)), np.empty(n)
    assert pivoted_cholesky(factor, n, 1e-10, n, order) == rank
    upper = np.triu(factor)[:rank]
    assert np.abs(upper.T @ upper - matrix[np.ix_(order, order)]).max() < 1e-14
    null_parts(factor, n, rank, order, room, part)
    null = np.linalg.eigh(matrix)[1][:, : n - rank]
    assert np.abs(part - (null**2).sum(axis=1)).max() < 1e-12
    onto = np.empty((n, n))
    null_projector(factor, n, rank, order, room, onto)
    assert np.abs(onto - null @ null.T).max() < 1e-12


def test_columns_are_made_at_most_so_many():
    order = np.empty(12, int)
    assert pivoted_cholesky(of_rank(12, 12, 0), 12, 1e-10, 5, order) == 5
