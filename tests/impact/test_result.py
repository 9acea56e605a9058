"""Everything behind Δv: link jumps, momentum, energy, residuals."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import impulsekit as ik
from tests.robots import random_blow, random_state


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
