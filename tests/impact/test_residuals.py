"""Residuals tell what is wrong from what is rounding."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.impact.residuals import momentum_residual

SLIDES = [pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ]
TURNS = [pin.JointModelRZ, pin.JointModelRY, pin.JointModelRX]


def body(rng, *, in_one):
    """A body on three slides and three hinges, in one composite joint or one after the other."""
    model, parent = pin.Model(), 0
    place = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
    if in_one:
        joint = pin.JointModelComposite()
        for kind in (*SLIDES, *TURNS):
            joint.addJoint(kind(), pin.SE3.Identity())
        parent = model.addJoint(0, joint, place, "joint")
    else:
        for k, kind in enumerate((*SLIDES, *TURNS)):
            own_place = pin.SE3.Identity() if k else place
            parent = model.addJoint(parent, kind(), own_place, f"joint_{k}")
    centre = rng.normal(size=3)
    inertia = pin.Inertia(2.0, centre, np.diag([0.1, 0.2, 0.25]))
    model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    frame = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
    model.addBodyFrame("body", parent, frame, 0)
    return ik.Robot.from_model(model), frame.inverse().act(centre)


@pytest.mark.parametrize("in_one", [True, False])
@pytest.mark.parametrize("seed", range(10))
def test_a_body_struck_through_its_mass_centre_does_not_turn_and_is_solved(seed, in_one):
    rng = np.random.default_rng(seed)
    robot, centre = body(rng, in_one=in_one)
    blow = ik.AppliedImpulse("body", linear=rng.normal(size=3), at=centre)
    scene = ik.Scene(robot, [blow])
    impact = ik.solve(scene, rng.uniform(-1, 1, robot.nq), robot.velocity())
    change = impact.bodies["body"]
    np.testing.assert_allclose(change.dv_com, np.array(blow.linear) / 2.0, atol=1e-14)
    np.testing.assert_allclose(change.domega, 0.0, atol=3e-14)
    assert impact.is_valid(1e-13)


@pytest.mark.parametrize("off", [1e-6, 1e-9])
def test_a_wrong_speed_of_a_light_finger_shows(off):
    """One millionth of the arm's mass hangs on the joint: its row is measured by its own size."""
    parts = [link_text("base")]
    for name, mass in (("arm", 10.0), ("finger", 1e-5)):
        parts.append(link_text(name, mass, 0.01 * mass, at="0.1 0 0"))
    for name, parent, child in (("shoulder", "base", "arm"), ("knuckle", "arm", "finger")):
        parts.append(joint_text(name, "continuous", parent, child, "0 0 1", at="0.2 0 0"))
    robot = ik.Robot.from_urdf(robot_text("r", *parts))
    scene = ik.Scene(robot, [ik.AppliedImpulse("arm", linear=[0, 1, 0], at=[0.1, 0, 0])])
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    assert momentum_residual(impact) < 1e-15
    wrong = impact.dv * [1.0, 1.0 + off]
    other = ik.Impact(scene, impact.q, impact.v_before, wrong)
    assert momentum_residual(other) > 0.05 * off
