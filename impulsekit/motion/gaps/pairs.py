"""Pairs of convex pieces of colliding bodies, and those of them in arrays that are closed.

Closed are two polyhedra, and over a half-space all whose reach is told in closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...geometry.point_table import back, turned
from ...geometry.polyhedron import Hull, Polyhedron, separate
from ...geometry.support import NO_ROWS, NOTHING, Shape, furthest
from ...geometry.vectors import Vector, along, dot, row_of
from ...laws.borrowed import borrowing
from ...laws.compiled import compiled, entry

__all__ = [
    "NO_PAIRS",
    "Held",
    "PairOfPieces",
    "Pairs",
    "gap_if_far",
    "gap_of",
    "pairs_of",
    "shape_of",
    "write_gaps",
]

# Bodies further apart than this part of the smaller one are not looked at more closely.
FAR = 0.1


@dataclass(frozen=True, eq=False)
class PairOfPieces:
    """Two convex pieces, one of each body.

    Attributes:
        gap: from the placements of both bodies to the gap [m] and its normal (3,).
        supports: of both, in the frames of their bodies.
        polyhedra: they themselves there; None where one is none, or has too many edges.
        over: whether one is a half-space, over which the gap of the other is told to rounding.
    """

    gap: Callable[[Sequence[pin.SE3]], tuple[float, np.ndarray]]
    supports: tuple[Shape, Shape]
    polyhedra: tuple[Polyhedron, Polyhedron] | None
    over: bool

    @property
    def is_closed(self) -> bool:
        """Whether compiled code knows its gap."""
        return self.over or self.polyhedra is not None


class Pairs(NamedTuple):
    """Pairs that are closed.

    Attributes:
        whole: (p, 5) of each pair the number of its gap, both joints and both pieces.
        spans: (s, 8) of each piece from where to where its rows are, in the next four.
        vertices, axes, directions: of all pieces, in the frames of their joints; see ``Hull``.
        points: likewise, about their centres; see ``Shape``. discs: (k,) those of the points.
        centres: (s, 3). sizes: (s, 3) reach, radius and ball [m].
        has: (s, 3) whether a piece has discs, an ellipsoid, a normal.
        ways: (5s, 3) by piece the axis of its discs, E, and the normal.
        nothing, no_rows: (0,) and (0, 3).
    """

    whole: np.ndarray
    spans: np.ndarray
    vertices: np.ndarray
    axes: np.ndarray
    directions: np.ndarray
    points: np.ndarray
    discs: np.ndarray
    centres: np.ndarray
    sizes: np.ndarray
    has: np.ndarray
    ways: np.ndarray
    nothing: np.ndarray
    no_rows: np.ndarray


class Held(NamedTuple):
    """Where points that rest end, and which pairs of pieces they are on.

    Attributes:
        borders: (b, 6) of faces, by edge: the direction inwards and a corner; in the joint's frame.
        spans: (n, 2) from where to where the borders of a point's face are.
        pairs: (r, 3) a pair, and from where to where its body's points are.
        held: (n,) which points are held.
    """

    borders: np.ndarray
    spans: np.ndarray
    pairs: np.ndarray
    held: np.ndarray


NO_PAIRS = Pairs(
    np.zeros((0, 5), np.int64),
    np.zeros((0, 8), np.int64),
    NO_ROWS,
    NO_ROWS,
    NO_ROWS,
    NO_ROWS,
    NOTHING,
    NO_ROWS,
    NO_ROWS,
    np.zeros((0, 3), np.bool_),
    NO_ROWS,
    NOTHING,
    NO_ROWS,
)
# Columns of ``Pairs.has``, and of the rows of a piece among ``Pairs.ways`` the last.
DISCS, ELLIPSOID, ENDLESS = 0, 1, 2
ROWS = 5


def pairs_of(
    found: Sequence[tuple[int, tuple[int, int], Sequence[PairOfPieces]]],
) -> Pairs:
    """All pairs of some gaps, whose pieces are closed.

    ``found``: by gap its number, the joints of both bodies, and the pairs of their pieces.
    """
    whole: list[tuple[int, ...]] = []
    # Pieces take part in several pairs.
    numbers: dict[tuple[int, int], int] = {}
    pieces: list[tuple[Polyhedron | None, Shape]] = []
    for gap, joint_ids, pairs in found:
        for pair in pairs:
            own = []
            for body, support in zip(pair.polyhedra or (None, None), pair.supports, strict=True):
                key = id(body), id(support)
                if key not in numbers:
                    numbers[key] = len(pieces)
                    pieces.append((body, support))
                own.append(numbers[key])
            whole.append((gap, *joint_ids, *own))
    if not whole:
        return NO_PAIRS
    columns = [_rows_of(*piece) for piece in pieces]
    spans = np.zeros((len(pieces), 8), dtype=np.int64)
    for k in range(4):
        ends = np.cumsum([len(own[k]) for own in columns])
        spans[1:, 2 * k], spans[:, 2 * k + 1] = ends[:-1], ends
    rows = [np.concatenate([own[k] for own in columns]) for k in range(4)]
    supports = [support for _, support in pieces]
    return Pairs(
        np.array(whole, dtype=np.int64),
        spans,
        rows[0],
        rows[1],
        rows[2],
        rows[3],
        np.concatenate([s.discs if len(s.discs) else np.zeros(len(s.points)) for s in supports]),
        np.array([s.centre for s in supports]),
        np.array([(s.reach, s.radius, s.ball) for s in supports]),
        np.array([[len(part) > 0 for part in (s.discs, s.ellipsoid, s.normal)] for s in supports]),
        np.concatenate([_ways_of(s) for s in supports]),
        NOTHING,
        NO_ROWS,
    )


def _rows_of(body: Polyhedron | None, support: Shape) -> list[np.ndarray]:
    """Vertices, axes and directions of a piece, and the points of its support."""
    own = (NO_ROWS,) * 3 if body is None else (body.vertices, body.axes, body.directions)
    return [np.ascontiguousarray(part) for part in (*own, support.points)]


def _ways_of(support: Shape) -> np.ndarray:
    """(5, 3) as ``Pairs.ways`` has them."""
    ways = np.zeros((ROWS, 3))
    for place, part in ((0, support.axis), (slice(1, 4), support.ellipsoid), (4, support.normal)):
        if len(part):
            ways[place] = part
    return ways


@borrowing
def _at(places: np.ndarray, j: int, x: Vector) -> Vector:
    """A point of a joint's frame, in the world."""
    place = places[j]
    at = (place[9], place[10], place[11])
    for k in range(3):
        at = along(at, x[k], (place[3 * k], place[3 * k + 1], place[3 * k + 2]))
    return at


@compiled
def shape_of(pairs: Pairs, k: int) -> Shape:
    """How far a piece reaches."""
    start, end, first, has = pairs.spans[k, 6], pairs.spans[k, 7], ROWS * k, pairs.has[k]
    none, no, ways, sizes = pairs.nothing, pairs.no_rows, pairs.ways, pairs.sizes[k]
    return Shape(
        pairs.centres[k],
        pairs.points[start:end],
        pairs.discs[start:end] if has[DISCS] else none,
        ways[first] if has[DISCS] else none,
        ways[first + 1 : first + 4] if has[ELLIPSOID] else no,
        ways[first + 4] if has[ENDLESS] else none,
        sizes[2],
        sizes[0],
        sizes[1],
    )


@compiled
def _hull(pairs: Pairs, k: int) -> Hull:
    spans = pairs.spans[k]
    return Hull(
        pairs.vertices[spans[0] : spans[1]],
        pairs.axes[spans[2] : spans[3]],
        pairs.directions[spans[4] : spans[5]],
    )


@compiled
def _over(
    pairs: Pairs, j: int, piece: int, k: int, ground: int, places: np.ndarray
) -> tuple[float, np.ndarray]:
    """The gap of a joint's piece over a half-space of another, and the normal to it."""
    shape, plane = shape_of(pairs, piece), shape_of(pairs, ground)
    n = turned(places, k, row_of(pairs.ways, ROWS * ground + 4))
    down = back(places, j, (-n[0], -n[1], -n[2]))
    here = _at(places, j, (shape.centre[0], shape.centre[1], shape.centre[2]))
    there = _at(places, k, (plane.centre[0], plane.centre[1], plane.centre[2]))
    gap = dot(n, along(here, -1.0, there)) - furthest(shape, np.array(down))
    return gap, np.array(n)


@compiled
def gap_of(pairs: Pairs, i: int, places: np.ndarray) -> tuple[float, np.ndarray]:
    """The gap of a pair [m] and its normal (3,); ``places`` of joints, as ``Memory`` shows them."""
    whole = pairs.whole[i]
    if pairs.has[whole[4], ENDLESS]:
        return _over(pairs, whole[1], whole[3], whole[2], whole[4], places)
    if pairs.has[whole[3], ENDLESS]:
        gap, normal = _over(pairs, whole[2], whole[4], whole[1], whole[3], places)
        return gap, -normal
    one, two = np.empty((4, 3)), np.empty((4, 3))
    one[:3] = places[whole[1], :9].copy().reshape((3, 3))
    two[:3] = places[whole[2], :9].copy().reshape((3, 3))
    one[3], two[3] = places[whole[1], 9:] - places[whole[2], 9:], 0.0
    gap, x, y, z = separate(_hull(pairs, whole[3]), one, _hull(pairs, whole[4]), two)
    return gap, np.array((x, y, z))


@borrowing
def gap_if_far(a: Vector, reach_a: float, b: Vector, reach_b: float) -> float:
    """The gap of balls around two bodies [m]; −∞ where these are to be looked at themselves."""
    between = along(a, -1.0, b)
    apart = math.sqrt(dot(between, between)) - reach_a - reach_b
    return apart if apart > FAR * min(reach_a, reach_b) else -math.inf


def _examples() -> tuple[Pairs, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    return NO_PAIRS, np.zeros((0, 8)), np.zeros((1, 12)), np.zeros(0, np.bool_), NOTHING


@entry(_examples, seconds=4.0)
def write_gaps(
    pairs: Pairs, balls: np.ndarray, places: np.ndarray, asked: np.ndarray, found: np.ndarray
) -> None:
    """Write the gaps (m,) that are asked for [m], of those that are of pairs.

    Args:
        pairs: all of them. balls: (m, 8) by gap, a ball around both bodies: centre and radius.
        places: of joints, as ``Memory`` shows them.
        asked: (m,) by gap. found: (m,) written.
    """
    for i in range(len(pairs.whole)):
        if asked[pairs.whole[i, 0]]:
            found[pairs.whole[i, 0]] = math.inf
    for i in range(len(pairs.whole)):
        gap, one, two = pairs.whole[i, 0], pairs.whole[i, 1], pairs.whole[i, 2]
        if not asked[gap]:
            continue
        ball = balls[gap]
        a = _at(places, one, (ball[0], ball[1], ball[2]))
        b = _at(places, two, (ball[4], ball[5], ball[6]))
        value = gap_if_far(a, ball[3], b, ball[7])
        if value == -math.inf:
            value = gap_of(pairs, i, places)[0]
        # NaN has to reach the result.
        if not value >= found[gap]:
            found[gap] = value
