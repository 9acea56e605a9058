"""Support functions of shapes: the largest height of their points in a direction."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from impulsekit.geometry.support import furthest, support_of

rng = np.random.default_rng(0)
ANGLES = rng.uniform(0, 2 * np.pi, 20000)
UNIT = rng.normal(size=(20000, 3))
UNIT /= np.linalg.norm(UNIT, axis=1)[:, None]
RIM = np.column_stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(20000)])
UP = np.array([0.0, 0.0, 1.0])
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])

SHAPES = {
    "box": (coal.Box(0.2, 0.4, 0.6), CORNERS * [0.1, 0.2, 0.3]),
    "ball": (coal.Sphere(0.3), 0.3 * UNIT),
    "capsule": (coal.Capsule(0.1, 0.8), np.vstack([0.1 * UNIT + 0.4 * UP, 0.1 * UNIT - 0.4 * UP])),
    "cylinder": (coal.Cylinder(0.2, 0.6), np.vstack([0.2 * RIM + 0.3 * UP, 0.2 * RIM - 0.3 * UP])),
    "cone": (coal.Cone(0.2, 0.6), np.vstack([0.2 * RIM - 0.3 * UP, 0.3 * UP])),
    "ellipsoid": (coal.Ellipsoid(0.1, 0.2, 0.3), UNIT * [0.1, 0.2, 0.3]),
}


@pytest.mark.parametrize("name", SHAPES)
def test_no_point_of_a_shape_lies_further(name):
    shape, points = SHAPES[name]
    place = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.8, 2.0), np.array([0.5, -1.0, 2.0]))
    there = points @ place.rotation.T + place.translation
    support = support_of(shape, place)
    for direction in UNIT[:20] * 3.0:
        found = support.centre @ direction + furthest(support, direction)
        highest = (there @ direction).max()
        # So many random points come near the highest one.
        assert highest - 1e-12 <= found <= highest + 1e-2
    assert np.linalg.norm(there - support.centre, axis=1).max() <= support.radius + 1e-12


def test_a_half_space_ends_in_one_direction_only():
    place = pin.SE3(pin.rpy.rpyToMatrix(0.3, 0, 0), np.array([0, 0, 1.0]))
    support = support_of(coal.Halfspace(UP, 0.2), place)
    normal = place.rotation @ UP
    assert support.centre @ normal + furthest(support, normal) == pytest.approx(
        0.2 + place.translation @ normal
    )
    assert furthest(support, -normal) == np.inf
    assert furthest(support, normal + 0.1) == np.inf
