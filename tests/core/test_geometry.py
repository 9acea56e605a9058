"""Nearest points and touching points of shapes in the core, beside support functions and coal."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from impulsekit import _core
from impulsekit.geometry.axes import place_numbers
from impulsekit.geometry.collision import gap_and_normal, is_exact, meeting_points, solid_of
from impulsekit.geometry.core_shapes import core_shape

KINDS = ("box", "hull", "ball", "capsule", "cylinder", "cone", "ellipsoid", "half_space")
PAIRS = [(a, b) for i, a in enumerate(KINDS) for b in KINDS[i:] if (a, b) != ("half_space",) * 2]
EXACT, ITERATED, HERE = 1e-12, 1e-6, pin.SE3.Identity()


def geometry(kind, rng):
    a, b, c = rng.uniform(0.05, 0.4, 3)
    if kind == "hull":
        corners = coal.StdVec_Vec3s()
        corners.extend(list(rng.normal(size=(12, 3)) * 0.2))
        return coal.ConvexBase.convexHull(corners, True, "Qt")
    if kind == "half_space":
        n = rng.normal(size=3)
        return coal.Halfspace(n / np.linalg.norm(n), 0.1)
    return {
        "box": lambda: coal.Box(2 * a, 2 * b, 2 * c),
        "ball": lambda: coal.Sphere(a),
        "capsule": lambda: coal.Capsule(a, 2 * b),
        "cylinder": lambda: coal.Cylinder(a, 2 * b),
        "cone": lambda: coal.Cone(a, 2 * b),
        "ellipsoid": lambda: coal.Ellipsoid(a, b, c),
    }[kind]()


def placement(rng, size=0.4):
    turn = pin.Quaternion(*(q := rng.normal(size=4)) / np.linalg.norm(q)).matrix()
    return pin.SE3(turn, size * rng.normal(size=3))


class Two:
    """Two shapes somewhere, in the core and as they are told of in Python."""

    def __init__(self, kinds, rng):
        self.solids = [solid_of(geometry(kind, rng)) for kind in kinds]
        self.shapes = [core_shape(solid, HERE) for solid in self.solids]
        self.places = [placement(rng), placement(rng)]

    def nearest(self, places=None, order=1):
        given = list(zip(self.shapes, map(place_numbers, places or self.places), strict=True))
        (a, pa), (b, pb) = given[::order]
        found = _core.nearest_points(a, pa, b, pb)
        return found[0], *found[1:].reshape(3, 3)

    def in_python(self):
        (a, b), (pa, pb) = self.solids, self.places
        return gap_and_normal(a, pa, b, pb)

    def brought_to(self, gap):
        """With the first moved along the normal until the surfaces are so far apart [m]."""
        for _ in range(6):
            now, normal, *_ = self.nearest()
            self.places[0].translation = self.places[0].translation + (gap - now) * normal
        return self

    def touching(self, margin):
        a, b = ([shape] for shape in self.shapes)
        pa, pb = map(place_numbers, self.places)
        return _core.touching(a, pa, b, pb, margin)

    def follow(self, feature):
        a, b = ([shape] for shape in self.shapes)
        pa, pb = map(place_numbers, self.places)
        return _core.follow(feature, a, pa, b, pb)


@pytest.mark.parametrize("kinds", PAIRS, ids="-".join)
def test_distance_and_normal(kinds):
    rng = np.random.default_rng(PAIRS.index(kinds))
    for _ in range(15):
        two = Two(kinds, rng)
        gap, normal, first, other = two.nearest()
        known = two.in_python()[0]
        flat = set(kinds) <= {"box", "hull"}
        if flat and gap > 0:
            # Along faces and edges alone two corners are nearer.
            a, b = (coal.Transform3s(p.rotation, p.translation) for p in two.places)
            shapes = [solid.geometry for solid in two.solids]
            request = coal.DistanceRequest()
            known = coal.distance(shapes[0], a, shapes[1], b, request, coal.DistanceResult())
        near = EXACT if is_exact(*two.solids) and not (flat and gap > 0) else ITERATED
        # Of an overlap the least way out counts; coal misses it now and then.
        assert gap >= known - near
        assert gap <= known + near or gap < 0
        assert np.allclose(first - other, gap * normal, atol=EXACT)
        assert np.isclose(np.linalg.norm(normal), 1.0, atol=EXACT)


@pytest.mark.parametrize("kinds", PAIRS, ids="-".join)
def test_order_and_common_motion_change_nothing(kinds):
    rng = np.random.default_rng(100 + PAIRS.index(kinds))
    for _ in range(8):
        two = Two(kinds, rng)
        if two.nearest()[0] < 0:
            two.brought_to(0.1)
        gap, normal, *_ = two.nearest()
        back = two.nearest(order=-1)
        assert abs(back[0] - gap) < EXACT
        move = placement(rng, 3.0)
        moved = two.nearest([move * place for place in two.places])
        assert abs(moved[0] - gap) < 10 * EXACT
        assert np.allclose(move.rotation.T @ moved[1], normal, atol=1e-9)


@pytest.mark.parametrize("kinds", PAIRS, ids="-".join)
def test_gap_changes_as_the_nearest_points_part(kinds):
    rng, h = np.random.default_rng(200 + PAIRS.index(kinds)), 1e-5
    for _ in range(5):
        two = Two(kinds, rng).brought_to(0.05)
        _, normal, first, other = two.nearest()
        speeds = rng.normal(size=(2, 6))

        def at(t, two=two, speeds=speeds):
            moves = [pin.exp6(pin.Motion(t * speed)) for speed in speeds]
            return two.nearest([m * p for m, p in zip(moves, two.places, strict=True)])[0]

        speed = [v[:3] + np.cross(v[3:], x) for v, x in zip(speeds, (first, other), strict=True)]
        known = normal @ (speed[0] - speed[1])
        assert abs((at(h) - at(-h)) / (2 * h) - known) < 1e-6


@pytest.mark.parametrize("kinds", PAIRS, ids="-".join)
def test_touching_points(kinds):
    rng, margin = np.random.default_rng(300 + PAIRS.index(kinds)), 5e-5
    quarter, names = np.pi / 2, set()
    for k in range(12):
        two = Two(kinds, rng)
        if k % 2:
            # Faces, sides and rims that lie on each other.
            turn = pin.rpy.rpyToMatrix(*(quarter * rng.integers(0, 4, 3)))
            two.places[0].rotation = two.places[1].rotation @ turn
        two.brought_to(rng.uniform(-1e-6, 4e-5))
        found = two.touching(margin)
        (a, b), (pa, pb) = two.solids, two.places
        # Corners and edges that meet beside all faces have no patch.
        assert found or set(kinds) <= {"box", "hull"}
        # Polytopes whose corners alone are nearest are compared along a face or edges, of which
        # the core takes those that can be nearest.
        beside = two.in_python()[0] < two.nearest()[0] - 1e-9 and set(kinds) <= {"box", "hull"}
        if is_exact(a, b) and not beside:
            known = list(meeting_points([(a, pa)], [(b, pb)], margin))
            assert len(known) == len(found)
            for point in known:
                away = [np.abs(point.position - own.point).max() for own in found]
                own = found[int(np.argmin(away))]
                assert min(away) < 1e-9
                assert abs(own.gap - point.gap) < 1e-9
                assert np.allclose(own.normal, point.normal, atol=1e-7)
        for own in found:
            again, inside = two.follow(own.feature)
            names.add(own.feature.kind)
            assert np.allclose(again.point, own.point, atol=3e-6)
            assert abs(again.gap - own.gap) < 1e-9
            assert inside > -2e-6
    assert names
