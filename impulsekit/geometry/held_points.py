"""Points at which two bodies touch, followed as the bodies move.

A corner stays on its body and moves over a plane of the other:

    g = n·(x − o),   n fixed in the body of the plane.

Two edges that cross touch where they are nearest. With e, f their directions, a ≈ b the
nearest points and w the velocity of the first body against the other there,

    n = ± e × f / |e × f|,   g = n·(a − b),   ġ = n·w,

and that place moves along the edges at σ' and τ' with w + σ' e − τ' f along n. The axes of its
rows are R = (e, n × e, n).

Tips of round bodies: see ``held_tips``. Each is a row of a table (``point_table``); its rows and
rates are in ``rows.point_rows``, here is what its gap is, where it is and how far from its end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..laws.borrowed import borrowed, borrowing
from ..laws.compiled import entry
from .axes import contact_axes, cross
from .features import CornerOnFace, EdgesCross, TipOnFace, borders_of, inside_of
from .point_table import (
    CROSSING,
    ELLIPSOID,
    MOST,
    PLANE,
    TIP,
    Table,
    TableRow,
    back,
    crossing,
    origin,
    over_face,
    place_on_face,
    spot_of,
    table_of,
    tip_of,
)
from .polyhedron import Polyhedron
from .vectors import along, dot

__all__ = [
    "COMES_FLAT",
    "HeldPoint",
    "gaps_and_ends",
    "held_corner",
    "held_crossing",
    "held_gap",
    "held_inside",
    "held_point",
    "in_arrays",
    "on_face",
    "spots_of",
    "write_gaps_and_ends",
    "write_spots",
]

# Edges that cross at a smaller angle (sine) than when they were taken hold of, by this part,
# have become parallel.
STILL_CROSS = 1e-3
# A rim whose far side is nearer than this to the face [m] comes to lie flat.
COMES_FLAT = 2e-8

Places = Sequence[pin.SE3]


@dataclass(frozen=True, eq=False)
class HeldPoint:
    """A corner or tip of one body on a face of the other, or an edge across an edge.

    Attributes:
        feature: what touches.
        kept: what was found when it was taken hold of: of a face (9,) the axes t₁, t₂, n in the
            frame of its body, row by row, of a fixed point of a rim (12,), that point in the frame
            of its own joint behind them; of edges the sign of e × f against the normal, and the
            sine of the angle at which they cross below which they count as parallel.
        pieces: the numbers of the two, of bodies that are several.
        kind, numbers: as a ``Table`` has them. sides: which body is whose there.
        face: the polyhedron and its face that the point may leave; None of edges.
    """

    feature: CornerOnFace | EdgesCross | TipOnFace
    kept: tuple[float, ...]
    pieces: tuple[int, int]
    kind: int
    sides: tuple[int, int]
    numbers: np.ndarray
    face: tuple[Polyhedron, int] | None

    def row(self, joint_ids: tuple[int, int]) -> TableRow:
        """The row of a table, for the joints of both bodies."""
        return self.kind, joint_ids[self.sides[0]], joint_ids[self.sides[1]], self.numbers

    @cached_property
    def borders(self) -> np.ndarray:
        """``borders_of`` the face, in its body's frame; (0, 6) of edges."""
        return np.zeros((0, 6)) if self.face is None else borders_of(*self.face)


def on_face(
    feature: CornerOnFace | TipOnFace,
    ground: Polyhedron,
    at: np.ndarray,
    kept: Sequence[float],
    pieces: tuple[int, int],
    round_part: Sequence[float] | None = None,
) -> HeldPoint:
    """A point on a face.

    Args:
        feature: which; ground: whose face. kept, pieces: as of ``HeldPoint``.
        at: (3,) the point, or the middle of its ball or rim, in the frame of its joint.
        round_part: of a tip (5,) the radii of ball and rim, and the rim's axis; of an ellipsoid's
            (10,) that of its ball, and E.
    """
    side, face = feature.side, feature.face
    axes = np.array(kept[:9]).reshape(3, 3)
    on_plane = float(ground.heights[face]) * ground.normals[face]
    own = [1.0 if side == 0 else -1.0, *(round_part or ())]
    numbers = np.concatenate([at, axes.T.ravel(), on_plane, own])
    kind = PLANE
    if round_part is not None:
        kind = TIP if len(round_part) == 5 else ELLIPSOID
    return HeldPoint(feature, tuple(kept), pieces, kind, (side, 1 - side), numbers, (ground, face))


def held_corner(
    bodies: Sequence[Polyhedron],
    feature: CornerOnFace,
    kept: Sequence[float],
    pieces: tuple[int, int],
) -> HeldPoint:
    """A corner of one body on a face of the other; both in the frames of their joints."""
    at = bodies[feature.side].vertices[feature.corner]
    return on_face(feature, bodies[1 - feature.side], at, kept, pieces)


def held_crossing(
    bodies: Sequence[Polyhedron],
    feature: EdgesCross,
    kept: Sequence[float],
    pieces: tuple[int, int],
) -> HeldPoint:
    """An edge of one body across an edge of the other; both in the frames of their joints."""
    (start, e, length), (there, f, reach) = _edges(bodies, feature)
    sign, least = kept
    numbers = np.concatenate([start, e, there, f, [length, reach, sign, least]])
    return HeldPoint(feature, (sign, least), pieces, CROSSING, (0, 1), numbers, None)


def _edges(
    bodies: Sequence[Polyhedron], feature: EdgesCross
) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """Of both edges (3,) an end, (3,) the direction and the length [m]."""
    found = []
    for body, edge in zip(bodies, (feature.first, feature.other), strict=True):
        start, end = body.vertices[list(edge)]
        length = float(np.linalg.norm(end - start))
        found.append((start, (end - start) / length, length))
    return found


def held_point(
    bodies: Sequence[Polyhedron],
    feature: CornerOnFace | EdgesCross,
    normal: np.ndarray,
    places: Places,
    pieces: tuple[int, int],
) -> HeldPoint:
    """A feature taken hold of with the joints at ``places``.

    Args:
        bodies: both, in the frames of their joints.
        feature: what touches.
        normal: (3,) from the second to the first.
        places: of the joints.
        pieces: the numbers of the two, of bodies that are several.
    """
    if isinstance(feature, CornerOnFace):
        plane = 1 - feature.side
        turn = places[plane].rotation
        n = turn.dot(bodies[plane].normals[feature.face])
        # Axes that turn with the plane.
        axes = turn.T.dot(contact_axes(n if feature.side == 0 else -n))
        return held_corner(bodies, feature, axes.ravel().tolist(), pieces)
    (_, e, _), (_, f, _) = _edges(bodies, feature)
    turned_round = cross(places[0].rotation.dot(e), places[1].rotation.dot(f))
    sign = 1.0 if turned_round.dot(normal) >= 0.0 else -1.0
    least = STILL_CROSS * float(np.sqrt(turned_round.dot(turned_round)))
    return held_crossing(bodies, feature, (sign, least), pieces)


def in_arrays(places: Places) -> np.ndarray:
    """(2, 12) both placements as a table takes them: R column by column, and the origin."""
    return np.array([[*place.rotation.T.ravel(), *place.translation] for place in places])


def spots_of(points: Sequence[HeldPoint], places: Places) -> list[tuple[np.ndarray, np.ndarray]]:
    """By point, (3,) where it is and (3, 3) its axes t₁, t₂, n, with the joints at ``places``."""
    found = write_spots(_table_of(points), in_arrays(places))
    return [(own[:3], own[3:].reshape(3, 3).T) for own in found]


def gaps_and_ends(points: Sequence[HeldPoint], places: Places) -> np.ndarray:
    """(2, k) by point its gap [m] and how far it is from its end, with the joints at ``places``.

    Gaps are negative inside; ends are those of the face or of the edges [m], negative beyond.
    """
    borders = [point.borders for point in points]
    spans = np.cumsum([0, *map(len, borders)])
    every = np.concatenate([np.zeros((0, 6)), *borders])
    return write_gaps_and_ends(_table_of(points), in_arrays(places), every, spans)


def _table_of(points: Sequence[HeldPoint]) -> Table:
    """A table whose joints are the two bodies."""
    return table_of([point.row((0, 1)) for point in points])


def _examples() -> tuple[Table, np.ndarray]:
    return Table(np.zeros((1, 3), np.int64), np.ones((1, MOST))), np.zeros((2, 12))


@entry(_examples, seconds=1.5)
def write_spots(table: Table, places: np.ndarray) -> np.ndarray:
    """(n, 12) where each point is, and its axes one after the other."""
    found = np.empty((len(table.whole), 12))
    table, places = borrowed(table), borrowed(places)
    for i in range(len(found)):
        own = found[i]
        place, ways = spot_of(table, i, places)
        own[0], own[1], own[2] = place
        for k in range(3):
            own[3 + 3 * k], own[4 + 3 * k], own[5 + 3 * k] = ways[k]
    return found


def _examples_of_ends() -> tuple[Table, np.ndarray, np.ndarray, np.ndarray]:
    return *_examples(), np.zeros((0, 6)), np.zeros(2, np.int64)


@entry(_examples_of_ends, seconds=2.0)
def write_gaps_and_ends(
    table: Table, places: np.ndarray, borders: np.ndarray, spans: np.ndarray
) -> np.ndarray:
    """(2, n) as ``gaps_and_ends``, with the (b, 6) borders; ``spans`` (n + 1,) whose are whose."""
    found = np.empty((2, len(table.whole)))
    table, places = borrowed(table), borrowed(places)
    borders, spans = borrowed(borders), borrowed(spans)
    for i in range(len(table.whole)):
        found[0, i] = held_gap(table, i, places)
        found[1, i] = held_inside(table, i, places, borders, spans[i], spans[i + 1])
    return found


@borrowing
def held_gap(table: Table, i: int, places: np.ndarray) -> float:
    """The gap of a point on a face or of two edges [m], negative inside."""
    if table.whole[i, 0] == CROSSING:
        _, _, way, square, here, there, _, _ = crossing(table, i, places)
        return dot(way, along(here, -1.0, there)) / math.sqrt(square)
    return over_face(table, i, places, place_on_face(table, i, places))


@borrowing
def held_inside(
    table: Table, i: int, places: np.ndarray, borders: np.ndarray, first: int, last: int
) -> float:
    """How far a point is from where its face, of some borders, or its edge ends [m].

    Negative beyond; of a rim, how far it is from lying flat where that is less.
    """
    numbers = table.numbers[i]
    if table.whole[i, 0] == CROSSING:
        _, _, _, square, _, _, s, u = crossing(table, i, places)
        if square < numbers[15] ** 2:
            return -math.inf
        return min(min(s, numbers[12] - s), min(u, numbers[13] - u))
    two = table.whole[i, 2]
    away = along(place_on_face(table, i, places), -1.0, origin(places, two))
    room = inside_of(borders, first, last, back(places, two, away))
    if table.whole[i, 0] == TIP and numbers[17] > 0.0:
        sine = tip_of(table, i, places)[4]
        room = min(room, 2.0 * numbers[17] * sine - COMES_FLAT)
    return room
