"""Points, normals and gaps of two bodies, piece by piece.

| pieces | found by |
|---|---|
| two polyhedra (boxes, convex hulls of meshes) | ``features``: separating axes, corners, edges |
| ball, capsule, cylinder or cone with one of these or a polyhedron | ``separate``, ``patch`` |
| a half-space with any of these five | its normal, ``patch`` |
| an ellipsoid over a half-space | ``ellipsoids`` |
| others: other ellipsoids, thickened boxes, planes, hulls of very many corners | coal |

The first four are right to rounding, the same whichever piece comes first and wherever and
however the pieces are in the world.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from ..robot import Robot
from ..tolerances import NONZERO
from .convex import Convex, HalfSpace, convex_of
from .ellipsoids import lowest_point
from .features import CornerOnFace, EdgesCross, touching_at
from .pairs import ConvexPair, has_closed_form
from .polyhedron import Polyhedron, can_be_separated, polyhedron_of, separation_at

__all__ = [
    "MeetingPoint",
    "Solid",
    "Solids",
    "gap_and_normal",
    "is_exact",
    "meeting_points",
    "solid_of",
    "solids_of",
]

# Tolerance for the squared length of a unit normal, and for two normals to be the same.
UNIT = 1e-6
# Faces within this distance [m] of each other touch over a patch.
PATCH = 1e-6
# Where two shapes just touch, the direction between them is lost in rounding. The first
# is moved apart by this much [m] along the direction found, and the two are asked again.
APART = 1e-3
# Of coal's iterations; its default of 1e-6 would show in gaps and in the times of impacts.
TOLERANCE = 1e-12
# For gaps alone a longer way [m] tells them better.
WELL_APART = 1e-2
# No distance is so large [m]: coal gives the largest number where it fails.
NONSENSE = 1e100
# How many points stand for the rim of a curved face.
RIM_POINTS = 8


@dataclass(frozen=True, eq=False)
class MeetingPoint:
    """One point at which two bodies meet.

    Attributes:
        position: (3,) world [m], halfway between the surfaces.
        normal: (3,) world, from the second body to the first.
        gap: [m], negative where they overlap.
        feature: which corner, face or edges meet there; None where a body is curved.
        pieces: the numbers of the two pieces that meet.
    """

    position: np.ndarray
    normal: np.ndarray
    gap: float
    feature: CornerOnFace | EdgesCross | None = None
    pieces: tuple[int, int] = (0, 0)


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex piece of a body.

    Attributes:
        geometry: as coal knows it.
        polyhedron: its corners, edges and faces; None where it is curved.
        convex: as a hull of points and circles; None where it is none.
    """

    geometry: coal.CollisionGeometry
    polyhedron: Polyhedron | None
    convex: Convex | HalfSpace | None


# Pieces of a body, each with its placement.
Solids = Sequence[tuple[Solid, pin.SE3]]


def solid_of(geometry: coal.CollisionGeometry) -> Solid:
    """The solid that a geometry stands for: for a mesh its convex hull."""
    if isinstance(geometry, coal.BVHModelBase):
        geometry.buildConvexHull(True, "Qt")
        geometry = geometry.convex
    polyhedron = polyhedron_of(geometry)
    return Solid(geometry, polyhedron, convex_of(geometry, polyhedron))


def solids_of(robot: Robot, ids: Iterable[int]) -> list[tuple[Solid, pin.SE3]]:
    """Pieces of collision geometry by index, each with its placement in its joint.

    The hull of a mesh takes longer than an impact: a robot keeps those of its meshes, and boxes.
    """
    objects = robot.collision_model.geometryObjects
    return [(_kept_solid(robot, i, objects[i].geometry), objects[i].placement) for i in ids]


def _kept_solid(robot: Robot, index: int, geometry: coal.CollisionGeometry) -> Solid:
    if isinstance(geometry, coal.BVHModelBase):
        corners = np.array(geometry.vertices())
    elif isinstance(geometry, coal.Box):
        corners = np.array([*geometry.halfSide, geometry.getSweptSphereRadius()])
    else:
        return solid_of(geometry)
    kept = robot.kept_hulls.get(index)
    # A mesh that was changed since then is another one.
    if kept is None or not np.array_equal(kept[0], corners):
        kept = robot.kept_hulls[index] = corners, solid_of(geometry)
    return kept[1]


def is_exact(one: Solid, two: Solid) -> bool:
    """Whether gaps and points of two solids are told in closed form, to rounding."""
    if _polyhedra(one, two) is not None or has_closed_form(one.convex, two.convex):
        return True
    return _over(one, two) is not None or _over(two, one) is not None


def meeting_points(first: Solids, other: Solids, margin: float) -> Iterator[MeetingPoint]:
    """The points at which pieces of two bodies are no further apart than ``margin``.

    Flat pairs give the corners of the patch they share.
    """
    for i, (one, placement_a) in enumerate(first):
        for j, (two, placement_b) in enumerate(other):
            numbers = (i, j)
            if (pair := _polyhedra(one, two)) is not None:
                yield from _features(*pair, placement_a, placement_b, margin, numbers)
            elif (curved := _convex(one, placement_a, two, placement_b)) is not None:
                normal, touching = curved.points(margin)
                for position, gap in touching:
                    yield MeetingPoint(position, normal, gap, pieces=numbers)
            elif (low := _lowest(one, placement_a, two, placement_b)) is not None:
                gap, normal, point = low
                if gap <= margin:
                    yield MeetingPoint(point, normal, gap, pieces=numbers)
            else:
                pieces = one.geometry, placement_a, two.geometry, placement_b
                yield from _pair(*pieces, margin, numbers)


def gap_and_normal(
    one: Solid, placement_a: pin.SE3, two: Solid, placement_b: pin.SE3
) -> tuple[float, np.ndarray]:
    """The gap of two pieces [m], negative where they overlap, and its normal from the second.

    Of polyhedra it is the largest separation along an axis, which is zero where their
    distance is, and no larger elsewhere. The normal is (3,).
    """
    if (pair := _polyhedra(one, two)) is not None:
        return separation_at(pair[0], placement_a, pair[1], placement_b)
    if (curved := _convex(one, placement_a, two, placement_b)) is not None:
        return curved.separate()
    if (low := _lowest(one, placement_a, two, placement_b)) is not None:
        return low[:2]
    gap, towards_b = _gap(one.geometry, placement_a, two.geometry, placement_b)
    return gap, -towards_b


def _polyhedra(one: Solid, two: Solid) -> tuple[Polyhedron, Polyhedron] | None:
    """Both as polyhedra; None where one is curved, or has too many edges."""
    a, b = one.polyhedron, two.polyhedron
    return None if a is None or b is None or not can_be_separated(a, b) else (a, b)


def _features(
    one: Polyhedron,
    two: Polyhedron,
    placement_a: pin.SE3,
    placement_b: pin.SE3,
    margin: float,
    numbers: tuple[int, int],
) -> Iterator[MeetingPoint]:
    normal, points = touching_at(one, placement_a, two, placement_b, margin)
    for point in points:
        place = point.position + placement_b.translation
        yield MeetingPoint(place, normal, point.gap, point.feature, numbers)


def _convex(
    one: Solid, placement_a: pin.SE3, two: Solid, placement_b: pin.SE3
) -> ConvexPair | None:
    """Both as hulls of points and circles; None where one is none, or has too many corners."""
    a, b = one.convex, two.convex
    if a is None or b is None or not has_closed_form(a, b):
        return None
    return ConvexPair(a, placement_a, b, placement_b)


def _over(solid: Solid, ground: Solid) -> tuple[coal.Ellipsoid, HalfSpace] | None:
    """Both as an ellipsoid and a half-space; None where they are none."""
    shape, flat = solid.geometry, ground.convex
    if isinstance(shape, coal.Ellipsoid) and isinstance(flat, HalfSpace):
        return shape, flat
    return None


def _lowest(
    one: Solid, placement_a: pin.SE3, two: Solid, placement_b: pin.SE3
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """Gap, normal and point (halfway) of an ellipsoid over a half-space; None of other pairs."""
    for solid, place, other, ground, sign in (
        (one, placement_a, two, placement_b, 1.0),
        (two, placement_b, one, placement_a, -1.0),
    ):
        if (both := _over(solid, other)) is not None:
            gap, up, point = lowest_point(both[0], place, both[1], ground)
            return gap, sign * up, point - 0.5 * gap * up
    return None


def _gap(
    shape_a: coal.CollisionGeometry,
    placement_a: pin.SE3,
    shape_b: coal.CollisionGeometry,
    placement_b: pin.SE3,
) -> tuple[float, np.ndarray]:
    """The distance of two convex shapes [m], and its direction (3,) from the first.

    Whatever the tolerance, coal is off by up to 4e-7 m where flat shapes nearly touch.
    Moved apart along the normal n by a known way d the gap is D − d n·n', D and n' those
    found there, to some 1e-11 m.
    """
    b = _transform(placement_b)
    gap, normal = _distance(shape_a, _transform(placement_a), shape_b, b)
    if not _is_told(gap, normal):
        # coal lost its way, as it does where shapes touch: from some way off it sees more.
        normal = placement_b.translation - placement_a.translation
        normal /= max(float(np.linalg.norm(normal)), NONZERO)
    elif abs(gap) > WELL_APART / 2:
        return gap, normal
    for _ in range(2):
        shifted = placement_a.translation - WELL_APART * normal
        away = coal.Transform3s(placement_a.rotation, shifted)
        further, turned = _distance(shape_a, away, shape_b, b)
        if not _is_told(further, turned):
            break
        gap = further - WELL_APART * float(normal.dot(turned))
        if np.abs(turned - normal).max() < UNIT:
            break
        normal = turned
    return gap, normal


def _is_told(gap: float, normal: np.ndarray) -> bool:
    return abs(gap) < NONSENSE and abs(normal.dot(normal) - 1.0) < UNIT


def _distance(
    shape_a: coal.CollisionGeometry,
    a: coal.Transform3s,
    shape_b: coal.CollisionGeometry,
    b: coal.Transform3s,
) -> tuple[float, np.ndarray]:
    """coal's distance [m], and the direction from the first to the second."""
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = TOLERANCE
    result = coal.DistanceResult()
    distance = float(coal.distance(shape_a, a, shape_b, b, request, result))
    return distance, np.array(result.normal)


def _pair(
    shape_a: coal.CollisionGeometry,
    placement_a: pin.SE3,
    shape_b: coal.CollisionGeometry,
    placement_b: pin.SE3,
    margin: float,
    numbers: tuple[int, int],
) -> Iterator[MeetingPoint]:
    b = _transform(placement_b)
    a = _transform(placement_a)
    hits = _collide(shape_a, a, shape_b, b, margin)
    if hits is None:
        return
    towards_b = np.array(hits.getContact(0).normal)
    depth = max(0.0, -float(hits.getContact(0).penetration_depth))
    if not _is_told(depth, towards_b):
        gap, towards_b = _gap(shape_a, placement_a, shape_b, placement_b)
        depth = max(0.0, -gap)
    apart = coal.Transform3s(placement_a.rotation, placement_a.translation - APART * towards_b)
    # Deep overlaps have a clear direction of their own, and would not come apart.
    if depth < APART / 2:
        again = _collide(shape_a, apart, shape_b, b, margin + 2.0 * APART)
        if again is not None:
            hits, a, shift = again, apart, APART
        else:
            shift = 0.0
    else:
        shift = 0.0
    contact = hits.getContact(0)
    towards_b = np.array(contact.normal)
    gap = float(contact.penetration_depth) - shift
    corners = _patch(shape_a, a, shape_b, b, hits)
    if len(corners) < 2:
        # coal clips a curved face only as the second of two.
        swapped = _collide(shape_b, b, shape_a, a, margin + 2.0 * APART)
        if swapped is not None:
            others = _patch(shape_b, b, shape_a, a, swapped)
            corners = others if len(others) > len(corners) else corners
    if len(corners) < 2:
        corners = [np.array(contact.pos)]
    for corner in corners:
        yield MeetingPoint(corner + 0.5 * shift * towards_b, -towards_b, gap, pieces=numbers)


def _transform(placement: pin.SE3) -> coal.Transform3s:
    return coal.Transform3s(placement.rotation, placement.translation)


def _collide(
    shape_a: coal.CollisionGeometry,
    a: coal.Transform3s,
    shape_b: coal.CollisionGeometry,
    b: coal.Transform3s,
    margin: float,
) -> coal.CollisionResult | None:
    request = coal.CollisionRequest()
    request.enable_contact = True
    request.num_max_contacts = 1
    request.security_margin = margin
    request.gjk_tolerance = request.epa_tolerance = TOLERANCE
    result = coal.CollisionResult()
    return result if coal.collide(shape_a, a, shape_b, b, request, result) else None


def _patch(
    shape_a: coal.CollisionGeometry,
    a: coal.Transform3s,
    shape_b: coal.CollisionGeometry,
    b: coal.Transform3s,
    hits: coal.CollisionResult,
) -> list[np.ndarray]:
    request = coal.ContactPatchRequest()
    request.setNumSamplesCurvedShapes(RIM_POINTS)
    request.setPatchTolerance(PATCH)
    result = coal.ContactPatchResult(request)
    coal.computeContactPatch(shape_a, a, shape_b, b, hits, request, result)
    if result.numContactPatches() == 0:
        return []
    patch = result.getContactPatch(0)
    return [np.array(patch.getPoint(i)) for i in range(patch.size())]
