"""Contacts that hold up to a given impulse: closed forms, constraints and their statement."""

from dataclasses import replace

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.impact.contact_space import ContactProblem, solve_contacts
from impulsekit.impact.contact_space.adhesive import refined_adhesive
from impulsekit.impact.steps import steps_of

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


def test_random_contacts_obey_the_law():
    """0 ≤ P_n + A ⊥ u_n⁺ ≥ 0, |P_t| ≤ µ (P_n + A), slip against its friction."""
    rng = np.random.default_rng(3)
    solved = 0
    for _ in range(200):
        n = int(rng.integers(1, 4))
        root = rng.normal(size=(3 * n, 3 * n + 2))
        W, u = root @ root.T, rng.normal(size=3 * n)
        mu, A = rng.choice([0.0, 0.4], n), rng.uniform(0, 1, n) * rng.integers(0, 2, n)
        free, zero = u + rng.normal(size=3 * n), np.zeros(n)
        found = solve_contacts(ContactProblem(W, u, free, zero, mu, zero, adhesion=A), ik.Law())
        if not found.status.obeys_law:
            continue
        solved += 1
        P, after = found.impulse, W @ found.impulse + free
        size = np.abs(u).max() + np.abs(free).max()
        pressed = P[2::3] + A
        assert (pressed > -1e-10).all() and (after[2::3] > -1e-10 * size).all()
        assert np.abs(pressed * after[2::3]).max() < 1e-9 * size
        sideways = P.reshape(-1, 3)[:, :2]
        assert (np.linalg.norm(sideways, axis=1) <= mu * pressed + 1e-9).all()
        slip = after.reshape(-1, 3)[:, :2]
        speed = np.linalg.norm(slip, axis=1)
        for i in np.flatnonzero((speed > 1e-8) & (mu > 0)):
            assert np.abs(sideways[i] + mu[i] * pressed[i] * slip[i] / speed[i]).max() < 1e-8
    assert solved > 190


def test_without_adhesion_nothing_changes():
    plain, zero = (lifted([0.3, 0, -1.0], a, friction=0.5) for a in (0.0, 0.0))
    assert np.array_equal(plain.v_after, zero.v_after)
    tiny = lifted([0.3, 0, -1.0], 1e-300, friction=0.5)
    assert np.abs(tiny.v_after - plain.v_after).max() < 1e-14


def test_bad_input_is_one_clear_error():
    with pytest.raises(ik.errors.RangeError, match="adhesion must be 0 or more"):
        ik.Contact("ball", adhesion=-1.0)
    with pytest.raises(ik.errors.InputError, match="restitution must be 0"):
        ik.Scene(BALL, contacts=[ik.Contact("ball", adhesion=1.0, restitution=0.5)])
    with pytest.raises(ik.errors.InputError, match=r"belongs to Law\(\)"):
        ik.Scene(BALL, contacts=[ik.Contact("ball", adhesion=1.0)], law=ik.Law("poisson"))
    scene = lifted([0, 0, 1.0], 1.0).scene
    with pytest.raises(ik.errors.InputError, match="adhesion"):
        ik.simulate(scene, BALL.neutral(), BALL.velocity(), duration=0.1)
    with pytest.raises(ik.errors.InputError, match="adhesion"):
        ik.derivatives(lifted([0, 0, 1.0], 2.0))
    batch = ik.solve_batch(scene, np.tile(BALL.neutral(), (2, 1)), BALL.velocity())
    assert "adhere" in batch.plan.why[0] and batch.valid.all()


def test_what_holds_is_refined_to_rounding():
    """An answer that is off by 1e-8 comes back to the law, its works with it."""
    rng = np.random.default_rng(8)
    root = rng.normal(size=(9, 9))
    W = root @ root.T
    before = rng.normal(size=9) - np.tile([0, 0, 1.0], 3)
    problem = ContactProblem(
        W, before, before, np.zeros(3), np.array([0.5, 0.2, 0.0]), np.zeros(3),
        adhesion=np.array([0.1, 0.0, 0.05]),
    )  # fmt: skip
    exact = solve_contacts(problem, ik.Law())
    off = replace(exact, impulse=exact.impulse * (1.0 + 1e-8), residual=1e-8)
    steps = steps_of(
        np.linalg.inv(W), np.zeros(9), np.eye(9), np.empty((0, 9)),
        lambda change: W @ change, lambda impulse: np.empty(0),
    )  # fmt: skip
    found, dv = refined_adhesive(problem, ik.Law(), off, W @ off.impulse, steps)
    assert found.residual < 1e-13
    assert np.abs(found.impulse - exact.impulse).max() < 1e-13 * np.abs(exact.impulse).max() * 10
    assert np.abs(dv - (found.velocity_after - before)).max() < 1e-13
    work = 0.5 * found.impulse * (before + found.velocity_after)
    assert found.normal_work + found.friction_work == pytest.approx(work.reshape(3, 3).sum(axis=1))
