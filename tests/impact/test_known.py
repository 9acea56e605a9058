"""Known impulses on real robots: M Δv = I, and nothing is lost or made on the way."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from tests.reference.models import mass_matrix
from tests.robots import STRUCK, random_blow, random_state, relative


@pytest.mark.parametrize("axes", ["world", "local"])
@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
@pytest.mark.parametrize("name", STRUCK)
def test_mass_matrix_times_jump_is_the_generalized_impulse_to_1e_14(name, root, axes):
    robot = ik.Robot.from_example(name, root=root)
    for seed in range(2):
        q, v = random_state(robot, seed)
        impact = ik.solve(ik.Scene(robot, [random_blow(STRUCK[name], seed, axes)]), q, v)
        jump = mass_matrix(robot.model, q) @ impact.dv
        assert relative(jump - impact.generalized_impulse, impact.generalized_impulse) < 1e-14
        assert impact.residuals.momentum < 1e-14
        assert impact.status is ik.Status.SOLVED
        assert impact.is_valid()


@pytest.mark.parametrize("name", STRUCK)
def test_a_floating_robot_gains_the_impulse_and_its_moment(name):
    robot = ik.Robot.from_example(name, root="freeflyer")
    for seed in range(2):
        q, v = random_state(robot, seed)
        blow = random_blow(STRUCK[name], seed)
        impact = ik.solve(ik.Scene(robot, [blow]), q, v)
        data = robot.model.createData()
        jump = pin.computeCentroidalMomentum(robot.model, data, q, impact.dv).vector
        point = robot.placement(q, blow.frame).point(blow.at)
        linear = np.array(blow.linear)
        moment = np.array(blow.angular) + np.cross(point - data.com[0], linear)
        assert relative(jump[:3] - linear, linear) < 1e-13
        assert relative(jump[3:] - moment, moment) < 1e-13


@pytest.mark.parametrize("name", ["panda", "solo12"])
def test_impulses_add_up(name):
    robot = ik.Robot.from_example(name, root="freeflyer")
    q, v = random_state(robot, 3)
    joint = robot.joint_names[-1]
    entries = [
        random_blow(STRUCK[name], 1),
        random_blow(STRUCK[name], 2, "local"),
        random_blow(robot.links[0].name, 3),
        ik.JointImpulse(joint, 0.4),
    ]
    together = ik.solve(ik.Scene(robot, entries), q, v)
    alone = [ik.solve(ik.Scene(robot, [entry]), q, v) for entry in entries]
    assert relative(sum(i.dv for i in alone) - together.dv, together.dv) < 1e-13
    assert sum(together.energy.work.values()) == pytest.approx(together.energy.change, rel=1e-12)


def test_a_joint_impulse_acts_along_its_own_generalized_speed():
    robot = ik.Robot.from_example("panda")
    q, v = random_state(robot, 0)
    impact = ik.solve(ik.Scene(robot, [ik.JointImpulse("panda_joint3", 0.7)]), q, v)
    expected = np.zeros(9)
    expected[2] = 0.7
    np.testing.assert_array_equal(impact.generalized_impulse, expected)
    np.testing.assert_allclose(mass_matrix(robot.model, q) @ impact.dv, expected, atol=1e-14)


def test_a_robot_a_thousand_kilometres_away_is_hit_the_same():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    q, v = random_state(robot, 0)
    far = q.copy()
    far[:3] += 1e6
    scene = ik.Scene(robot, [random_blow("FR_FOOT", 1)])
    near_dv, far_dv = ik.solve(scene, q, v).dv, ik.solve(scene, far, v).dv
    assert relative(far_dv - near_dv, near_dv) < 1e-13


def test_mimic_joints_take_their_share():
    """The jump of the coupled system is that of the free one on the coupled speeds."""
    coupled = ik.Robot.from_example("panda", mimic=True)
    free = ik.Robot.from_example("panda")
    blow = random_blow("panda_leftfinger", 4)
    q, v = random_state(coupled, 2)
    impact = ik.solve(ik.Scene(coupled, [blow]), q, v)
    spread = np.zeros((9, 8))
    spread[:8] = np.eye(8)
    spread[8, 7] = 1.0
    # Pinocchio's finger joints follow one to one.
    whole = ik.solve(ik.Scene(free, [blow]), spread @ q, spread @ v)
    masses = spread.T @ mass_matrix(free.model, spread @ q) @ spread
    expected = np.linalg.solve(masses, spread.T @ whole.generalized_impulse)
    np.testing.assert_allclose(impact.dv, expected, rtol=1e-10, atol=1e-13)
    assert impact.is_valid()


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
@pytest.mark.parametrize("seed", range(2))
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
