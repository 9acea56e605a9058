"""Everything behind Δv: link jumps, momentum, energy, residuals."""

from __future__ import annotations

import json
import math

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from tests.robots import STRUCK, random_blow, random_state


@pytest.mark.parametrize("name", STRUCK)
def test_link_jumps_are_differences_of_link_velocities(name):
    """Against the frames of Pinocchio, link by link, behind fixed joints too."""
    robot = ik.Robot.from_example(name, root="freeflyer")
    q, v = random_state(robot, 4)
    impact = ik.solve(ik.Scene(robot, [random_blow(STRUCK[name], 4)]), q, v)
    twists = []
    for velocity in (impact.v_before, impact.v_after):
        data = robot.model.createData()
        pin.forwardKinematics(robot.model, data, q, velocity)
        pin.updateFramePlacements(robot.model, data)
        twists.append(
            {
                link.name: pin.getFrameVelocity(
                    robot.model, data, link.frame_id, pin.LOCAL_WORLD_ALIGNED
                )
                for link in robot.links
            }
        )
    assert set(impact.bodies) == {link.name for link in robot.links}
    for link in robot.links:
        frame = robot.model.frames[link.frame_id]
        com_in_world_axes = data.oMi[link.joint_id].rotation @ (
            link.com_in_joint - frame.placement.translation
        )
        before, after = (
            twist[link.name].linear + np.cross(twist[link.name].angular, com_in_world_axes)
            for twist in twists
        )
        jump = impact.bodies[link.name]
        scale = 1.0 + np.abs(after).max()
        np.testing.assert_allclose(jump.dv_com, after - before, atol=1e-12 * scale)
        np.testing.assert_allclose(
            jump.domega, twists[1][link.name].angular - twists[0][link.name].angular, atol=1e-12
        )


def test_the_jumps_of_all_links_carry_the_momentum_of_the_blow():
    robot = ik.Robot.from_example("talos", root="freeflyer")
    blow = random_blow(STRUCK["talos"], 2)
    impact = ik.solve(ik.Scene(robot, [blow]), *random_state(robot, 2))
    momentum = sum(link.mass * impact.bodies[link.name].dv_com for link in robot.links)
    np.testing.assert_allclose(momentum, blow.linear, atol=1e-13)


def test_momentum_jumps_by_the_generalized_impulse():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    impact = ik.solve(ik.Scene(robot, [random_blow("FR_FOOT", 1)]), *random_state(robot, 1))
    np.testing.assert_allclose(
        impact.momentum_after - impact.momentum_before, impact.generalized_impulse, atol=1e-12
    )


@pytest.mark.parametrize("name", STRUCK)
def test_the_books_of_energy_close(name):
    robot = ik.Robot.from_example(name)
    entries = [
        random_blow(STRUCK[name], 1),
        ik.JointImpulse(robot.joint_names[0], 0.2, name="kick"),
    ]
    impact = ik.solve(ik.Scene(robot, entries), *random_state(robot, 3))
    energy = impact.energy
    assert set(energy.work) == {"impulses[0]", "kick"}
    assert energy.change == pytest.approx(energy.after - energy.before, rel=1e-9)
    assert energy.imbalance < 1e-14
    data = robot.model.createData()
    before = pin.computeKineticEnergy(robot.model, data, impact.q, impact.v_before)
    assert energy.before == pytest.approx(before, rel=1e-13)


def test_a_rod_struck_at_two_thirds_does_not_load_its_pivot():
    """The centre of percussion: the pivot feels nothing, the mass centre takes all."""
    mass, length, impulse = 2.0, 0.9, 3.0
    robot = ik.Robot.from_urdf(ik.models.pendulum_urdf(1, mass, length))
    for share, pivot in ((2 / 3, 0.0), (1.0, impulse / 2), (1 / 2, -impulse / 4)):
        blow = ik.AppliedImpulse("link_1", linear=[impulse, 0, 0], at=[0, 0, -share * length])
        impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
        reaction = mass * impact.bodies["link_1"].dv_com[0] - impulse
        assert reaction == pytest.approx(pivot, abs=1e-14)


def test_what_nobody_asks_for_is_not_computed():
    robot = ik.Robot.from_example("panda")
    impact = ik.solve(ik.Scene(robot, [random_blow("panda_hand", 0)]), *random_state(robot, 0))
    _ = impact.dv
    assert set(vars(impact)) == {"scene", "_q", "_v", "_dv", "_outcome"}


def test_a_spoilt_answer_says_so():
    robot = ik.Robot.from_example("panda")
    good = ik.solve(ik.Scene(robot, [random_blow("panda_hand", 0)]), *random_state(robot, 0))
    spoilt = ik.Impact(good.scene, good.q, good.v_before, good.dv * (1 + 1e-6))
    assert spoilt.status is ik.Status.INACCURATE
    assert not spoilt.is_valid()
    assert "rescale" in spoilt.status.value


def test_to_dict_is_ready_for_json():
    robot = ik.Robot.from_example("panda")
    impact = ik.solve(ik.Scene(robot, [random_blow("panda_hand", 0)]), *random_state(robot, 0))
    plain = json.loads(json.dumps(impact.to_dict(), allow_nan=False))
    assert plain["dv"] == impact.dv.tolist()
    assert plain["valid"] is True
    assert plain["bodies"]["panda_hand"]["domega"] == impact.bodies["panda_hand"].domega.tolist()


def test_velocities_of_points_are_asked_by_frame():
    robot = ik.Robot.from_example("panda")
    impact = ik.solve(ik.Scene(robot, [random_blow("panda_hand", 0)]), *random_state(robot, 0))
    with pytest.raises(ik.errors.UnknownNameError, match="panda_hand"):
        impact.velocity_at("panda_hadn")
    origin = impact.velocity_at("panda_hand")
    np.testing.assert_allclose(origin.change, origin.after - origin.before)


def test_an_answer_in_which_all_comes_to_rest_is_not_measured_by_its_rounding():
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(10), root="planar")
    blow = ik.AppliedImpulse("link_10", linear=[0, 5, 0], at=[1, 0, 0])
    for constraint in (ik.JointLock("joint_7"), ik.PointAnchor("link_1")):
        scene = ik.Scene(robot, [blow], constraints=[constraint])
        impact = ik.solve(scene, robot.neutral(), robot.velocity())
        assert impact.is_valid()
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    pressed = ik.Scene(
        ball,
        [ik.AppliedImpulse("ball", linear=[0, 0, -1 / 3])],
        contacts=[ik.Contact("ball", at=[0, 0, -0.05], friction=0.3)],
    )
    impact = ik.solve(pressed, ball.neutral(), ball.velocity())
    assert impact.is_valid()
    assert abs(impact.v_after).max() < 1e-15


def test_answers_of_one_scene_do_not_disturb_each_other():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [random_blow("panda_hand", 1)], [ik.JointLock("panda_joint2")])
    states = [random_state(robot, seed) for seed in (1, 2)]
    first, second = (ik.solve(scene, *state) for state in states)
    alone = ik.solve(ik.Scene(robot, scene.impulses, scene.constraints), *states[0])
    # Asked in turn, so that each finds the other's numbers in what they share.
    for name in ("mechanics", "energy", "residuals", "generalized_impulse", "reactions", "bodies"):
        getattr(first, name), getattr(second, name)
        second.velocity_at("panda_hand", [0, 0, 0.1])
    at_tip = [impact.velocity_at("panda_hand", [0, 0, 0.1]).after for impact in (first, alone)]
    assert np.array_equal(*at_tip)
    assert first.to_dict() == alone.to_dict()
    assert not np.array_equal(first.dv, second.dv)


@pytest.mark.parametrize("tol", ["x", None, -1.0, math.nan])
def test_a_tolerance_is_a_number_from_0_up(tol):
    robot = ik.Robot.from_urdf(ik.models.pendulum_urdf(1))
    impact = ik.solve(ik.Scene(robot), robot.neutral(), [1.0])
    assert impact.is_valid() and impact.is_valid(0)
    with pytest.raises(ik.errors.InputError, match="tol must be"):
        impact.is_valid(tol)
