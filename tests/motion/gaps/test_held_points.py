"""Corners on faces and edges that cross, followed as both bodies move."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.motion.course.present import Present
from impulsekit.scene.motion import MotionSettings

from ..models import MODELS


def touching(kind, seed):
    """Two free boxes that touch, on a corner or edge on edge, and a motion of both."""
    rng = np.random.default_rng(seed)
    box = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
    robot = ik.combine(a=box, b=box)
    tilt = (0.6, 0.5, 0.2) if kind == "corner" else (0.0, np.pi / 4, 0.1)
    turns = [pin.rpy.rpyToMatrix(*tilt), pin.rpy.rpyToMatrix(0 if kind == "corner" else 0.7, 0, 0)]
    turns = [turn @ pin.exp3(0.1 * rng.normal(size=3)) for turn in turns]
    places = [[0.01, 0.02, 0.4], [0, 0, 0]]
    if kind == "corner of the other":
        turns.reverse()
        # The upper corner of the lower box, under the middle of the upper one.
        half = np.array([0.15, 0.1, 0.05])
        corners = half * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners = corners @ turns[1].T
        places[0][:2] = corners[corners[:, 2].argmax()][:2]
    if kind == "corner":
        places[1][:2] = 0.1, 0.1
    scene = ik.Scene(robot, contacts=[ik.Collision("a/box", "b/box", friction=0.3)])

    def state(height):
        places[0][2] = height
        joints = {
            f"{name}/root_joint": [*place, *pin.Quaternion(turn).coeffs()]
            for name, place, turn in zip("ab", places, turns, strict=True)
        }
        return robot.configuration(joints)

    v = rng.normal(size=robot.model.nv)
    now = Present(scene, state(0.4), v, MotionSettings())
    low, high = 0.05, 0.4
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = now.gaps.everything(state(middle), v)[0][0] < 0.0
        low, high = (middle, high) if inside else (low, middle)
    now.q = state(high)
    item = now.gaps.items[0]
    pin.forwardKinematics(now.model, now.gaps.data, now.q)
    item.hold(now.gaps.data)
    # The bodies neither part nor press on each other.
    normal = item.rows(data_at(now.model, now.q), now.q)[2]
    now.v = v - normal * (normal @ v) / (normal @ normal)
    return now, item


def data_at(model, q, v=None):
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    if v is not None:
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    return data


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["corner", "corner of the other", "edges"])
def test_rows_and_their_rates_are_those_of_the_gap(kind, seed):
    now, item = touching(kind, seed)
    model, q, v = now.model, now.q, now.v
    assert len(item.held_gaps(data_at(model, q))) == 1
    h = 1e-5
    ends = [pin.integrate(model, q, sign * h * v) for sign in (1, -1)]
    data = [data_at(model, end) for end in ends]
    rate = (item.held_gaps(data[0]) - item.held_gaps(data[1]))[0] / (2 * h)
    here = data_at(model, q, v)
    rows = item.rows(here, q)
    assert rate == pytest.approx(rows[2] @ v, abs=1e-8)
    bias = (item.rows(data[0], ends[0]) @ v - item.rows(data[1], ends[1]) @ v) / (2 * h)
    np.testing.assert_allclose(item.bias(here, q, v, rows), bias, rtol=0, atol=1e-6)


@pytest.mark.parametrize("kind", ["corner", "edges"])
def test_the_gap_held_is_the_gap_of_the_bodies_as_long_as_nothing_else_touches(kind):
    now, item = touching(kind, 1)
    for time in (-1e-3, 1e-4, 1e-3):
        data = data_at(now.model, pin.integrate(now.model, now.q, time * now.v))
        assert item.held_gaps(data)[0] == pytest.approx(item.distance(data), abs=1e-14)
        assert item.held_inside(data)[0] > 1e-3
