"""Contacts that hold up to a given impulse: closed forms, constraints and their statement."""

import numpy as np
import pytest

import impulsekit as ik

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
MASS = float(BALL.model.inertias[1].mass)


def lifted(blow, adhesion, **more):
    pad = ik.Contact("ball", adhesion=adhesion, **more)
    scene = ik.Scene(BALL, [ik.AppliedImpulse("ball", linear=blow)], contacts=[pad])
    return ik.solve(scene, BALL.neutral(), BALL.velocity())


@pytest.mark.parametrize(("pull", "speed"), [(0.7, 0.0), (1.0, 0.0), (1.3, 0.3 / MASS)])
def test_a_pad_holds_up_to_its_adhesion(pull, speed):
    impact = lifted([0, 0, pull], 1.0)
    assert impact.is_valid() and ik.check(impact).agrees
    assert impact.v_after[2] == pytest.approx(speed, abs=1e-12)
    assert impact.contacts[0].impulse[2] == pytest.approx(-min(pull, 1.0), abs=1e-12)
    assert abs(impact.energy.imbalance) < 1e-12
    if pull != 1.0:
        assert (impact.contacts[0].mode == "separated") == (pull > 1.0)


def test_the_cone_counts_the_adhesion():
    """Pulled up by 0.4 and sideways, it sticks while the side is below µ (1 − 0.4)."""
    held = lifted([0.29, 0, 0.4], 1.0, friction=0.5)
    slips = lifted([0.5, 0, 0.4], 1.0, friction=0.5)
    assert np.abs(held.v_after[:3]).max() < 1e-12 and held.contacts[0].mode == "sticking"
    assert slips.v_after[0] == pytest.approx((0.5 - 0.5 * 0.6) / MASS, rel=1e-12)
    assert slips.contacts[0].impulse[0] == pytest.approx(-0.3, rel=1e-12)


@pytest.mark.parametrize("adhesion", [1e3, 1e9, 1e15])
def test_however_much_it_holds_what_it_holds_is_at_rest(adhesion):
    pad = ik.Contact("ball", adhesion=adhesion, friction=0.3)
    scene = ik.Scene(BALL, contacts=[pad])
    v = BALL.velocity(root_joint=[0.7, 0, -1, 0, 0.3, 0])
    impact = ik.solve(scene, BALL.neutral(), v)
    assert impact.is_valid() and np.abs(impact.v_after[:3]).max() < 1e-15
    assert impact.contacts[0].impulse == pytest.approx([-0.7 * MASS, 0, MASS], rel=1e-15)
    batch = ik.solve_batch(scene, BALL.neutral()[None], v[None])
    assert batch.valid[0] and batch.v_after[0] == pytest.approx(impact.v_after, abs=1e-15)


def test_pads_share_a_pull_evenly_whatever_each_could_hold():
    pads = [ik.Contact("ball", at=[x, 0, 0], adhesion=a) for x, a in ((0.1, 5.0), (-0.1, 1e9))]
    scene = ik.Scene(BALL, [ik.AppliedImpulse("ball", linear=[0, 0, 1])], contacts=pads * 2)
    impact = ik.solve(scene, BALL.neutral(), BALL.velocity())
    assert impact.is_valid()
    assert [c.impulse[2] for c in impact.contacts] == pytest.approx([-0.25] * 4, abs=1e-9)


def test_a_corner_that_would_lift_is_held_as_by_a_constraint():
    """A bar lands on one end; the pad at its other end holds as if it were pinned, or lets go."""
    rod = ik.Robot.from_urdf("models/rod.urdf", root="freeflyer")
    ends = np.array([[0.5, 0, 0], [-0.5, 0, 0]])
    v = rod.velocity(root_joint=[0, 0, -0.5, 0, 1.0, 0])  # the second end is at rest
    free = [ik.Contact("rod", at=at) for at in ends]
    loose = ik.solve(ik.Scene(rod, contacts=free, gap_bound=9), rod.neutral(), v)
    assert loose.contacts[1].velocity_after[2] > 0.1
    pads = [free[0], ik.Contact("rod", at=ends[1], adhesion=10.0)]
    held = ik.solve(ik.Scene(rod, contacts=pads, gap_bound=9), rod.neutral(), v)
    pin = ik.PointAnchor("rod", at=ends[1], other_at=ends[1])
    pinned = ik.solve(
        ik.Scene(rod, constraints=[pin], contacts=free[:1], gap_bound=9), rod.neutral(), v
    )
    assert np.abs(held.v_after - pinned.v_after)[[2, 4]].max() < 1e-12
    needed = -held.contacts[1].impulse[2]
    assert needed > 0.0
    pads[1] = ik.Contact("rod", at=ends[1], adhesion=0.5 * needed)
    torn = ik.solve(ik.Scene(rod, contacts=pads, gap_bound=9), rod.neutral(), v)
    assert torn.contacts[1].impulse[2] == pytest.approx(-0.5 * needed, rel=1e-12)
    assert torn.contacts[1].velocity_after[2] > 1e-3 and torn.is_valid()
