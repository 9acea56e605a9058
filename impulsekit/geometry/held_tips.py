"""Points at which round bodies touch a face of a polyhedron or half-space, followed as both move.

A tip is where a part of the round body reaches furthest against the normal n of the face: of a
ball of radius ρ about p (a sphere, either end of a capsule) and of a rim about c (radius r, axis
a; a cylinder or cone),

    x = p − ρ n,        x = c − r d,  d = (n − (n·a) a) / |n − (n·a) a|,

and of an ellipsoid over a half-space (see ``ellipsoids``)

    x = c − Eᵀ E n / |E n| − ρ n,

which moves over both bodies, with p, c, a and E fixed in one and n in the other. Of a rim that
lies flat on the face points fixed on it stand for all of it. The axes of its rows turn with the
body of the face (``rows.point_rows``).

Corners of a polyhedron over a half-space are held here too; see ``held_points``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .axes import contact_axes
from .convex import Convex
from .ellipsoids import Ellipsoid
from .features import CornerOnFace, TipOnFace
from .held_points import HeldPoint, Places, gaps_and_ends, held_point, on_face
from .polyhedron import Polyhedron

__all__ = ["held_tip", "held_tips"]

# A rim whose far side is this near to the face [m] lies flat; above ``COMES_FLAT``.
LIES_FLAT = 3e-8
# So many points stand for a rim that lies flat.
RIM_POINTS = 8


def held_tip(
    bodies: Sequence[Convex | Ellipsoid | Polyhedron],
    feature: TipOnFace,
    kept: Sequence[float],
    pieces: tuple[int, int],
) -> HeldPoint:
    """A tip of a round body on a face of a polyhedron; both in the frames of their joints."""
    body, ground = bodies[feature.side], bodies[1 - feature.side]
    if isinstance(body, Ellipsoid) and isinstance(ground, Polyhedron):
        part = [body.radius, *body.rows.ravel()]
        return on_face(feature, ground, body.centre, kept, pieces, part)
    if not (isinstance(body, Convex) and isinstance(ground, Polyhedron)):
        raise ValueError("a tip is of a round body on a polyhedron")
    at, ball, rim = np.array(kept[9:12]), 0.0, 0.0
    if feature.rolls:
        at, ball = np.concatenate((body.points, body.centres))[feature.tip], body.radius
        if feature.tip >= len(body.points):
            rim = float(body.radii[feature.tip - len(body.points)])
    return on_face(feature, ground, at, kept, pieces, [ball, rim, *body.axis])


def held_tips(
    bodies: Sequence[Convex | Ellipsoid | Polyhedron],
    places: Places,
    margin: float,
    pieces: tuple[int, int],
) -> list[HeldPoint] | None:
    """The tips of a round body that touch a polyhedron, to be followed.

    Of a half-space also the tip of an ellipsoid, and corners. None where they touch otherwise than
    tips on one face, beside its edges.

    Args:
        bodies: a round one and a polyhedron (``endless_face`` too), in either order, in the frames
            of their joints.
        places: of the joints.
        margin: tips no further from the face touch [m].
        pieces: the numbers of the two, of bodies that are several.
    """
    if isinstance(bodies[0], Ellipsoid) or isinstance(bodies[1], Ellipsoid):
        return _held_ellipsoid(bodies, places, margin, pieces)
    if isinstance(bodies[0], Polyhedron) and isinstance(bodies[1], Polyhedron):
        return _held_corners((bodies[0], bodies[1]), places, margin, pieces)
    own = 0 if isinstance(bodies[0], Convex) else 1
    body, ground = bodies[own], bodies[1 - own]
    if not (isinstance(body, Convex) and isinstance(ground, Polyhedron)):
        return None
    relative = places[1 - own].actInv(places[own])
    there = body.at(relative.rotation, relative.translation)
    reach = -there.support(-ground.normals) - ground.heights
    face = int(reach.argmax())
    if reach[face] > margin:
        return []
    n = ground.normals[face]
    kept = _axes_kept(places, own, n)
    found: list[HeldPoint] = []
    count = len(there.points)
    out = n - n.dot(there.axis) * there.axis
    sine = float(np.sqrt(out.dot(out)))
    for tip, spot in enumerate(np.concatenate((there.points, there.centres))):
        r = float(there.radii[tip - count]) if tip >= count else 0.0
        if float(n.dot(spot)) - r * sine - there.radius - ground.heights[face] > margin:
            continue
        if r and 2.0 * r * sine <= LIES_FLAT:
            flat = TipOnFace(own, tip, face, False)
            middle = np.concatenate((body.points, body.centres))[tip]
            across = np.cross(body.axis, body.across)
            for angle in (2.0 * np.pi / RIM_POINTS * np.arange(RIM_POINTS)).tolist():
                way = np.cos(angle) * body.across + np.sin(angle) * across
                fixed = [*kept, *(middle + r * way).tolist()]
                found.append(held_tip(bodies, flat, fixed, pieces))
        else:
            found.append(held_tip(bodies, TipOnFace(own, tip, face, True), kept, pieces))
    gaps, inside = gaps_and_ends(found, places)
    if (inside < 0.0).any():
        return None
    return [tip for tip, gap in zip(found, gaps, strict=True) if gap <= margin]


def _held_ellipsoid(
    bodies: Sequence[Convex | Ellipsoid | Polyhedron],
    places: Places,
    margin: float,
    pieces: tuple[int, int],
) -> list[HeldPoint]:
    """The tip of an ellipsoid on a half-space; as ``held_tips``."""
    own = 0 if isinstance(bodies[0], Ellipsoid) else 1
    ground = bodies[1 - own]
    if not isinstance(ground, Polyhedron):
        raise ValueError("an ellipsoid is held on a half-space")
    kept = _axes_kept(places, own, ground.normals[0])
    tip = held_tip(bodies, TipOnFace(own, 0, 0, True), kept, pieces)
    return [tip] if gaps_and_ends([tip], places)[0, 0] <= margin else []


def _axes_kept(places: Places, own: int, n: np.ndarray) -> list[float]:
    """As ``HeldPoint.kept``, of a point of body ``own`` on a face with a normal in its joint."""
    turn = places[1 - own].rotation
    axes = contact_axes(turn.dot(n) * (1.0 if own == 0 else -1.0))
    return turn.T.dot(axes).ravel().tolist()


def _held_corners(
    bodies: Sequence[Polyhedron], places: Places, margin: float, pieces: tuple[int, int]
) -> list[HeldPoint]:
    """The corners of a polyhedron on a half-space; as ``held_tips``."""
    own = 1 if bodies[0].is_endless else 0
    body, ground = bodies[own], bodies[1 - own]
    relative = places[1 - own].actInv(places[own])
    over = ground.normals[0].dot(relative.translation) - ground.heights[0]
    gaps = body.vertices.dot(relative.rotation.T.dot(ground.normals[0])) + over
    normal = places[1 - own].rotation.dot(ground.normals[0]) * (1.0 if own == 0 else -1.0)
    return [
        held_point(bodies, CornerOnFace(own, corner, 0), normal, places, pieces)
        for corner in np.flatnonzero(gaps <= margin).tolist()
    ]
