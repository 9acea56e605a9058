"""Answers where numbers are at their worst: light beside heavy, far away, all but dependent."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.stress.bodies import Link, robot_of

BOX = (0.4, 0.2, 0.1)


def _pair(ratio):
    """Two boxes on a hinge, the second so many times as heavy as the first."""
    links = [
        Link(-1, 1.0, BOX),
        Link(0, ratio, BOX, "revolute", (0.0, 0.6, 0.8), (0.4, 0.05, 0.0), (0.3, 0.2, 0.1)),
    ]
    robot = robot_of(links, "freeflyer")
    q = robot.configuration(joint_1=0.7)
    v = np.array([0.3, -0.2, -1.0, 0.2, 0.4, -0.3, 0.5])
    return robot, q, v


@pytest.mark.parametrize("distance", [1e3, 1e6, 1e9])
def test_a_grip_within_a_robot_is_the_same_wherever_the_robot_is(distance):
    robot, q, v = _pair(2.0)
    grip = ik.PointAnchor("link_1", "link_0", at=[0.2, 0.1, 0])
    contact = ik.Contact("link_1", at=[0.1, 0, 0], against="link_0", friction=0.3)
    for scene in (
        ik.Scene(robot, constraints=[grip]),
        ik.Scene(robot, contacts=[contact]),
    ):
        here = ik.solve(scene, q, v)
        away = q.copy()
        away[:3] = distance * np.array([0.6, -0.3, 0.7])
        there = ik.solve(scene, away, v)
        assert there.status is here.status
        assert there.is_valid()
        assert np.array_equal(there.dv, here.dv)


def test_a_body_against_the_world_still_knows_where_it_is():
    box = robot_of([Link(-1, 1.0, BOX)], "freeflyer")
    pair = ik.combine(a=box, b=box)
    # A point of the world, and where a body has it, is another one when the body moves.
    hinge = ik.PointAnchor("world", "a/link_0", at=[1.0, 0, 0])
    scene = ik.Scene(pair, constraints=[hinge])
    v = np.zeros(12)
    v[5] = 1.0  # a turns about z
    jumps = []
    for x in (0.0, 0.5):
        q = pair.neutral()
        q[0] = x
        jumps.append(ik.solve(scene, q, v).dv)
    assert not np.allclose(*jumps)


@pytest.mark.parametrize("ratio", [1e-6, 1e6, 1e8])
def test_contacts_on_light_and_heavy_bodies_end_at_rounding_level(ratio):
    robot, q, v = _pair(ratio)
    contacts = [
        ik.Contact("link_0", at=[0.1, 0.1, 0.05], friction=0.4),
        ik.Contact("link_1", at=[0.3, 0, -0.05], friction=0.4, restitution=0.5),
        ik.JointStop("joint_1", lower=2.0, restitution=0.3),
    ]
    v[6] = -0.5  # into the stop
    impact = ik.solve(ik.Scene(robot, contacts=contacts), q, v)
    assert impact.status is ik.Status.SOLVED
    assert impact.residuals.complementarity < 1e-11
    assert any(contact.impulse[-1] > 0 for contact in impact.contacts)
