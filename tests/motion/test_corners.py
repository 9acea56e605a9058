"""Gaps of single corners, to rounding."""

import coal
import numpy as np
import pinocchio as pin

from impulsekit.motion.corners import corners_of, nearest, point_gap

BOX = coal.Box(1.0, 2.0, 3.0)


def test_a_box_has_eight_corners_where_it_is_placed():
    place = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.2, 1.0), np.array([0.5, 0.1, -0.4]))
    corners = corners_of([(BOX, place)])
    local = np.array([place.actInv(corner) for corner in corners])
    np.testing.assert_allclose(np.abs(local), [[0.5, 1.0, 1.5]] * 8, atol=1e-14)
    assert len({tuple(signs) for signs in np.sign(local)}) == 8


def test_curved_bodies_have_none():
    assert corners_of([(coal.Sphere(0.1), pin.SE3.Identity())]) is None


def test_a_point_of_a_patch_is_the_corner_it_is_near():
    corners = corners_of([(BOX, pin.SE3.Identity())])
    assert nearest(corners, corners[3] + [2e-6, 0, -1e-6]) == 3
    assert nearest(corners, corners[3] + [1e-3, 0, 0]) is None


def test_the_gap_of_a_point_is_told_to_rounding_above_and_below_a_face():
    rng = np.random.default_rng(2)
    place = pin.SE3(pin.rpy.rpyToMatrix(0.3, 0.2, 0.1), np.array([0.1, 0.2, 0.3]))
    normal = place.rotation[:, 2]
    for _ in range(50):
        gap = rng.choice([0.0, *rng.uniform(-1e-6, 1e-6, 2)])
        point = place.act(np.array([*rng.uniform(-0.4, 0.4, 2), 1.5 + gap]))
        assert abs(point_gap(point, normal, [(BOX, place)]) - gap) < 1e-14
