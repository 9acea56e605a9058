"""Tips and corners that touch a half-space: their gaps, and the rates of their rows."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from impulsekit.geometry.collision import solid_of
from impulsekit.geometry.held_pieces import can_be_held, polyhedra_in_joint, round_or_endless
from impulsekit.geometry.held_points import gaps_and_ends
from impulsekit.geometry.held_tips import held_tips
from impulsekit.geometry.point_table import table_of
from impulsekit.motion.tree.memory import Memory
from impulsekit.motion.tree.pressed import rows_and_bias

SHAPES = {
    "ellipsoid": coal.Ellipsoid(0.3, 0.11, 0.05),
    "box": coal.Box(0.4, 0.3, 0.2),
    "capsule": coal.Capsule(0.1, 0.4),
}


def two_free_bodies():
    model = pin.Model()
    for name in ("body", "ground"):
        model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name)
    return model


def piece_of(shape, place):
    solid = solid_of(shape)
    return polyhedra_in_joint([(solid, place)])[0] or round_or_endless(solid, place)


def looked_at(memory, model, q, v, row):
    pin.forwardKinematics(model, memory.data, q, v, np.zeros(model.nv))
    pin.computeJointJacobians(model, memory.data, q)
    return rows_and_bias(table_of([row]), memory.kinematics)


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_rates_over_a_half_space_that_moves_are_those_of_the_rows(name, swapped):
    model, rng = two_free_bodies(), np.random.default_rng(11)
    memory = Memory(model)
    for _ in range(5):
        own, there = (pin.SE3.Random() for _ in range(2))
        body = piece_of(SHAPES[name], own)
        ground = piece_of(coal.Halfspace(np.array([0.0, 0.6, 0.8]), 0.1), there)
        assert can_be_held(body, ground) and ground.is_endless
        q = np.concatenate([pin.SE3ToXYZQUAT(pin.SE3.Random()) for _ in range(2)])
        v = rng.normal(size=model.nv)
        pin.forwardKinematics(model, memory.data, q)
        both, joints = ([body, ground], (1, 2)) if not swapped else ([ground, body], (2, 1))
        places = [memory.data.oMi[j] for j in joints]
        # Moved along the normal until it just touches.
        gap = min(gaps_and_ends(held_tips(both, places, 1e3, (0, 0)), places)[0])
        q[:3] -= gap * places[joints.index(2)].rotation.dot(ground.normals[0])
        pin.forwardKinematics(model, memory.data, q)
        (tip,) = held_tips(both, places, 1e-9, (0, 0))
        assert abs(gaps_and_ends([tip], places)[0, 0]) < 1e-13
        row = tip.row(joints)
        rows, bias = (found.copy() for found in looked_at(memory, model, q, v, row))
        speeds, gaps, step = [], [], 1e-5
        for sign in (1.0, -1.0):
            moved = pin.integrate(model, q, sign * step * v)
            speeds.append(looked_at(memory, model, moved, v, row)[0].dot(v))
            gaps.append(gaps_and_ends([tip], [memory.data.oMi[j] for j in joints])[0, 0])
        rate = (speeds[0] - speeds[1]) / (2.0 * step)
        np.testing.assert_allclose(bias, rate, rtol=0, atol=1e-7 * np.abs(rate).max())
        assert abs((gaps[0] - gaps[1]) / (2.0 * step) - rows.dot(v)[2]) < 1e-8


def test_a_box_flat_on_a_half_space_touches_with_four_corners():
    body = piece_of(SHAPES["box"], pin.SE3.Identity())
    ground = piece_of(coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0), pin.SE3.Identity())
    places = [pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.1])), pin.SE3.Identity()]
    held = held_tips([body, ground], places, 1e-9, (0, 0))
    assert len(held) == 4
    gaps, inside = gaps_and_ends(held, places)
    assert np.abs(gaps).max() < 1e-15
    # A half-space has no end.
    assert (inside == np.inf).all()
