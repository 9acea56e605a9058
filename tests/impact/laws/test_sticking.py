"""The first guess at contacts with friction: all held still."""

import numpy as np
import pytest

from impulsekit.impact.laws import frictional
from impulsekit.impact.laws.modes import Modes
from impulsekit.impact.laws.sticking import held_still
from impulsekit.laws.status import Status

from .problems import box, rod, solved, sphere


def modes(W, b, mu=1.0):
    return Modes(np.array(W), np.array(b), np.full(len(b) // 3, mu), None)


def test_regular_contacts_are_brought_to_rest_exactly():
    W = np.kron([[2.0, 1.0], [1.0, 3.0]], np.diag([3.5, 3.5, 1.0]))
    P = np.array([0.5, -0.25, 2.0, 1.0, 0.5, 4.0])
    found, regular, ridge = held_still(modes(W, -W @ P))
    np.testing.assert_allclose(found, P, rtol=1e-14)
    assert regular and ridge == 0.0


def test_corners_of_a_box_share_what_holds_it_still():
    J, inverse = box()
    W = J @ inverse @ J.T
    b = J @ np.array([0.3, 0.1, -1.0, 0.2, -0.4, 0.1])
    found, regular, _ = held_still(modes(W, b))
    assert not regular
    np.testing.assert_allclose(W @ found, -b, atol=1e-13)
    # Corners side by side bear the same of a fall without turning.
    found, _, _ = held_still(modes(W, J @ np.array([0, 0, -1.0, 0, 0, 0])))
    np.testing.assert_allclose(found.reshape(4, 3), np.tile([0, 0, 0.5], (4, 1)), atol=1e-6)


def test_rows_that_move_nothing_get_nothing():
    """A rod in the plane has no row across it."""
    W, b = rod(0.6), np.array([1.0, 0.0, -1.0])
    found, regular, ridge = held_still(modes(W, b))
    assert regular and ridge > 0.0
    assert found[1] == 0.0
    np.testing.assert_allclose(W @ found, -b, atol=1e-14)


def test_what_sticks_and_what_rocks_needs_no_iterations(monkeypatch):
    """Nor does slip where the contacts are regular."""
    import impulsekit.impact.laws.admm as admm

    def never(*_):
        raise AssertionError("ADMM was called")

    monkeypatch.setattr(admm, "admm", never)
    J, inverse = box(half=(0.1, 0.2, 0.3))
    W = J @ inverse @ J.T
    lands = solved(W, J @ np.array([0.1, 0.0, -1.0, 0, 0, 0]), 0.0, 0.9)
    assert lands.status is Status.NOT_UNIQUE and not lands.unique.any()
    np.testing.assert_allclose(lands.velocity_after, 0, atol=1e-14)
    # Over two corners, which let go as the other two land.
    turning = J @ np.array([-0.3, 0.0, -0.1, 0.0, -1.0, 0.0])
    rocks = solved(W, turning, 0.0, 3.0)
    assert rocks.status is Status.NOT_UNIQUE
    leaving = rocks.velocity_after[2::3] > 0.1
    assert leaving.sum() == 2 and not rocks.impulse.reshape(4, 3)[leaving].any()
    two = np.kron(np.eye(2), sphere())
    slides = solved(two, [3.0, 4.0, -1.0, 0.1, 0.0, -1.0], 0.0, 0.3)
    np.testing.assert_allclose(slides.impulse[:3], [-0.18, -0.24, 1.0], rtol=1e-14)
    assert slides.residual <= 1e-15


def test_slip_of_redundant_contacts_is_left_to_admm():
    """There the law may have many answers, and which is found must not depend on a guess."""
    J, inverse = box()
    W, b = J @ inverse @ J.T, J @ np.array([3.0, 1.0, -1.0, 0.2, 0, 0.5])
    assert frictional._tried(modes(W, b, 0.1)) is None


@pytest.mark.parametrize("seed", range(5))
def test_where_nothing_slips_velocities_are_those_of_every_such_answer(seed):
    """Whatever the split: adding what moves nothing and staying in the cones changes none."""
    rng = np.random.default_rng(seed)
    J, inverse = box(half=(0.3, 0.2, 0.1))
    W = J @ inverse @ J.T
    v = np.array([*rng.uniform(-0.1, 0.1, 2), -1.0, *rng.uniform(-0.3, 0.3, 3)])
    answer = solved(W, J @ v, 0.0, 0.8)
    assert answer.status is Status.NOT_UNIQUE
    order = rng.permutation(4)
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    other = solved(W[np.ix_(rows, rows)], (J @ v)[rows], 0.0, 0.8)
    np.testing.assert_allclose(other.velocity_after, answer.velocity_after[rows], atol=1e-13)
