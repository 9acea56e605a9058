"""Two bodies that meet: points, normals and gaps from coal, made exact where they just touch."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik


def test_a_box_set_down_on_a_box_touches_at_four_corners():
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    world = ik.combine(upper=box, lower=box)
    q = world.configuration({"upper/root_joint": [0.05, 0, 0.1, 0, 0, 0, 1]})
    v = world.velocity({"upper/root_joint": [0, 0, -1, 0, 0, 0]})
    scene = ik.Scene(world, contacts=[ik.Collision("upper/box", "lower/box")])
    impact = ik.solve(scene, q, v)
    assert len(impact.contacts[0].points) == 4
    assert impact.is_valid()
    upper, lower = (impact.bodies[f"{name}/box"].dv_com for name in ("upper", "lower"))
    np.testing.assert_allclose(upper, -lower, atol=1e-12)
    lowest = min(point.velocity_after[2] for point in impact.contacts[0].points)
    assert lowest > -1e-10


def test_a_mesh_counts_as_its_convex_hull():
    panda = ik.Robot.from_example("panda")
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    world = ik.combine(arm=panda, ball=ball)
    arm_q = panda.configuration(panda_joint4=-1.5, panda_joint6=1.5)
    data = panda.model.createData()
    pin.framesForwardKinematics(panda.model, data, arm_q)
    hand = data.oMf[panda.frame_id("panda_hand")].translation
    scene = ik.Scene(world, contacts=[ik.Collision("ball/ball", "arm/panda_hand", restitution=0.5)])
    v = world.velocity({"ball/root_joint": [0, 0, -2, 0, 0, 0]})
    q = np.concatenate([arm_q, hand + np.array([0, 0, 5.0]), [0, 0, 0, 1]])
    assert not ik.solve(scene, q, v).contacts[0].touching
    # Let it down until it touches.
    high, low = 1.0, 0.0
    for _ in range(60):
        middle = 0.5 * (high + low)
        q[11] = hand[2] + middle
        touching = ik.solve(scene, q, v).contacts[0].touching
        low, high = (middle, high) if touching else (low, middle)
    q[11] = hand[2] + low
    impact = ik.solve(scene, q, v)
    point = impact.contacts[0].points[0]
    assert impact.is_valid()
    assert point.velocity_before @ point.normal < 0.0
    assert point.velocity_after @ point.normal == pytest.approx(
        -0.5 * (point.velocity_before @ point.normal), rel=1e-9
    )
    assert np.abs(impact.dv[:9]).max() > 0.0
