"""Two bodies that meet: points, normals and gaps from coal, made exact where they just touch."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.geometry.collision import gap_and_normal, meeting_points, solid_of

BOX, SLAB = coal.Box(1, 1, 1), coal.Box(4, 4, 1)
SPHERE, CAN, PILL = coal.Sphere(0.5), coal.Cylinder(0.5, 1), coal.Capsule(0.5, 1)


def at(x: float, y: float, z: float, rotation: np.ndarray | None = None) -> pin.SE3:
    return pin.SE3(np.eye(3) if rotation is None else rotation, np.array([x, y, z]))


def meet(shape, placement, other=SLAB, other_placement=None, margin=1e-6):
    second = [(solid_of(other), other_placement or at(0, 0, 0))]
    return list(meeting_points([(solid_of(shape), placement)], second, margin))


LYING = pin.utils.rotate("y", np.pi / 2)


@pytest.mark.parametrize("gap", [-1e-9, 0.0, 1e-9, 1e-7, -1e-5])
@pytest.mark.parametrize(
    ("shape", "placement", "count"),
    [
        (BOX, at(0.3, 0.2, 1.0), 4),
        (BOX, at(0.3, 0.2, 1.0, pin.utils.rotate("z", 0.4)), 4),
        (SPHERE, at(0.3, 0.2, 1.0), 1),
        (CAN, at(0.3, 0.2, 1.0), 8),
        (PILL, at(0.3, 0.2, 1.0, LYING), 2),
    ],
)
def test_bodies_that_just_touch_have_an_exact_normal(shape, placement, count, gap):
    lifted = pin.SE3(placement.rotation, placement.translation + np.array([0, 0, gap]))
    points = meet(shape, lifted)
    assert len(points) == count
    for point in points:
        np.testing.assert_allclose(point.normal, [0, 0, 1], atol=1e-8)
        assert point.gap == pytest.approx(gap, abs=2e-8)
        assert point.position[2] == pytest.approx(0.5 + gap / 2, abs=1e-7)


def test_the_normal_points_from_the_second_to_the_first():
    there = meet(SPHERE, at(0, 0, 1.0))[0]
    back = meet(SLAB, at(0, 0, 0), SPHERE, at(0, 0, 1.0))[0]
    np.testing.assert_allclose(there.normal, -back.normal, atol=1e-12)
    np.testing.assert_allclose(there.position, back.position, atol=1e-9)


def test_what_is_apart_does_not_meet():
    assert meet(BOX, at(0, 0, 1.01)) == []
    apart, _ = gap_and_normal(solid_of(BOX), at(0, 0, 1.01), solid_of(SLAB), at(0, 0, 0))
    assert apart == pytest.approx(0.01)


@pytest.mark.parametrize("seed", range(5))
def test_two_balls_exchange_their_normal_velocities(seed):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    world = ik.combine(a=ball, b=ball)
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    place = np.array([0.3, -0.2, 0.5])
    q = world.configuration(
        {
            "a/root_joint": [*place, 0, 0, 0, 1],
            "b/root_joint": [*(place + 0.1 * direction), 0, 0, 0, 1],
        }
    )
    v = world.velocity({"a/root_joint": [*(2 * direction + [0, 0, 0.3]), 0, 0, 0]})
    scene = ik.Scene(world, contacts=[ik.Collision("a/ball", "b/ball", restitution=1.0)])
    impact = ik.solve(scene, q, v)
    along = (v[:3] @ direction) * direction
    np.testing.assert_allclose(impact.v_after[:3], v[:3] - along, atol=1e-10)
    np.testing.assert_allclose(impact.v_after[6:9], along, atol=1e-10)
    assert impact.energy.change == pytest.approx(0.0, abs=1e-10)


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
