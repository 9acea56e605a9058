"""The first guess at contacts with friction: all held still."""

import itertools

import numpy as np
import pytest

from impulsekit.laws import at_once, frictional, several
from impulsekit.laws.status import Status
from impulsekit.laws.sticking import held_still

from .posed import posed
from .problems import box, rod, solved, sphere


def held(W, b):
    given = posed(W, b, 1.0)
    ridge = held_still(*given)
    return given[0].P, ridge


def test_regular_contacts_are_brought_to_rest_exactly():
    W = np.kron([[2.0, 1.0], [1.0, 3.0]], np.diag([3.5, 3.5, 1.0]))
    P = np.array([0.5, -0.25, 2.0, 1.0, 0.5, 4.0])
    found, ridge = held(W, -W @ P)
    np.testing.assert_allclose(found, P, rtol=1e-14)
    assert ridge == 0.0


def test_corners_of_a_box_share_what_holds_it_still():
    J, inverse = box()
    W = J @ inverse @ J.T
    b = J @ np.array([0.3, 0.1, -1.0, 0.2, -0.4, 0.1])
    found, ridge = held(W, b)
    assert ridge < 0.0
    np.testing.assert_allclose(W @ found, -b, atol=1e-13)
    # Corners side by side bear the same of a fall without turning.
    found, _ = held(W, J @ np.array([0, 0, -1.0, 0, 0, 0]))
    np.testing.assert_allclose(found.reshape(4, 3), np.tile([0, 0, 0.5], (4, 1)), atol=1e-6)


def test_rows_that_move_nothing_get_nothing():
    """A rod in the plane has no row across it."""
    W, b = rod(0.6), np.array([1.0, 0.0, -1.0])
    found, ridge = held(W, b)
    assert ridge > 0.0
    assert found[1] == 0.0
    np.testing.assert_allclose(W @ found, -b, atol=1e-14)


def test_what_sticks_and_what_rocks_needs_no_iterations(monkeypatch):
    """Nor does slip where the contacts are regular."""

    def never(*_):
        raise AssertionError("the search was called")

    monkeypatch.setattr(frictional, "search_slipping", never)
    monkeypatch.setattr(at_once.hit_contacts, "_code", at_once.hit_contacts.py_func)
    monkeypatch.setattr(at_once, "newton", several.newton.py_func)
    monkeypatch.setattr(several, "frictional", frictional.frictional.py_func)
    J, inverse = box(half=(0.1, 0.2, 0.3))
    W = J @ inverse @ J.T
    lands = solved(W, J @ np.array([0.1, 0.0, -1.0, 0, 0, 0]), 0.0, 0.9)
    assert lands.status is Status.SOLVED and not lands.unique.any()
    np.testing.assert_allclose(lands.velocity_after, 0, atol=1e-14)
    # Over two corners, which let go as the other two land.
    turning = J @ np.array([-0.3, 0.0, -0.1, 0.0, -1.0, 0.0])
    rocks = solved(W, turning, 0.0, 3.0)
    assert rocks.status is Status.SOLVED
    leaving = rocks.velocity_after[2::3] > 0.1
    assert leaving.sum() == 2 and not rocks.impulse.reshape(4, 3)[leaving].any()
    # Two points of one ball beside each other: what one does moves the other a little.
    two = np.kron(np.eye(2), sphere())
    two[2, 5] = two[5, 2] = 1e-9
    slides = solved(two, [3.0, 4.0, -1.0, 0.1, 0.0, -1.0], 0.0, 0.3)
    np.testing.assert_allclose(slides.impulse[:3], [-0.18, -0.24, 1.0], rtol=1e-8)
    assert slides.residual <= 1e-15


@pytest.mark.parametrize("seed", range(4))
def test_slip_of_redundant_contacts_knows_no_order(seed):
    """There the law may have many answers, and which is found must not depend on the entries."""
    rng = np.random.default_rng(seed)
    J, inverse = box()
    W = J @ inverse @ J.T
    u = J @ np.array([3.0, 1.0, -1.0, 0.2, 0, 0.5]) + J @ (0.3 * rng.normal(size=6))
    answer = solved(W, u, 0.0, 0.3)
    assert answer.status.obeys_law and answer.residual < 1e-12
    for order in itertools.permutations(range(4)):
        rows = (3 * np.array(order)[:, None] + np.arange(3)).ravel()
        other = solved(W[np.ix_(rows, rows)], u[rows], 0.0, 0.3)
        np.testing.assert_allclose(other.velocity_after, answer.velocity_after[rows], atol=1e-11)


@pytest.mark.parametrize("seed", range(5))
def test_where_nothing_slips_velocities_are_those_of_every_such_answer(seed):
    """Whatever the split: adding what moves nothing and staying in the cones changes none."""
    rng = np.random.default_rng(seed)
    J, inverse = box(half=(0.3, 0.2, 0.1))
    W = J @ inverse @ J.T
    v = np.array([*rng.uniform(-0.1, 0.1, 2), -1.0, *rng.uniform(-0.3, 0.3, 3)])
    answer = solved(W, J @ v, 0.0, 0.8)
    assert answer.status is Status.SOLVED
    order = rng.permutation(4)
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    other = solved(W[np.ix_(rows, rows)], (J @ v)[rows], 0.0, 0.8)
    np.testing.assert_allclose(other.velocity_after, answer.velocity_after[rows], atol=1e-13)
