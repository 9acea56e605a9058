"""Joints under stiff control strike as one composite rigid body, at their own speeds."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from tests.reference.models import mass_matrix

from ..close import close
from ..reference.models import joint, link, robot

MASSES, INERTIAS, LENGTH = (2.0, 0.5), (0.3, 0.02), 0.8
ARM = [f"panda_joint{i}" for i in range(1, 8)]


def cross(a, b):
    """The z component of a x b, in the plane."""
    return a[0] * b[1] - a[1] * b[0]


def two_bodies(root="planar"):
    """Two bodies on a hinge about z; each has its mass centre half way along its x axis."""
    near, far = (
        link(name, str(m), f"{LENGTH / 2} 0 0", inertia=f"1 0 0 1 0 {i}")
        for name, m, i in zip(("near", "far"), MASSES, INERTIAS, strict=True)
    )
    hinge = joint("hinge", "near", "far", "continuous", at=f"{LENGTH} 0 0")
    return ik.Robot.from_urdf(robot(near, far, hinge), root=root)


def composite(angle):
    """Mass, mass centre (2,) and inertia about it of the two bodies, locked at an angle."""
    along = np.array([np.cos(angle), np.sin(angle)])
    centres = np.array([[LENGTH / 2, 0], [LENGTH, 0] + LENGTH / 2 * along])
    masses = np.array(MASSES)
    centre = masses @ centres / masses.sum()
    arms = centres - centre
    return masses.sum(), centre, sum(INERTIAS) + masses @ (arms**2).sum(axis=1)


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.1])
def test_two_bodies_take_a_blow_as_one_and_the_hinge_keeps_its_speed(angle):
    """Δv = p/m and Δω = r x p/I of the composite body, whatever the hinge does."""
    body = two_bodies()
    q, spin = body.configuration(hinge=[np.cos(angle), np.sin(angle)]), 3.0
    v = body.velocity(root_joint=[0.2, -0.1, 0.5], hinge=spin)
    impulse = np.array([0.4, -1.1])
    blow = ik.AppliedImpulse("far", linear=[*impulse, 0], at=[LENGTH, 0, 0])
    impact = ik.solve(ik.Scene(body, [blow], controlled=["hinge"]), q, v)
    mass, centre, inertia = composite(angle)
    struck = np.array([LENGTH + LENGTH * np.cos(angle), LENGTH * np.sin(angle)])
    turn = cross(struck - centre, impulse) / inertia
    # The root's frame lies at the origin: v = v_c + ω x (0 − c).
    root = impulse / mass + turn * np.array([centre[1], -centre[0]])
    close(impact.dv, [*root, turn, 0.0], 1e-13)
    assert impact.v_after[3] == pytest.approx(spin, rel=1e-14)
    # A lock, on the other hand, takes the hinge's speed away.
    locked = ik.solve(ik.Scene(body, [blow], [ik.JointLock("hinge")]), q, v)
    assert abs(locked.v_after[3]) < 1e-14
    # The motor takes r x p of the far body, less what that body's own motion needs.
    along = np.array([np.cos(angle), np.sin(angle)])
    own = LENGTH / 2 * along
    centre_dv = impulse / mass + turn * np.array(
        [-(LENGTH * along[1] / 2 - centre[1]), LENGTH + own[0] - centre[0]]
    )
    needed = INERTIAS[1] * turn + MASSES[1] * cross(own, centre_dv)
    motor = needed - cross(LENGTH * along, impulse)
    assert impact.constraints["controlled hinge"].impulse[0] == pytest.approx(motor, rel=1e-12)
    assert ik.check(impact).agrees
    assert "controlled hinge" in ik.report(impact)


def test_in_a_motion_the_motor_holds_at_impacts_alone():
    """The hinge swings freely before and after the floor is struck; there it keeps its speed."""
    body = two_bodies("freeflyer")
    q = body.configuration(root_joint=[0, 0, 0.4, 0.5, 0.5, 0.5, 0.5], hinge=[0.8, 0.6])
    floor = [ik.Contact("far", at=[LENGTH, 0, 0], restitution=0.5, friction=0.0)]
    v = body.velocity(root_joint=[0, 0, 0, 0, 0, 1.0], hinge=-2.0)
    stiff, free = (
        ik.simulate(ik.Scene(body, contacts=floor, controlled=held), q, v, duration=0.6)
        for held in (["hinge"], [])
    )
    (time, impact), (other_time, loose) = stiff.impacts[0], free.impacts[0]
    assert time == other_time
    assert impact.dv[-1] == pytest.approx(0.0, abs=1e-13) != loose.dv[-1]
    assert np.array_equal(impact.v_before, loose.v_before)
    assert impact.contacts[0].impulse[2] > 1.01 * loose.contacts[0].impulse[2]
    # Behind the impact the hinge goes on as forces and inertia have it.
    assert abs(stiff.at(time + 0.05)[1][-1] - impact.v_after[-1]) > 1e-3


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_a_controlled_joint_yields_to_its_own_stop_and_the_others_do_not(restitution):
    """At the stop the joint turns back at e times its speed; elsewhere its control holds."""
    panda = ik.Robot.from_example("panda")
    upper = float(panda.model.upperPositionLimit[3])
    stop = ik.JointStop("panda_joint4", restitution=restitution)
    scene = ik.Scene(panda, contacts=[stop], controlled=ARM)
    q = panda.configuration(panda_joint4=upper)
    v = panda.velocity(panda_joint2=0.3, panda_joint4=2.0, panda_joint6=-1.0)
    impact = ik.solve(scene, q, v)
    assert impact.status is ik.Status.SOLVED and impact.is_valid()
    # The others keep theirs, so the joint and its stop are alone.
    wanted = v.copy()
    wanted[3] = -restitution * 2.0
    close(impact.v_after[:7], wanted[:7], 1e-13)
    masses = mass_matrix(panda.model, q)
    # The fingers are free, so what counts is the composite arm's own inertia less theirs.
    fingers = masses[7:, 7:]
    effective = masses[3, 3] - masses[3, 7:] @ np.linalg.solve(fingers, masses[7:, 3])
    carried = abs(impact.contacts[0].impulse[-1])
    assert carried == pytest.approx((1 + restitution) * 2.0 * effective, rel=1e-12)
    assert ik.check(impact).agrees
    outputs = ("v_after", "constraint_impulses")
    batch = ik.solve_batch(scene, np.array([q, q]), np.array([v, -v]), outputs=outputs)
    assert batch.constraint_impulses[0, 3] == 0.0, "the stop bears it all"
    close(batch.v_after[0], impact.v_after, 1e-13)
    # Away from the stop, and at it without approaching, the control holds.
    close(batch.v_after[1], -v, 1e-13)
    leaving = ik.solve(scene, q, -v)
    assert "controlled panda_joint4" in [each.name for each in leaving.constraints]
