"""Impulses and velocities whose products would leave the doubles."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.stress.bodies import Link, robot_of

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


def test_a_batch_says_where_numbers_are_denormal():
    robot = robot_of([Link(-1, 1.0, BOX), Link(0, 2.0, BOX)], "freeflyer")
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_1", linear=[1, 0, 0], at=[0.1, 0.2, 0])])
    sizes = np.array([1e-316, 1e-300, 0.0])
    blows = sizes[:, None] * np.array([1.0, -0.5, 0.25])
    q, v = np.tile(robot.neutral(), (3, 1)), np.zeros((3, robot.nv))
    batch = ik.solve_batch(scene, q, v, impulses=blows)
    assert [ik.Status(code).name for code in batch.status] == ["INACCURATE", "SOLVED", "SOLVED"]


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


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_velocities_whose_squares_overflow_are_solved_by_a_blow_alone():
    ball = robot_of([Link(-1, 0.5, (0.1, 0.1, 0.1))], "freeflyer")
    q, v = ball.neutral(), 1e155 * np.array([1.0, 0.2, -2.0, 0.1, 0.0, 0.3])
    blow = ik.Scene(ball, [ik.AppliedImpulse("link_0", linear=[0, 0, 1.0])])
    impact = ik.solve(blow, q, v)
    assert np.abs(impact.v_after - v).max() < 100.0
    with pytest.raises(ik.errors.RangeError, match="velocities must be such that their energy"):
        _ = impact.energy
    for points in (1, 2):
        contacts = [
            ik.Contact("link_0", at=[x, 0, 0], origin=[x, 0, 0], restitution=0.5, friction=0.3)
            for x in (0.05, -0.02)[:points]
        ]
        scene = ik.Scene(ball, contacts=contacts)
        for call in (ik.solve, ik.solve_batch):
            with pytest.raises(ik.errors.RangeError, match=r"entry must be 1e\+153 at most"):
                call(scene, q, v)
        given = np.array([v, 1e-155 * v, np.full(6, np.nan), 1e-155 * v])
        rows = ik.solve_batch(scene, q, given)
        assert rows.status[0] == ik.Status.OUT_OF_RANGE
        assert rows.valid.tolist() == [False, True, False, True] and given[0, 2] == v[2]
