"""How far convex bodies with flat faces are apart."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from impulsekit.geometry.polyhedron import can_be_separated, polyhedron_of, separation_at

BOX = coal.Box(0.3, 0.2, 0.1)


def placed(rng, reach):
    turn = pin.Quaternion(rng.normal(size=4)).normalized().matrix()
    return pin.SE3(turn, rng.uniform(-reach, reach, 3))


def wedge():
    """A roof with a square floor, whose faces coal has cut into triangles."""
    points = coal.StdVec_Vec3s()
    for x, y, z in [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, -1, 1), (0, 1, 1)]:
        points.append(np.array([x, y, z], dtype=float) / 10)
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(8, 6)
    triangles = [(0, 2, 1), (0, 3, 2), (0, 1, 4), (2, 3, 5), (1, 2, 5), (1, 5, 4), (3, 0, 4)]
    faces = coal.StdVec_Triangle()
    for triangle in [*triangles, (3, 4, 5)]:
        faces.append(coal.Triangle(*triangle))
    mesh.addSubModel(points, faces)
    mesh.endModel()
    mesh.buildConvexHull(True, "Qt")
    return mesh.convex


def coal_distance(shape_a, a, shape_b, b):
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-12
    places = [coal.Transform3s(place.rotation, place.translation) for place in (a, b)]
    return coal.distance(shape_a, places[0], shape_b, places[1], request, result)


@pytest.mark.parametrize(("shape", "faces", "edges"), [(BOX, 6, 12), (wedge(), 5, 9)])
def test_faces_look_outwards_and_close(shape, faces, edges):
    body = polyhedron_of(shape)
    assert (len(body.faces), len(body.edges)) == (faces, edges)
    assert len(body.vertices) - edges + faces == 2
    for normal, height, loop in zip(body.normals, body.heights, body.faces, strict=True):
        above = body.vertices @ normal - height
        assert above.max() < 1e-12
        np.testing.assert_allclose(above[loop], 0.0, atol=1e-15)
        ways = np.roll(body.vertices[loop], -1, axis=0) - body.vertices[loop]
        assert (np.cross(ways, np.roll(ways, -1, axis=0)) @ normal > 0.0).all()


def test_curved_bodies_are_none():
    assert polyhedron_of(coal.Sphere(0.1)) is None
    assert polyhedron_of(coal.Cylinder(0.1, 0.2)) is None


@pytest.mark.parametrize("shape", [BOX, wedge()])
def test_it_is_the_depth_of_an_overlap_and_never_more_than_the_distance(shape):
    rng, body, box = np.random.default_rng(3), polyhedron_of(shape), polyhedron_of(BOX)
    overlaps = 0
    for _ in range(200):
        a, b = placed(rng, 0.15), placed(rng, 0.15)
        gap, normal = separation_at(body, a, box, b)
        told = coal_distance(shape, a, BOX, b)
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
        if told < 0.0:
            overlaps += 1
            assert gap == pytest.approx(told, abs=1e-9)
        else:
            assert 0.5 * told < gap < told + 1e-9
    assert overlaps > 30


def test_moved_along_the_normal_the_gap_grows_by_the_way():
    rng, box = np.random.default_rng(4), polyhedron_of(BOX)
    for _ in range(50):
        a, b = placed(rng, 0.1), placed(rng, 0.1)
        gap, normal = separation_at(box, a, box, b)
        a.translation = a.translation - (gap - 1e-7) * normal
        there, _ = separation_at(box, a, box, b)
        assert there == pytest.approx(1e-7, abs=1e-15)


def test_bodies_with_very_many_edges_are_left_to_coal():
    rng = np.random.default_rng(0)
    points = coal.StdVec_Vec3s()
    for point in rng.normal(size=(150, 3)):
        points.append(point / np.linalg.norm(point))
    round_one = polyhedron_of(coal.Convex.convexHull(points, True, "Qt"))
    assert can_be_separated(round_one, polyhedron_of(BOX))
    assert not can_be_separated(round_one, round_one)
