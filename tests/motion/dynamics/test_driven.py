"""Joints and velocities that are driven in time, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text

G = 9.81
W, A = 10.0 * math.pi, 0.01


def ball_over_table(axis="0 0 1"):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    move = joint_text("move", "prismatic", "base", "plate", axis, far=9)
    table = robot_text("table", link_text("base"), link_text("plate", 2, 0.1), move)
    return ik.combine(ball=ball, table=ik.Robot.from_urdf(table))


def start(robot, height):
    return robot.configuration(**{"ball/root_joint": [0, 0, height, 0, 0, 0, 1]}), robot.velocity()


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-10, 5e-11])
def test_a_ball_lies_on_the_table_while_it_can(rtol):
    """At rest on the plate it leaves where the plate falls as fast as it would: sin ωt = g/Aω²."""
    robot = ball_over_table()
    w = 0.5 * W
    amplitude = 1.6 * G / w**2
    # A start without a jump of the velocity.
    smooth = ik.Driven("table/move", lambda t: amplitude * math.sin(w * t) ** 2 / 2)
    floor = ik.Contact("ball/ball", against="table/plate", name="plate")
    scene = ik.Scene(robot, constraints=[smooth], contacts=[floor])
    motion = ik.simulate(scene, *start(robot, 0.0), duration=0.2, rtol=rtol)
    # z = A sin²(ωt)/2, so that z̈ = A ω² cos(2ωt).
    leaves = math.acos(-G / (amplitude * w**2)) / (2 * w)
    (rest, *_) = motion.rests
    # It has left when it is 1e-8 m/s faster than the plate: 6e-6 s later.
    assert rest.start == 0.0 and rest.end == pytest.approx(leaves, abs=1e-5)


def test_solve_takes_what_is_driven_at_zero():
    robot = ball_over_table()
    scene = ik.Scene(robot, constraints=[ik.JointLock("table/move", velocity=lambda t: 3 + t)])
    q, v = start(robot, 1.0)
    impact = ik.solve(scene, q, v)
    assert impact.v_after[-1] == 3.0
    np.testing.assert_allclose(impact.constraints[0].impulse, [6.0])
    batch = ik.solve_batch(scene, np.stack([q, q]), np.stack([v, v]))
    np.testing.assert_allclose(batch.v_after[:, -1], 3.0)


def test_rates_are_differences_without_aliases():
    """Also of functions with the period of a step that is tried."""
    for w in (0.1, 3.0, W, 10 * W):
        drive = ik.Driven("j", lambda t, w=w: math.sin(w * t))
        for t in (0.0, 0.3, 2.0):
            assert drive.rate(t) == pytest.approx(w * math.cos(w * t), abs=1e-9 * (1 + w))
            assert drive.rate(t, 2) == pytest.approx(
                -w * w * math.sin(w * t), abs=3e-7 * (1 + w * w)
            )


def test_a_point_that_is_led_at_a_constant_velocity_is_where_it_leads():
    hammer = ik.Robot.from_urdf("models/hammer.urdf", root="freeflyer")
    place, velocity = np.array([0.1, 0.2, 0.0]), np.array([0.3, -0.2, 0.1])
    lead = ik.PointAnchor("handle", at=place, velocity=velocity)
    scene = ik.Scene(hammer, constraints=[lead], gravity=[0, 0, -G])
    rng = np.random.default_rng(2)
    q = pin.integrate(hammer.model, hammer.neutral(), rng.uniform(-0.5, 0.5, hammer.nv))
    motion = ik.simulate(scene, q, rng.normal(size=hammer.nv), duration=3.0, samples=31)
    assert motion.status.finished, motion.detail
    places = [hammer.placement(state, "handle").point(place) for state in motion.q]
    assert np.abs(places - places[0] - np.outer(motion.t, velocity)).max() < 1e-8
