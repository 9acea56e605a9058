"""Impulses and velocities whose products would leave the doubles."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.bench.stress.bodies import Link, robot_of

BOX = (0.4, 0.2, 0.1)


def _jump(size):
    links = [Link(-1, 1.0, BOX), Link(0, 2.0, BOX)]
    robot = robot_of(links, "freeflyer")
    blow = ik.AppliedImpulse("link_1", linear=[size, -0.5 * size, 0.25 * size], at=[0.1, 0.2, 0])
    kick = ik.JointImpulse("joint_1", 0.125 * size)
    return ik.solve(ik.Scene(robot, [blow, kick]), robot.neutral(), robot.velocity()).dv


@pytest.mark.parametrize("power", [-1020, -700, 300])
def test_blows_of_any_size_make_the_same_motion_in_proportion(power):
    size = 2.0**power
    assert np.abs(_jump(size) / size - _jump(1.0)).max() < 1e-15


def test_denormal_blows_are_answered_to_the_spacing_of_denormals():
    smallest = 5e-324
    size = 2.0**-1060
    assert np.abs(_jump(size) - size * _jump(1.0)).max() <= smallest


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge"])
@pytest.mark.parametrize("power", [-900, -600, 500])
def test_a_ball_bounces_alike_at_any_speed(law, power):
    ball = robot_of([Link(-1, 0.5, (0.1, 0.1, 0.1))], "freeflyer")
    floor = ik.Contact("link_0", at=[0.05, 0, -0.05], restitution=0.5, friction=0.3)
    scene = ik.Scene(ball, contacts=[floor], law=ik.Law(law, "path"))
    v = np.array([1.0, 0.2, -2.0, 0.1, 0.0, 0.3])
    speed = 2.0**power
    slow = ik.solve(scene, ball.neutral(), speed * v)
    assert slow.outcome.contacts.status is ik.Status.SOLVED
    usual = ik.solve(scene, ball.neutral(), v)
    assert np.abs(slow.v_after / speed - usual.v_after).max() < 1e-15


def test_the_slowest_approach_without_friction_is_no_rest():
    ball = robot_of([Link(-1, 0.5, (0.1, 0.1, 0.1))], "freeflyer")
    floor = ik.Contact("link_0", at=[0.05, 0, -0.05], restitution=0.5)
    v = np.array([1.0, 0.0, -1e-300, 0.0, 0.0, 0.0])
    impact = ik.solve(ik.Scene(ball, contacts=[floor]), ball.neutral(), v)
    assert impact.status is ik.Status.SOLVED
    assert impact.velocity_at("link_0", [0.05, 0, -0.05]).after[2] == pytest.approx(
        5e-301, rel=1e-14
    )
