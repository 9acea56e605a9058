"""Contacts on robots: what the laws say, in the coordinates of a scene."""

from __future__ import annotations

import math

import numpy as np
import pytest

import impulsekit as ik


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("theta", [0.0, 0.4, 1.0, 1.4])
def test_a_falling_rod_meets_the_floor(theta, e):
    """P = (1 + e) m v / (1 + 3 cos²θ), with θ the slope of the rod."""
    mass, length, speed = 1.3, 0.7, 2.1
    rod = ik.Robot.from_urdf(ik.models.chain_urdf(1, mass, length), root="planar")
    # The floor is the line y = 0 of the rod's plane; its far end is lowest.
    q = rod.configuration(root_joint=[0.0, length * math.sin(theta), -theta])
    turned = np.array([[math.cos(-theta), math.sin(-theta)], [-math.sin(-theta), math.cos(-theta)]])
    v = np.array([*(turned @ [0.0, -speed]), 0.0])
    floor = ik.Contact("link_1", at=[length, 0, 0], normal=[0, 1, 0], restitution=e)
    impact = ik.solve(ik.Scene(rod, contacts=[floor]), q, v)
    exact = (1 + e) * mass * speed / (1 + 3 * math.cos(theta) ** 2)
    np.testing.assert_allclose(impact.contacts[0].impulse, [0, exact, 0], atol=1e-13 * exact)
    assert impact.contacts[0].velocity_after[1] == pytest.approx(e * speed, abs=1e-13)


@pytest.mark.parametrize("order", ["simultaneous", "sequential"])
@pytest.mark.parametrize("mu", [0.0, 0.5])
@pytest.mark.parametrize("count", [1, 2])
def test_what_is_held_wholly_bears_no_contact(count, mu, order):
    """Once a box is stopped on all sides, its contacts have nothing left to do."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    contacts = [ik.Contact("box", at=[0.1 * i, 0, -0.1], friction=mu) for i in range(count)]
    lock = ik.JointLock("root_joint")
    scene = ik.Scene(box, constraints=[lock], contacts=contacts, law=ik.Law(order=order))
    v = box.velocity(root_joint=[0.1, 0, -1, 0, 0, 0])
    impact = ik.solve(scene, box.neutral(), v)
    assert impact.status is ik.Status.SOLVED
    assert np.abs(impact.v_after).max() < 1e-15
    assert np.array([contact.impulse for contact in impact.contacts]) == pytest.approx(0, abs=0)
