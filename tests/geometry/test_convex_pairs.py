"""Round and flat shapes that touch: gaps, normals and points, proved by weak duality.

A gap g with its normal n is right if two points of the shapes are g apart, so that the distance
is no more, and if along n one shape ends g above the other, so that it is no less.
"""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from impulsekit.geometry.collision import gap_and_normal, meeting_points, solid_of

KINDS = ("box", "cylinder", "capsule", "ball", "cone")
PAIRS = [(a, b) for i, a in enumerate(KINDS) for b in KINDS[i:] if (a, b) != ("box", "box")]
MIRROR = np.diag((1.0, -1.0, 1.0))
MARGIN = 1e-6


def shape_of(kind: str, rng: np.random.Generator):
    a, b, c = rng.uniform(0.05, 0.5, 3)
    return {
        "box": lambda: coal.Box(a, b, c),
        "cylinder": lambda: coal.Cylinder(a, b),
        "capsule": lambda: coal.Capsule(0.4 * a, b),
        "ball": lambda: coal.Sphere(0.5 * a),
        "cone": lambda: coal.Cone(a, b),
    }[kind]()


def reach(shape, way: np.ndarray) -> float:
    """The support function, from the shape's own definition."""
    x, y, z = way
    across = np.hypot(x, y)
    if isinstance(shape, coal.Box):
        return float(np.abs(way) @ np.array(shape.halfSide).reshape(3))
    if isinstance(shape, coal.Sphere):
        return shape.radius
    if isinstance(shape, coal.Capsule):
        return shape.halfLength * abs(z) + shape.radius
    if isinstance(shape, coal.Cylinder):
        return shape.halfLength * abs(z) + shape.radius * across
    return max(shape.halfLength * z, shape.radius * across - shape.halfLength * z)


def outside(shape, x: np.ndarray) -> float:
    """How far a point is outside the shape, in its own frame [m]; not positive inside."""
    across = np.hypot(x[0], x[1])
    if isinstance(shape, coal.Box):
        return float((np.abs(x) - np.array(shape.halfSide).reshape(3)).max())
    if isinstance(shape, coal.Sphere):
        return float(np.linalg.norm(x)) - shape.radius
    if isinstance(shape, coal.Capsule):
        rest = max(abs(x[2]) - shape.halfLength, 0.0)
        return float(np.hypot(across, rest)) - shape.radius
    if isinstance(shape, coal.Cylinder):
        return max(abs(x[2]) - shape.halfLength, across - shape.radius)
    height, r = 2.0 * shape.halfLength, shape.radius
    side = (height * across + r * (x[2] - shape.halfLength)) / np.hypot(r, height)
    return max(-shape.halfLength - x[2], side)


def turned(rng: np.random.Generator) -> np.ndarray:
    return pin.Quaternion(*_unit(rng.normal(size=4))).matrix()


def _unit(x: np.ndarray) -> np.ndarray:
    return x / np.linalg.norm(x)


def pose(rng: np.random.Generator, ordinary: bool) -> np.ndarray:
    """Any rotation; or one that lays faces, sides and edges on each other."""
    if ordinary:
        return turned(rng)
    spin = pin.utils.rotate("z", rng.choice([0.0, np.pi / 4, rng.uniform(0, 6)]))
    lie = pin.utils.rotate("x", rng.choice([0.0, np.pi / 4, np.pi / 2, np.pi, 1.0]))
    return spin @ lie @ pin.utils.rotate("z", rng.uniform(0, 6))


def touching(kinds, rng, gap: float, ordinary: bool):
    """Two shapes placed so that they are ``gap`` apart."""
    shapes = [shape_of(kind, rng) for kind in kinds]
    way = _unit(rng.normal(size=3)) if ordinary else _unit(rng.normal(size=3) * [0.2, 0.2, 1.0])
    places = [pin.SE3(pose(rng, ordinary), 2.0 * way), pin.SE3(pose(rng, ordinary), np.zeros(3))]
    if not ordinary and rng.uniform() < 0.5:
        places[1] = pin.SE3(np.eye(3), np.zeros(3))
    solids = [solid_of(shape) for shape in shapes]
    apart, normal = gap_and_normal(solids[0], places[0], solids[1], places[1])
    places[0] = pin.SE3(places[0].rotation, places[0].translation - (apart - gap) * normal)
    return shapes, solids, places


def met(solids, places, order=(0, 1), margin=MARGIN):
    first, other = ([(solids[i], places[i])] for i in order)
    return list(meeting_points(first, other, margin))


@pytest.mark.slow
@pytest.mark.parametrize("ordinary", [True, False])
@pytest.mark.parametrize("kinds", PAIRS)
def test_the_gap_and_its_points_are_right_to_rounding(kinds, ordinary):
    rng = np.random.default_rng(PAIRS.index(kinds))
    off = []
    for _ in range(40):
        gap = float(rng.choice([0.0, 5e-7, -1e-9, 3e-2]))
        shapes, solids, places = touching(kinds, rng, gap, ordinary)
        told, normal = gap_and_normal(solids[0], places[0], solids[1], places[1])
        below, above = (
            reach(shape, place.rotation.T @ (sign * normal)) + sign * normal @ place.translation
            for shape, place, sign in zip(shapes, places, (-1.0, 1.0), strict=True)
        )
        assert told == pytest.approx(-below - above, abs=1e-14)
        # Pushed into each other, tips are apart along another way than before.
        assert told == pytest.approx(gap, abs=1e-12) or (gap < 0.0 and gap <= told)
        points = met(solids, places, margin=max(gap + 1e-9, MARGIN))
        assert points
        assert min(point.gap for point in points) == pytest.approx(told, abs=1e-13)
        for point in points:
            for shape, place, sign in zip(shapes, places, (0.5, -0.5), strict=True):
                surface = place.actInv(point.position + sign * point.gap * point.normal)
                off.append(abs(outside(shape, surface)))
    # Flat parts within the margin of each other need not be on top of each other, and where a
    # rim is all but flat its furthest point is told to fewer digits.
    assert max(off) < 2.0 * MARGIN
    if ordinary:
        assert np.quantile(off, 0.9) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("ordinary", [True, False])
@pytest.mark.parametrize("kinds", PAIRS)
def test_the_points_are_the_same_from_whichever_side_they_are_seen(kinds, ordinary):
    rng = np.random.default_rng(100 + PAIRS.index(kinds))
    for _ in range(25):
        # Tips that touch to the last digit have no direction of their own.
        gap = 5e-7 if ordinary else float(rng.choice([5e-7, -1e-6]))
        _, solids, places = touching(kinds, rng, gap, ordinary)
        points = met(solids, places)
        assert points
        same(points, met(solids, places, (1, 0)), sign=-1.0, tolerance=1e-12)
        # 5e-7 m apart, places rounded to 1e-16 m, or to 1e-14 m a hundred metres away, tell the
        # direction between tips to so much less.
        for far, tolerance in ((0.0, 2e-7), (100.0, 5e-6)):
            world = pin.SE3(turned(rng), far * rng.normal(size=3))
            there = [world * place for place in places]
            same(points, met(solids, there), world, tolerance=tolerance)
        mirrored = [
            pin.SE3(MIRROR @ place.rotation @ MIRROR, MIRROR @ place.translation)
            for place in places
        ]
        same(points, met(solids, mirrored), mirror=MIRROR, tolerance=2e-7)


def same(points, others, world=None, mirror=None, sign=1.0, tolerance=1e-12):
    """Whether others are the points, moved with the world."""
    turn = np.eye(3) if world is None else world.rotation
    turn = turn if mirror is None else mirror
    shift = np.zeros(3) if world is None else world.translation
    assert len(points) == len(others)
    for point in points:
        place = turn @ point.position + shift
        near = min(others, key=lambda other: float(np.abs(other.position - place).max()))
        np.testing.assert_allclose(near.position, place, rtol=0, atol=tolerance)
        np.testing.assert_allclose(sign * near.normal, turn @ point.normal, atol=tolerance)
        assert near.gap == pytest.approx(point.gap, abs=1e-9)
