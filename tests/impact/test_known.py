"""Known impulses on real robots: M Δv = I, and nothing is lost or made on the way."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from tests.robots import STRUCK, random_blow, random_state, relative


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["world", "local"])
@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
@pytest.mark.parametrize("name", STRUCK)
def test_mass_matrix_times_jump_is_the_generalized_impulse_to_1e_14(name, root, axes):
    robot = ik.Robot.from_example(name, root=root)
    for seed in range(5):
        q, v = random_state(robot, seed)
        impact = ik.solve(ik.Scene(robot, [random_blow(STRUCK[name], seed, axes)]), q, v)
        jump = impact.mechanics.mass_matrix @ impact.dv
        assert relative(jump - impact.generalized_impulse, impact.generalized_impulse) < 1e-14
        assert impact.residuals.momentum < 1e-14
        assert impact.status is ik.Status.SOLVED
        assert impact.is_valid()


@pytest.mark.parametrize("name", STRUCK)
def test_a_floating_robot_gains_the_impulse_and_its_moment(name):
    robot = ik.Robot.from_example(name, root="freeflyer")
    for seed in range(5):
        q, v = random_state(robot, seed)
        blow = random_blow(STRUCK[name], seed)
        impact = ik.solve(ik.Scene(robot, [blow]), q, v)
        data = robot.model.createData()
        jump = pin.computeCentroidalMomentum(robot.model, data, q, impact.dv).vector
        point = impact.mechanics.frame_placement(blow.frame).act(np.array(blow.at))
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
    np.testing.assert_allclose(impact.mechanics.mass_matrix @ impact.dv, expected, atol=1e-14)


@pytest.mark.parametrize("axes", ["world", "local"])
def test_both_algorithms_give_the_same_jump(axes):
    from impulsekit.impact.algorithms import ByAba, ByCrba
    from impulsekit.impact.known import KnownImpulses
    from impulsekit.rows.reach import reached_model

    robot = ik.Robot.from_example("talos", root="freeflyer")
    entries = [
        random_blow(STRUCK["talos"], 1, axes),
        random_blow("leg_left_6_link", 2, axes),
        random_blow("leg_left_6_link", 3, axes),
        ik.JointImpulse("leg_left_4_joint", 0.3),
    ]
    scene = ik.Scene(robot, entries)
    reached = reached_model(robot.model, range(1, robot.model.njoints))
    ways = [ByAba(KnownImpulses(scene, reached))]
    ways.append(ByCrba(KnownImpulses(scene, reached), always_regular=False))
    for seed in range(3):
        q, _ = random_state(robot, seed)
        aba, crba = (way.velocity_jump(q) for way in ways)
        assert relative(aba - crba, crba) < 1e-12


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
    mass_matrix = spread.T @ whole.mechanics.mass_matrix @ spread
    expected = np.linalg.solve(mass_matrix, spread.T @ whole.generalized_impulse)
    np.testing.assert_allclose(impact.dv, expected, rtol=1e-10, atol=1e-13)
    assert impact.is_valid()
