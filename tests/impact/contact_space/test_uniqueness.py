"""Which contacts carry what no other could carry for them."""

import numpy as np
import pytest

from impulsekit.laws.modes import DEPENDENT
from impulsekit.laws.redundant import find_shared

from .posed import posed
from .problems import box, sphere


def unique_contacts(W, mu, P, *, slips=True):
    work, n, sizes = posed(W, -np.ones(len(W)), mu, P)
    shared = find_shared(work, n, sizes, DEPENDENT, slips)
    assert shared == (not work.unique.all())
    return work.unique


def test_spheres_apart_are_unique_and_corners_of_a_box_are_not():
    P = np.tile([0.1, 0.0, 1.0], 4)
    assert unique_contacts(np.kron(np.eye(4), sphere()), 0.5, P).all()
    J, inverse = box()
    found = unique_contacts(J @ inverse @ J.T, 0.5, P)
    assert not found.any()


def test_what_does_not_push_has_no_part():
    J, inverse = box()
    P = np.array([0.1, 0, 1, 0.1, 0, 1, 0, 0, 0, 0, 0, 0.0])
    found = unique_contacts(J @ inverse @ J.T, 0.5, P)
    # Two corners can push against each other along their line.
    np.testing.assert_array_equal(found, [False, False, True, True])


def test_beside_a_box_a_sphere_stays_unique():
    J, inverse = box()
    W = np.zeros((15, 15))
    W[:12, :12], W[12:, 12:] = J @ inverse @ J.T, sphere()
    found = unique_contacts(W, 0.5, np.tile([0.1, 0.0, 1.0], 5))
    np.testing.assert_array_equal(found, [False] * 4 + [True])


def test_on_the_cone_is_slip_only_where_something_slips():
    """Two sticking corners are not unique, even where one has reached its cone."""
    J, inverse = box()
    W = (J @ inverse @ J.T)[:6, :6]
    P = np.array([0.5, 0.0, 1.0, 0.5, 0.0, 1.0])
    assert unique_contacts(W, 0.5, P).all()
    assert not unique_contacts(W, 0.5, P, slips=False).any()


@pytest.mark.parametrize("seed", range(30))
def test_the_parts_are_those_of_the_null_space(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    J = rng.normal(size=(3 * n, int(rng.integers(1, 3 * n - 3))))
    # Some contacts apart from all others.
    J = np.hstack([J, np.zeros((3 * n, 3))])
    J[:3] = 0.0
    J[:3, -3:] = np.eye(3) + 0.1 * rng.normal(size=(3, 3))
    W = J @ J.T
    P = np.tile([0.1, -0.05, 1.0], n)
    found = unique_contacts(W, 0.9, P)
    scale = 1.0 / np.sqrt(W.diagonal())
    values, vectors = np.linalg.eigh(W * scale * scale[:, None])
    null = vectors[:, values <= DEPENDENT * values[-1]]
    part = ((null**2).sum(axis=1) > 1e-9).reshape(n, 3).any(axis=1)
    assert part.any() and not part[0]
    np.testing.assert_array_equal(found, ~part)
