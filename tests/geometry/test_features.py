"""Where two boxes touch: corners on faces, and edges that cross."""

import numpy as np
import pinocchio as pin
import pytest

from impulsekit.geometry.features import (
    CornerOnFace,
    EdgesCross,
    borders_of,
    inside_of,
    touching_at,
)
from impulsekit.geometry.polyhedron import polyhedron_of, separation_at

from .test_polyhedron import BOX, placed

BODY, HERE = polyhedron_of(BOX), pin.SE3.Identity()


def at(x, y, z, *rpy):
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy) if rpy else np.eye(3), np.array([x, y, z], float))


def kinds(points):
    return sorted(type(point.feature).__name__ for point in points)


@pytest.mark.parametrize(
    ("place", "count"),
    [
        (at(0, 0, 0.1), 4),
        (at(0.05, 0.03, 0.1), 4),
        (at(0, 0, 0.1, 0, 0, np.pi / 2), 4),
        (at(0, 0, 0.1, 0, 0, 0.3), 8),
    ],
)
def test_flat_faces_share_a_patch_whose_corners_are_found(place, count):
    normal, points = touching_at(BODY, place, BODY, HERE, 1e-6)
    np.testing.assert_allclose(normal, [0, 0, 1], atol=1e-12)
    assert len(points) == count
    for point in points:
        assert abs(point.gap) < 1e-15
        for body in (BODY, BODY.at(place)):
            assert (body.normals @ point.position - body.heights).max() < 1e-12


def test_edges_that_cross_touch_in_one_point_along_their_cross_product():
    place = at(0, 0, 0.4, 0, np.pi / 4, 0)
    low = at(0, 0, 0, np.pi / 4, 0, 0)
    gap, _ = separation_at(BODY, place, BODY, low)
    place = at(0, 0, -gap) * place
    a, b = BODY.at(place), BODY.at(low)
    normal, points = touching_at(BODY, place, BODY, low, 1e-6)
    assert [type(point.feature) for point in points] == [EdgesCross]
    (i, j), (k, m) = points[0].feature.first, points[0].feature.other
    e, f = a.vertices[j] - a.vertices[i], b.vertices[m] - b.vertices[k]
    np.testing.assert_allclose([normal @ e, normal @ f], 0.0, atol=1e-14)
    assert abs(points[0].gap) < 1e-15


@pytest.mark.parametrize("seed", range(30))
def test_bodies_that_are_moved_until_they_touch_touch_somewhere(seed):
    rng = np.random.default_rng(seed)
    a, b = placed(rng, 0.1), placed(rng, 0.1)
    gap, normal = separation_at(BODY, a, BODY, b)
    a.translation = a.translation - gap * normal
    found, points = touching_at(BODY, a, BODY, b, 1e-9)
    assert points
    np.testing.assert_allclose(found, normal, atol=1e-9)
    back, others = touching_at(BODY, b, BODY, a, 1e-9)
    np.testing.assert_allclose(back, -found, atol=1e-12)
    for point, other in zip(points, others, strict=True):
        here, there = point.position + b.translation, other.position + a.translation
        np.testing.assert_allclose(here, there, atol=1e-12)


def test_faces_that_are_flat_on_each_other_but_for_little_have_one_normal_and_one_plane():
    place = at(0.02, 0.03, 0.1, 2e-6, -1e-6, 0.2)
    gap, _ = separation_at(BODY, place, BODY, HERE)
    normal, points = touching_at(BODY, at(0, 0, -gap) * place, BODY, HERE, 1e-6)
    assert len(points) >= 4
    assert np.ptp([point.position @ normal for point in points]) < 1e-15
    assert max(point.gap for point in points) > 1e-8


def test_what_is_further_apart_than_the_margin_does_not_touch():
    lifted = at(0, 0, 0.1 + 2e-6)
    assert touching_at(BODY, lifted, BODY, HERE, 1e-6)[1] == []
    assert kinds(touching_at(BODY, lifted, BODY, HERE, 3e-6)[1]) == ["CornerOnFace"] * 4


def test_a_corner_belongs_to_the_body_that_has_it():
    place = at(0, 0, 0.3, 0.6, 0.5, 0.1)
    gap, _ = separation_at(BODY, place, BODY, HERE)
    _, points = touching_at(BODY, at(0, 0, -gap) * place, BODY, HERE, 1e-9)
    assert [point.feature for point in points] == [
        CornerOnFace(0, points[0].feature.corner, points[0].feature.face)
    ]
    _, points = touching_at(BODY, HERE, BODY, at(0, 0, -gap) * place, 1e-9)
    assert points[0].feature.side == 1


def test_how_far_a_point_is_inside_a_face():
    top = int(BODY.normals[:, 2].argmax())
    borders = borders_of(BODY, top)
    assert inside_of(borders, 0, 4, (0.1, 0.0, 0.05)) == pytest.approx(0.05)
    assert inside_of(borders, 0, 4, (0.1, -0.12, 0.05)) == pytest.approx(-0.02)
