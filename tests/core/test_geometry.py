"""Nearest and touching points of shapes in the core, beside support functions, halfspaces and coal.

A distance is proved from both sides: by points of both bodies that are as far apart, and by a plane
between them, from support functions of their own.
"""

import coal
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial import ConvexHull

from impulsekit import _core
from impulsekit.geometry.axes import core_place
from impulsekit.geometry.shapes import shape_of

KINDS = ("box", "hull", "ball", "capsule", "cylinder", "cone", "ellipsoid", "half_space")
PAIRS = [(a, b) for i, a in enumerate(KINDS) for b in KINDS[i:] if (a, b) != ("half_space",) * 2]
EXACT, ITERATED, HERE = 1e-12, 1e-6, pin.SE3.Identity()
THROUGH = 1e-9


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


def reach(shape, d):
    """How far a shape in its own axes reaches along a unit direction."""
    x, y, z = d
    across = np.hypot(x, y)
    if isinstance(shape, coal.Sphere):
        return shape.radius
    if isinstance(shape, coal.Capsule):
        return shape.radius + shape.halfLength * abs(z)
    if isinstance(shape, coal.Cylinder):
        return shape.radius * across + shape.halfLength * abs(z)
    if isinstance(shape, coal.Cone):
        return max(shape.halfLength * z, shape.radius * across - shape.halfLength * z)
    if isinstance(shape, coal.Box):
        return float(np.ravel(shape.halfSide) @ np.abs(d))
    if isinstance(shape, coal.Ellipsoid):
        return float(np.linalg.norm(np.ravel(shape.radii) * d))
    if isinstance(shape, coal.Halfspace):
        return shape.d if np.allclose(d, np.ravel(shape.n), rtol=0, atol=EXACT) else np.inf
    return max(shape.point(i) @ d for i in range(shape.num_points))


def inside(shape, p):
    """How far within a shape a point of its own axes is: below 0 outside, on every flat side."""
    x, y, z = p
    across = np.hypot(x, y)
    if isinstance(shape, coal.Sphere):
        return shape.radius - np.linalg.norm(p)
    if isinstance(shape, coal.Capsule):
        return shape.radius - np.hypot(across, max(abs(z) - shape.halfLength, 0.0))
    if isinstance(shape, coal.Cylinder):
        return min(shape.radius - across, shape.halfLength - abs(z))
    if isinstance(shape, coal.Cone):
        half = shape.halfLength
        return min(z + half, shape.radius * (half - z) / (2 * half) - across)
    if isinstance(shape, coal.Box):
        return (np.ravel(shape.halfSide) - np.abs(p)).min()
    if isinstance(shape, coal.Ellipsoid):
        radii = np.ravel(shape.radii)
        return (1.0 - np.linalg.norm(p / radii)) * radii.min()
    if isinstance(shape, coal.Halfspace):
        return shape.d - np.ravel(shape.n) @ p
    hull = ConvexHull([shape.point(i) for i in range(shape.num_points)])
    return -(hull.equations[:, :3] @ p + hull.equations[:, 3]).max()


def placement(rng, size=0.4):
    turn = pin.Quaternion(*(q := rng.normal(size=4)) / np.linalg.norm(q)).matrix()
    return pin.SE3(turn, size * rng.normal(size=3))


class Two:
    """Two shapes somewhere, in the core and as they are told of in Python."""

    def __init__(self, kinds, rng):
        self.solids = [geometry(kind, rng) for kind in kinds]
        self.shapes = [shape_of(solid, HERE) for solid in self.solids]
        self.places = [placement(rng), placement(rng)]

    def nearest(self, places=None, order=1):
        given = list(zip(self.shapes, map(core_place, places or self.places), strict=True))
        (a, pa), (b, pb) = given[::order]
        found = _core.nearest_points(a, pa, b, pb)
        return found.gap, found.normal, found.on_first, found.on_other

    def between(self, normal):
        """How far they are apart along a normal, from the second to the first."""
        (a, b), (pa, pb) = self.solids, self.places
        apart = normal @ (pa.translation - pb.translation)
        return apart - reach(a, -pa.rotation.T @ normal) - reach(b, pb.rotation.T @ normal)

    def within(self, first, other):
        """How far within the first, and the second, points of the world are."""
        both = zip(self.solids, self.places, (first, other), strict=True)
        return [inside(shape, place.actInv(point)) for shape, place, point in both]

    def brought_to(self, gap):
        """With the first moved along the normal until the surfaces are so far apart [m]."""
        for _ in range(6):
            now, normal, *_ = self.nearest()
            self.places[0].translation = self.places[0].translation + (gap - now) * normal
        return self

    def touching(self, margin):
        a, b = ([shape] for shape in self.shapes)
        pa, pb = map(core_place, self.places)
        return _core.contact_points(a, pa, b, pb, margin)

    def follow(self, feature):
        a, b = ([shape] for shape in self.shapes)
        pa, pb = map(core_place, self.places)
        return _core.follow(feature, a, pa, b, pb)


@pytest.mark.parametrize("kinds", PAIRS, ids="-".join)
def test_distance_and_normal(kinds):
    rng = np.random.default_rng(PAIRS.index(kinds))
    for _ in range(15):
        two = Two(kinds, rng)
        gap, normal, first, other = two.nearest()
        assert np.isclose(np.linalg.norm(normal), 1.0, atol=EXACT)
        assert abs(two.between(normal) - gap) < EXACT
        assert np.allclose(first - other, gap * normal, atol=EXACT)
        assert min(two.within(first, other)) > -EXACT
        if gap < 0:
            # Of an overlap the least way out counts; coal misses it now and then.
            a, b = (coal.Transform3s(p.rotation, p.translation) for p in two.places)
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            request.enable_signed_distance = True
            request.gjk_tolerance = request.epa_tolerance = EXACT
            known = coal.distance(two.solids[0], a, two.solids[1], b, request, result)
            assert gap >= known - ITERATED


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
        # Corners and edges that meet beside all faces have no patch.
        assert found or set(kinds) <= {"box", "hull"}
        for own in found:
            half = 0.5 * own.gap * own.normal
            assert own.gap <= margin + EXACT
            assert min(two.within(own.point + half, own.point - half)) > -1e-6
            assert two.between(own.normal) < own.gap + THROUGH
        for own in found:
            again, inside = two.follow(own.feature)
            names.add(own.feature.kind)
            assert np.allclose(again.point, own.point, atol=3e-6)
            assert abs(again.gap - own.gap) < 1e-9
            assert inside > -2e-6
    assert names


def test_boxes_share_the_corners_of_what_their_faces_have_in_common():
    rng, margin = np.random.default_rng(7), 5e-5
    for _ in range(20):
        two = Two(("box", "box"), rng)
        a, b = (np.ravel(solid.halfSide) for solid in two.solids)
        turn = rng.uniform(0, np.pi)
        two.places = [
            pin.SE3(pin.rpy.rpyToMatrix(0, 0, turn), np.array([*rng.normal(size=2) * 0.1, a[2]])),
            pin.SE3(np.eye(3), np.array([0, 0, -b[2]])),
        ]
        sides = []
        for half, place in ((a, two.places[0]), (b, two.places[1])):
            for k in (0, 1):
                for sign in (1.0, -1.0):
                    n = sign * place.rotation[:2, k]
                    sides.append((n, n @ place.translation[:2] + half[k]))
        known = [
            p
            for i, (n, g) in enumerate(sides)
            for m, h in sides[:i]
            if abs(np.linalg.det([n, m])) > EXACT
            for p in [np.linalg.solve([n, m], [g, h])]
            if all(k @ p < f + EXACT for k, f in sides)
        ]
        found = [own.point for own in two.touching(margin)]
        assert len(found) == len(known)
        for p in known:
            assert min(np.abs(own - [*p, 0.0]).max() for own in found) < EXACT
