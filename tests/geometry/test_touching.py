"""Shapes that touch: their gaps, normals and all their points, through a solve."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
BOX = ("box", "0.5 0.5 0.5")


def pair(*shapes):
    """Two bodies that fly, "a" and "b", with geometry "one" and "two" of a kind and sizes."""
    bodies = {}
    for name, geometry, (kind, sizes) in zip("ab", ("one", "two"), shapes, strict=True):
        bodies[name] = ik.Robot.from_mjcf(
            f'<mujoco><worldbody><body name="{name}"><freejoint name="free"/>'
            '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
            f'<geom name="{geometry}" type="{kind}" size="{sizes}"/></body></worldbody></mujoco>'
        )
    return ik.combine(**bodies)


def placed(robot, places):
    joints = {f"{n}/free": pin.SE3ToXYZQUAT(p) for n, p in zip("ab", places, strict=True)}
    return robot.configuration(joints)


def met(robot, places, margin=1e-6, order=("a/one", "b/two")):
    """The contact of the two at rest; within a margin they count as touching."""
    scene = ik.Scene(robot, contacts=[ik.Collision(*order, margin=margin)])
    return ik.solve(scene, placed(robot, places), np.zeros(12)).contacts[0]


@pytest.mark.parametrize(
    ("shape", "turn", "count"),
    [
        (BOX, np.eye(3), 4),
        (BOX, pin.utils.rotate("z", 0.4), 4),
        (("sphere", "0.5"), np.eye(3), 1),
        (("capsule", "0.5 0.5"), pin.utils.rotate("y", np.pi / 2), 2),
        (("cylinder", "0.5 0.5"), pin.utils.rotate("y", np.pi / 2), 2),
    ],
)
@pytest.mark.parametrize("gap", [-1e-9, 0.0, 1e-9, 1e-7])
def test_what_just_touches_a_slab_has_its_normal_and_all_its_points(shape, turn, count, gap):
    robot = pair(shape, ("box", "2 2 0.5"))
    places = [pin.SE3(turn, np.array([0.3, 0.2, 1.0 + gap])), pin.SE3.Identity()]
    for order, sign in ((("a/one", "b/two"), 1.0), (("b/two", "a/one"), -1.0)):
        points = met(robot, places, 1e-6, order).points
        assert len(points) == count
        for point in points:
            np.testing.assert_allclose(point.normal, [0, 0, sign], atol=1e-8)
            assert point.position[2] == pytest.approx(0.5 + gap / 2, abs=1e-7)


def test_what_is_further_apart_than_the_margin_does_not_meet():
    places = [pin.SE3(np.eye(3), np.array([0, 0, 1.01])), pin.SE3.Identity()]
    contact = met(pair(BOX, BOX), places, 1e-6)
    assert not contact.touching and contact.gap == pytest.approx(0.01)
