"""The points at which two convex shapes touch, given how far they are apart and along what.

Of each shape that part of the surface touches which is within the margin of the other's, or
inside it: a point, a segment (an edge, the side of a cylinder or a capsule), a polygon or the
disc of a rim. Seen along the normal two such parts overlap, and the points of contact are the
ends of the overlap:

    point and anything        the point
    segments that cross       the point where they do
    segments side by side     both ends of the stretch
    segment and face, disc    both ends of what is left of the segment
    faces, discs              the corners of the overlap, and along what is left of a rim points
                              no further than an eighth of the circle from each other, evenly
    a whole rim               eight points evenly, the first where the other body's first edge
                              points; between two round faces where their own axes do

A disc counts as flat if all of its rim is within the margin, else its furthest point alone
touches. None of this asks which body is the first, or where the world's axes are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .convex import Convex, HalfSpace
from .features import BESIDE, ONE_POINT, ROUNDING, SINE

__all__ = ["touching_patch"]

# A share below this is rounding error: of an edge out of the face, of a piece of an arc.
SLIVER = 1e-6
# An arc beyond a rim by less than this is on it [m].
WITHIN = 1e-3 * BESIDE
# So many points stand for a whole rim.
RIM_POINTS = 8
FULL = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class _Part:
    """What of a shape reaches furthest, seen along the normal.

    Attributes:
        corners: (k, 2) of a point, a segment or a polygon against the clock; or the middle of a
            disc [m].
        radius: of the disc, else 0 [m].
        levels: (k,) heights of the corners along the normal [m].
        level, slope: height at a place x between them: level + slope·x [m].
        round: how far a segment is from the line it is parallel to all around [m].
        across: (2,) where the first point of a rim is, not of unit length.
    """

    corners: np.ndarray
    radius: float
    levels: np.ndarray
    level: float
    slope: np.ndarray
    round: float
    across: np.ndarray

    @property
    def size(self) -> int:
        """0 of a point, 1 of a segment, 2 of what has an area."""
        return 2 if self.radius > 0.0 else min(len(self.corners) - 1, 2)

    def height(self, place: np.ndarray) -> float:
        """At a place (2,) [m]."""
        away = np.abs(self.corners - place).max(axis=1)
        if away.min() <= ONE_POINT:
            return float(self.levels[away.argmin()])
        return self.level + float(self.slope.dot(place))


def touching_patch(
    a: Convex, b: Convex | HalfSpace, gap: float, normal: np.ndarray, margin: float
) -> list[tuple[np.ndarray, float]]:
    """The points where two shapes are no further apart than ``margin`` [m], at least one.

    Args:
        a, b: the shapes.
        gap, normal: as ``separate`` tells them; gap is no more than the margin.
        margin: [m].

    Returns:
        Points (3,), all halfway between both surfaces and in one plane, with their gaps [m].
    """
    t = _across(normal)
    frame = np.array((t, np.cross(normal, t)))
    spots = np.concatenate((a.points, a.centres))
    if isinstance(b, Convex):
        spots = np.concatenate((spots, b.points, b.centres))
    near = margin - gap + ROUNDING * float(np.ptp(spots, axis=0).max())
    part_a = _part(a, -normal, frame, normal, near)
    below = -float(a.support(-normal[None, :])[0])
    if isinstance(b, Convex):
        part_b = _part(b, normal, frame, normal, near)
        far = b.farthest(normal)
    else:
        part_b, far = _below(a, frame, b.height), a.farthest(-normal)
    level = below - 0.5 * gap
    found: list[tuple[np.ndarray, float]] = []
    for place, more in _overlap(part_a, part_b, max(margin - gap, 0.0)):
        here = part_a.height(place) - part_b.height(place) + more
        if here > gap + near or any(np.abs(place - known).max() <= ONE_POINT for known, _ in found):
            continue
        found.append((place, here))
    if not found:
        found = [(0.5 * frame.dot(a.farthest(-normal) + far), gap)]
    return [(place.dot(frame) + level * normal, here) for place, here in found]


def _below(shape: Convex, frame: np.ndarray, height: float) -> _Part:
    """What of a plane is below a shape, and more."""
    spots = np.concatenate((shape.points, shape.centres)).dot(frame.T)
    reach = 1.0 + shape.radius + float(shape.radii.sum())
    (x, y), (z, w) = spots.min(axis=0) - reach, spots.max(axis=0) + reach
    corners = np.array(((x, y), (z, y), (z, w), (x, w)))
    return _Part(
        corners, 0.0, np.full(4, height), height, np.zeros(2), 0.0, frame.dot(shape.across)
    )


def _across(normal: np.ndarray) -> np.ndarray:
    t = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    return t / np.linalg.norm(t)


def _part(
    shape: Convex, way: np.ndarray, frame: np.ndarray, normal: np.ndarray, near: float
) -> _Part:
    """What of a shape is within ``near`` of what reaches furthest along ``way`` [m].

    What touches is in the half that looks to the other shape.
    """
    near = min(near, 0.5 * float(shape.support(np.array((way, -way))).sum()))
    out = way - way.dot(shape.axis) * shape.axis
    sine = float(np.sqrt(out.dot(out)))
    heights = [float(p.dot(way)) for p in shape.points]
    heights += [
        float(c.dot(way)) + r * sine for c, r in zip(shape.centres, shape.radii, strict=True)
    ]
    top = max(heights)
    on = [i for i, height in enumerate(heights) if height >= top - near]
    count = len(shape.points)
    across = frame.dot(shape.across)
    for i in on:
        if i >= count and 2.0 * shape.radii[i - count] * sine <= near:
            middle, r = shape.centres[i - count], float(shape.radii[i - count])
            upright = shape.axis if shape.axis.dot(normal) > 0.0 else -shape.axis
            slope = -frame.dot(upright) / float(upright.dot(normal))
            spot = frame.dot(middle)
            height = float(middle.dot(normal))
            level = height - float(slope.dot(spot))
            return _Part(spot[None, :], r, np.array([height]), level, slope, 0.0, across)
    rim = out / sine if sine > 0.0 else out
    tips = np.array(
        [
            shape.points[i]
            if i < count
            else shape.centres[i - count] + shape.radii[i - count] * rim
            for i in on
        ]
    )
    tips = tips + shape.radius * way
    spots, levels = tips.dot(frame.T), tips.dot(normal)
    around = shape.radius + (float(shape.radii[0]) if len(shape.radii) > 1 else 0.0)
    if len(on) > 2:
        return _polygon(shape, spots, levels, way, normal, frame, around)
    slope = np.zeros(2)
    if len(on) == 2:
        along = spots[1] - spots[0]
        square = float(along.dot(along))
        slope = (levels[1] - levels[0]) / square * along if square > 0.0 else slope
    level = float(levels[0] - slope.dot(spots[0]))
    return _Part(spots, 0.0, levels, level, slope, around, across)


def _polygon(
    shape: Convex,
    spots: np.ndarray,
    levels: np.ndarray,
    way: np.ndarray,
    normal: np.ndarray,
    frame: np.ndarray,
    around: float,
) -> _Part:
    middle = spots.mean(axis=0)
    angles = np.arctan2(*(spots - middle).T[::-1])
    order = np.argsort(angles, kind="stable")
    face = shape.normals[int(shape.normals.dot(way).argmax())]
    slope = -frame.dot(face) / float(face.dot(normal))
    level = float(np.mean(levels)) - float(slope.dot(middle))
    # Its edges lie in the face, whichever is the first of the shape.
    inside = shape.ways - np.outer(shape.ways.dot(way), way)
    lies = np.flatnonzero(np.linalg.norm(inside, axis=1) > 1.0 - SLIVER)
    across = shape.ways[lies[0]] if len(lies) else shape.across
    return _Part(spots[order], 0.0, levels[order], level, slope, around, frame.dot(across))


def _overlap(a: _Part, b: _Part, rise: float) -> list[tuple[np.ndarray, float]]:
    """Ends of what two parts share, (2,), and how much further apart they are there [m]."""
    if a.size > b.size:
        a, b = b, a
    if a.size == 0:
        place = 0.5 * (a.corners[0] + b.corners[0]) if b.size == 0 else a.corners[0]
        return [(place, 0.0)]
    if a.size == 1 and b.size == 1:
        return _two_segments(a, b, rise)
    if a.size == 1:
        ends = _clipped(a.corners, b, 0.0) or _clipped(a.corners, b, BESIDE)
        return [(end, 0.0) for end in ends]
    places = _two_areas(a, b)
    return [(place, 0.0) for place in places]


def _two_segments(a: _Part, b: _Part, rise: float) -> list[tuple[np.ndarray, float]]:
    e, f = a.corners[1] - a.corners[0], b.corners[1] - b.corners[0]
    if e.dot(e) < f.dot(f):
        a, b, e, f = b, a, f, e
    # The shorter one seen along the longer.
    length = float(np.sqrt(e.dot(e)))
    along = e / length
    side = np.array((-along[1], along[0]))
    shares = (b.corners - a.corners[0]).dot(along)
    offsets = (b.corners - a.corners[0]).dot(side)
    low, high = max(0.0, float(shares.min())), min(length, float(shares.max()))
    around = a.round + b.round
    found = []
    reach = float(shares[1] - shares[0])
    if high > low and abs(reach) > 0.0:
        for share in (low, high):
            part = (share - shares[0]) / reach
            off = float(offsets[0] + part * (offsets[1] - offsets[0]))
            more = off * off / (np.hypot(around, off) + around) if off else 0.0
            more = more if around > 0.0 else abs(off) / SINE
            if more <= rise:
                place = a.corners[0] + share * along + 0.5 * off * side
                found.append((place, more))
    if len(found) == 2:
        return found
    turn = float(offsets[0] - offsets[1])
    if turn == 0.0:
        return found
    part = min(max(float(offsets[0]) / turn, 0.0), 1.0)
    return [(b.corners[0] + part * (b.corners[1] - b.corners[0]), 0.0)]


def _clipped(segment: np.ndarray, area: _Part, beside: float) -> list[np.ndarray]:
    """The ends of what of a segment lies over an area, or beside it by this much."""
    start, way = segment[0], segment[1] - segment[0]
    low, high = 0.0, 1.0
    if area.radius > 0.0:
        shares = _line_and_circle(start - area.corners[0], way, area.radius + beside)
        if shares is None:
            return []
        low, high = max(low, shares[0]), min(high, shares[1])
    else:
        for corner, inwards in _sides(area.corners):
            over = float(inwards.dot(start - corner)) + beside
            rate = float(inwards.dot(way))
            if rate == 0.0:
                if over < 0.0:
                    return []
            elif rate > 0.0:
                low = max(low, -over / rate)
            else:
                high = min(high, -over / rate)
    if low > high:
        return []
    return [start + low * way, start + high * way]


def _sides(corners: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """By side of a polygon one of its corners, and the unit vector inwards."""
    ways = np.roll(corners, -1, axis=0) - corners
    sizes = np.sqrt(np.einsum("ij,ij->i", ways, ways))
    inwards = np.stack((-ways[:, 1], ways[:, 0]), axis=1)
    return [
        (corner, side / size)
        for corner, side, size in zip(corners, inwards, sizes, strict=True)
        if size > 0.0
    ]


def _line_and_circle(
    start: np.ndarray, way: np.ndarray, radius: float
) -> tuple[float, float] | None:
    """The shares of a way at which a line cuts a circle about the origin."""
    square = float(way.dot(way))
    if square == 0.0:
        return (0.0, 1.0) if float(start.dot(start)) <= radius * radius else None
    middle = -float(start.dot(way)) / square
    foot = start + middle * way
    rest = radius * radius - float(foot.dot(foot))
    if rest < 0.0:
        return None
    half = float(np.sqrt(rest / square))
    return middle - half, middle + half


def _two_areas(a: _Part, b: _Part) -> list[np.ndarray]:
    """The ends of what two areas share."""
    if a.radius == 0.0 and b.radius == 0.0:
        ends = [p for p in a.corners if _lies_in(p, b, BESIDE)]
        ends += [p for p in b.corners if _lies_in(p, a, BESIDE)]
        for i in range(len(a.corners)):
            ends += _clipped(a.corners[[i, (i + 1) % len(a.corners)]], b, 0.0)
        return ends
    if a.radius > 0.0 and b.radius > 0.0:
        small, large = (a, b) if a.radius <= b.radius else (b, a)
        ends = _arcs(small, large)
        if float(np.linalg.norm(small.corners[0] - large.corners[0])) > ONE_POINT:
            ends += _arcs(large, small)
        return ends
    disc, polygon = (a, b) if a.radius > 0.0 else (b, a)
    corners = [p for p in polygon.corners if _lies_in(p, disc, BESIDE)]
    return corners + _arcs(disc, polygon)


def _lies_in(place: np.ndarray, area: _Part, beside: float) -> bool:
    if area.radius > 0.0:
        return float(np.linalg.norm(place - area.corners[0])) <= area.radius + beside
    return all(float(side.dot(place - corner)) >= -beside for corner, side in _sides(area.corners))


def _arcs(disc: _Part, area: _Part) -> list[np.ndarray]:
    """Points along what of a disc's rim lies over an area."""
    middle, r = disc.corners[0], disc.radius
    # What of the rim each side cuts off: about an angle, by so much to both sides.
    cuts: list[tuple[float, float]] = []
    if area.radius > 0.0:
        way = middle - area.corners[0]
        apart = float(np.linalg.norm(way))
        if apart + r > area.radius + WITHIN and apart > 0.0:
            cosine = (area.radius**2 - r * r - apart * apart) / (2.0 * r * apart)
            if cosine <= -1.0:
                return []
            if cosine < 1.0:
                cuts.append((float(np.arctan2(way[1], way[0])), float(np.arccos(cosine))))
    else:
        for corner, inwards in _sides(area.corners):
            over = float(inwards.dot(middle - corner))
            if over <= -r:
                return []
            if over < r:
                about = float(np.arctan2(-inwards[1], -inwards[0]))
                cuts.append((about, float(np.arccos(over / r))))
    if not cuts:
        first = _first_angle(disc, area)
        return [_on_rim(middle, r, first + k * FULL / RIM_POINTS) for k in range(RIM_POINTS)]
    ends: list[np.ndarray] = []
    for start, length in _kept(cuts):
        pieces = max(int(np.ceil(length / (FULL / RIM_POINTS) - SLIVER)), 1)
        ends += [_on_rim(middle, r, start + k * length / pieces) for k in range(pieces + 1)]
    return ends


def _kept(cuts: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The arcs that are left of a circle: begin and length."""
    begin = cuts[0][0] + cuts[0][1]
    spans = sorted(((about - half - begin) % FULL, 2.0 * half) for about, half in cuts[1:])
    end = FULL - 2.0 * cuts[0][1]
    kept, at = [], 0.0
    wraps = [start + length - FULL for start, length in spans if start + length > FULL]
    at = max([at, *wraps])
    for start, length in spans:
        if start > at:
            kept.append((begin + at, min(start, end) - at))
        at = max(at, start + length)
    if end > at:
        kept.append((begin + at, end - at))
    return [(start, length) for start, length in kept if length > 0.0]


def _first_angle(disc: _Part, area: _Part) -> float:
    """Where the first point of a whole rim is [rad], up to an eighth of a turn."""
    if area.radius == 0.0:
        return float(np.arctan2(area.across[1], area.across[0]))
    if disc.radius < area.radius:
        return float(np.arctan2(disc.across[1], disc.across[0]))
    # Halfway between the points that either would have.
    turns = [
        np.exp(1j * RIM_POINTS * np.arctan2(part.across[1], part.across[0]))
        for part in (disc, area)
    ]
    return float(np.angle(turns[0] + turns[1])) / RIM_POINTS


def _on_rim(middle: np.ndarray, r: float, angle: float) -> np.ndarray:
    return middle + r * np.array((np.cos(angle), np.sin(angle)))
