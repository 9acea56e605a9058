"""Joints and velocities that are driven in time, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.errors import InputError, RangeError

G = 9.81
W, A = 10.0 * math.pi, 0.01


def ball_over_table(axis="0 0 1"):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    move = joint_text("move", "prismatic", "base", "plate", axis, far=9)
    table = robot_text("table", link_text("base"), link_text("plate", 2, 0.1), move)
    return ik.combine(ball=ball, table=ik.Robot.from_urdf(table))


def start(robot, height):
    return robot.configuration(**{"ball/root_joint": [0, 0, height, 0, 0, 0, 1]}), robot.velocity()


def bounces(height, e, duration):
    """Times of impacts of a ball on a plate at A sin ωt: its parabolas cut by brentq."""
    z, v, t, times = height, 0.0, 0.0, []
    while True:

        def gap(s, z=z, v=v, t=t):
            return z + v * (s - t) - 0.5 * G * (s - t) ** 2 - A * math.sin(W * s)

        s = t + 1e-3
        while gap(s) > 0.0:
            s += 1e-3
        s = brentq(gap, s - 1e-3, s, xtol=1e-15)
        if s > duration:
            return times
        plate = A * W * math.cos(W * s)
        v, z, t = plate - e * (v - G * (s - t) - plate), A * math.sin(W * s), s
        times.append(s)


@pytest.mark.slow
@pytest.mark.parametrize("way", ["position", "rates", "velocity"])
def test_ball_on_a_vibrating_table(way):
    robot, e = ball_over_table(), 0.8
    rates = [lambda t: A * W * math.cos(W * t), lambda t: -A * W * W * math.sin(W * t)]
    held = {
        "position": ik.Driven("table/move", lambda t: A * math.sin(W * t)),
        "rates": ik.Driven("table/move", lambda t: A * math.sin(W * t), *rates),
        "velocity": ik.JointLock("table/move", velocity=rates[0]),
    }[way]
    floor = ik.Contact("ball/ball", against="table/plate", restitution=e, name="plate")
    scene = ik.Scene(robot, constraints=[held], contacts=[floor])
    motion = ik.simulate(scene, *start(robot, 0.1), duration=0.9)
    right = bounces(0.1, e, 0.9)
    # The first is the plate's start from rest.
    seen = [t for t, _ in motion.impacts][1:]
    assert len(seen) == len(right) == 4
    np.testing.assert_allclose(seen, right, atol=3e-9)
    assert ik.check(motion.impacts[1][1]).agrees
    # What drives it carries the plate and makes it faster.
    if way == "rates":
        force = motion.constraints["constraints[0]"].force(0.05)
        np.testing.assert_allclose(force, 2.0 * (G + rates[1](0.05)), rtol=1e-9)


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


def test_a_conveyor_brings_a_box_up_to_speed():
    """Friction makes the box as fast as the belt after u/µg, having slipped u²/2µg."""
    robot, belt, mu = ball_over_table("1 0 0"), 0.7, 0.4
    drive = ik.Driven("table/move", lambda t: belt * t, lambda t: belt, lambda t: 0.0)
    touch = ik.Contact("ball/ball", against="table/plate", friction=mu, name="belt")
    scene = ik.Scene(robot, constraints=[drive], contacts=[touch])
    q, v = start(robot, 0.0)
    v = v.copy()
    v[-1] = belt
    motion = ik.simulate(scene, q, v, duration=0.5)
    # The contact is at the ball's centre: nothing turns it.
    slipped = belt**2 / (2 * mu * G)
    np.testing.assert_allclose(motion.q[-1][0], belt * 0.5 - slipped, atol=1e-9)
    np.testing.assert_allclose(motion.v[-1][0], belt, atol=1e-9)
    np.testing.assert_allclose(motion.contacts["belt"].force(0.05)[0], mu * G * 0.5, rtol=1e-9)


def test_solve_takes_what_is_driven_at_zero():
    robot = ball_over_table()
    scene = ik.Scene(robot, constraints=[ik.JointLock("table/move", velocity=lambda t: 3 + t)])
    q, v = start(robot, 1.0)
    impact = ik.solve(scene, q, v)
    assert impact.v_after[-1] == 3.0
    np.testing.assert_allclose(impact.constraints[0].impulse, [6.0])
    batch = ik.solve_batch(scene, np.stack([q, q]), np.stack([v, v]))
    np.testing.assert_allclose(batch.v_after[:, -1], 3.0)


@pytest.mark.parametrize(
    "drive",
    [
        ik.Driven("table/move", lambda t: 0.3 * t),
        ik.JointLock("table/move", velocity=lambda t: 0.3 + t),
    ],
)
def test_what_is_driven_is_judged_and_reported(drive):
    """All that follows from v⁺ takes the velocities of time 0, too."""
    robot = ball_over_table()
    scene = ik.Scene(robot, constraints=[drive])
    q, v = start(robot, 1.0)
    impact = ik.solve(scene, q, v)
    assert impact.is_valid() and impact.residuals.constraint < 1e-15
    assert impact.to_dict()["status"] == "SOLVED"
    assert ik.check(impact).agrees and ik.derivatives(impact).status.exists
    np.testing.assert_allclose(impact.energy.change, 0.5 * 2.0 * 0.3**2, rtol=1e-14)


def test_rates_are_differences_without_aliases():
    """Also of functions with the period of a step that is tried."""
    for w in (0.1, 3.0, W, 10 * W):
        drive = ik.Driven("j", lambda t, w=w: math.sin(w * t))
        for t in (0.0, 0.3, 2.0):
            assert drive.rate(t) == pytest.approx(w * math.cos(w * t), abs=1e-9 * (1 + w))
            assert drive.rate(t, 2) == pytest.approx(
                -w * w * math.sin(w * t), abs=3e-7 * (1 + w * w)
            )


def test_what_is_refused():
    robot = ball_over_table()
    with pytest.raises(RangeError, match="the derivative of position"):
        ik.Driven("table/move", math.sin, velocity=math.sin)
    with pytest.raises(InputError, match="position must be a function of time"):
        ik.Driven("table/move", 1.0)
    with pytest.raises(InputError, match="takes a joint with one"):
        ik.Scene(robot, constraints=[ik.Driven("ball/root_joint", math.sin)])
    scene = ik.Scene(robot, constraints=[ik.Driven("table/move", math.cos)])
    with pytest.raises(InputError, match=r"begins -1 \(rad or m\) beside where it is driven"):
        ik.simulate(scene, *start(robot, 1.0), duration=0.1)
