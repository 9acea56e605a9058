"""Points, normals and gaps of two bodies, from coal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

__all__ = ["MeetingPoint", "convex_geometry", "meeting_points", "smallest_gap"]

# Where two shapes just touch, the direction between them is lost in rounding. The first
# is moved apart by this much [m] along the direction found, and the two are asked again.
APART = 1e-3
# Of coal's iterations; its default of 1e-6 would show in gaps and in the times of impacts.
TOLERANCE = 1e-12
# For gaps alone a longer way [m] tells them better.
WELL_APART = 1e-2
# How many points stand for the rim of a curved face.
RIM_POINTS = 8


@dataclass(frozen=True, eq=False)
class MeetingPoint:
    """One point at which two bodies meet.

    Attributes:
        position: (3,) world [m], halfway between the surfaces.
        normal: (3,) world, from the second body to the first.
        gap: [m], negative where they overlap.
    """

    position: np.ndarray
    normal: np.ndarray
    gap: float


def convex_geometry(item: pin.GeometryObject) -> coal.CollisionGeometry:
    """The geometry of an object, or for a mesh its convex hull."""
    geometry = item.geometry
    if isinstance(geometry, coal.BVHModelBase):
        geometry.buildConvexHull(True, "Qt")
        return geometry.convex
    return geometry


def meeting_points(
    first: Sequence[tuple[coal.CollisionGeometry, pin.SE3]],
    other: Sequence[tuple[coal.CollisionGeometry, pin.SE3]],
    margin: float,
) -> Iterator[MeetingPoint]:
    """The points at which pieces of two bodies are no further apart than ``margin``.

    Flat pairs give the corners of the patch they share.
    """
    for shape_a, placement_a in first:
        for shape_b, placement_b in other:
            yield from _pair(shape_a, placement_a, shape_b, placement_b, margin)


def smallest_gap(
    first: Sequence[tuple[coal.CollisionGeometry, pin.SE3]],
    other: Sequence[tuple[coal.CollisionGeometry, pin.SE3]],
) -> float:
    """The distance between two bodies [m], negative where they overlap."""
    gaps = [
        _gap(shape_a, placement_a, shape_b, placement_b)
        for shape_a, placement_a in first
        for shape_b, placement_b in other
    ]
    return min(gaps, default=np.inf)


def _gap(
    shape_a: coal.CollisionGeometry,
    placement_a: pin.SE3,
    shape_b: coal.CollisionGeometry,
    placement_b: pin.SE3,
) -> float:
    """The distance of two convex shapes [m].

    Whatever the tolerance, coal is off by up to 4e-7 m where flat shapes all but touch.
    Moved apart along the normal n by a known way d the gap is D − d n·n', D and n' those
    found there, to some 1e-11 m.
    """
    b = _transform(placement_b)
    gap, normal = _distance(shape_a, _transform(placement_a), shape_b, b)
    if abs(gap) > WELL_APART / 2 or not abs(normal.dot(normal) - 1.0) < 1e-6:
        return gap
    for _ in range(2):
        shifted = placement_a.translation - WELL_APART * normal
        away = coal.Transform3s(placement_a.rotation, shifted)
        further, turned = _distance(shape_a, away, shape_b, b)
        gap = further - WELL_APART * float(normal.dot(turned))
        if np.abs(turned - normal).max() < 1e-6:
            break
        normal = turned
    return gap


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
) -> Iterator[MeetingPoint]:
    b = _transform(placement_b)
    a = _transform(placement_a)
    hits = _collide(shape_a, a, shape_b, b, margin)
    if hits is None:
        return
    towards_b = np.array(hits.getContact(0).normal)
    apart = coal.Transform3s(placement_a.rotation, placement_a.translation - APART * towards_b)
    depth = max(0.0, -float(hits.getContact(0).penetration_depth))
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
        yield MeetingPoint(corner + 0.5 * shift * towards_b, -towards_b, gap)


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
    # Faces are flat against each other within this much [m].
    request.setPatchTolerance(1e-6)
    result = coal.ContactPatchResult(request)
    coal.computeContactPatch(shape_a, a, shape_b, b, hits, request, result)
    if result.numContactPatches() == 0:
        return []
    patch = result.getContactPatch(0)
    return [np.array(patch.getPoint(i)) for i in range(patch.size())]
