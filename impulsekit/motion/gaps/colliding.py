"""The gap of two bodies, and the points at which they touch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from ...geometry.axes import contact_axes
from ...geometry.collision import (
    UNIT,
    MeetingPoint,
    Solids,
    gap_and_normal,
    is_exact,
    meeting_points,
)
from ...geometry.features import CornerOnFace, EdgesCross, TipOnFace
from ...geometry.held_pieces import (
    can_be_held,
    have_ends,
    have_features,
    polyhedra_in_joint,
    round_or_endless,
)
from ...geometry.held_points import (
    HeldPoint,
    gaps_and_ends,
    held_corner,
    held_crossing,
    held_point,
    in_arrays,
    spots_of,
)
from ...geometry.held_tips import held_tip, held_tips
from ...geometry.point_table import Kinematics, TableRow, table_of
from ...geometry.polyhedron import Polyhedron, can_be_separated, separation_at
from ...geometry.support import Shape, support_of
from ...robot import Robot
from ...rows.bodies import ball_around, bodies_of
from ...rows.ellipses import ellipse_of
from ...rows.faint import rows_at
from ...rows.reach import ReachedModel
from ...scene import Collision
from ...scene.coefficients import friction_at_rest
from ...tolerances import NONZERO
from ..tree.pressed import rows_and_bias
from .pairs import PairOfPieces, gap_if_far
from .wandering import MOVE, bias_by_differences

__all__ = ["CollidingGap"]

# A resting pair that coal tells of is looked for up to this far apart [m].
RESTING = 1e-5
# The same of pairs in closed form: what comes down is met before it is this near.
NEAR_BY = 1e-7
# Corners and edges so near touch [m].
TOUCHING = 1e-8
# Bodies with corners that approach more slowly stay [m/s]: they would hop some 1e-9 m high.
SLOW = 2e-4
# Points that rise more slowly rest: they would hop some 5e-12 m high, and round bodies that
# approach more slowly stay [m/s]. Far from the origin gaps are rounded to some 1e-14 m.
RISING = 1e-5
# Points come apart by so many times the way that a turn by the step of differences moves them.
MOVED = 4.0
# Bodies whose points are found anew have come down elsewhere where they overlap by more [m], and
# by this part of how far they are from the origin.
DRIFT = 1e-8
# How far the distance of colliding bodies may be off where they have just parted [m].
WAVER_OF_COAL = 1e-8
WAVER = 1e-10
# Of ``Kinematics`` of two bodies without rows: Jacobians, and the order of speeds.
NO_SPEEDS = np.zeros((0, 6)), np.full(2, -1), np.zeros(0, np.int64)


class CollidingGap:
    """Two bodies and the smallest distance between them.

    Attributes:
        entry: which contact of the scene it is.
        friction: µ.
        has_corners: whether both are polyhedra, whose points can always be held.
        has_tips: whether one is round and the other a polyhedron or half-space, piece by piece,
            or both are polyhedra: then points can be held that are on faces.
        exact: whether the gap is told to rounding.
        capture_speed: slower approaches are met without restitution [m/s].
        rest_speed: slower points rest [m/s].
        waver: how far the distance may be off [m].
        joint_ids: of both bodies.
        held: the points that are held, another list whenever they are others; None where none are.
        pairs: of their convex pieces, each of the first with each of the other.
    """

    has_rate = False

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Collision, index: int) -> None:
        self.entry, self.friction = index, friction_at_rest(entry.friction)
        self._model = reached.model
        bodies = bodies_of(robot, entry)
        self._pieces = bodies.pieces
        first, other = bodies.joint_ids
        self.joint_ids = (reached.joint_id(first), reached.joint_id(other))
        self._reaches = [ball_around(pieces) for pieces in self._pieces]
        self._shifted: pin.Data | None = None
        self._polyhedra = [polyhedra_in_joint(pieces) for pieces in self._pieces]
        self.has_corners = all(
            a is not None and b is not None and can_be_separated(a, b)
            for a in self._polyhedra[0]
            for b in self._polyhedra[1]
        )
        supports = [[support_of(p.geometry, at) for p, at in own] for own in self._pieces]
        self.pairs = tuple(
            self._pair(supports, i, j)
            for i in range(len(self._pieces[0]))
            for j in range(len(self._pieces[1]))
        )
        self._shapes = [
            [shape or round_or_endless(*piece) for shape, piece in zip(own, pieces, strict=True)]
            for own, pieces in zip(self._polyhedra, self._pieces, strict=True)
        ]
        shapes = [(a, b) for a in self._shapes[0] for b in self._shapes[1]]
        self.has_tips = not self.has_corners and all(can_be_held(a, b) for a, b in shapes)
        self._has_features = any(have_features(a, b) for a, b in shapes)
        # Hops lower than what can be told are none.
        self.exact = all(is_exact(a, b) for a, _ in self._pieces[0] for b, _ in self._pieces[1])
        self._margin = NEAR_BY if self.exact else max(bodies.margin, RESTING)
        if self.has_corners:
            self._margin = TOUCHING
        self.rest_speed = RISING if self.exact else 0.0
        # Ends of a capsule, and of a rim, lift each other in turn as corners do.
        ends = any(have_ends(a, b) for a, b in shapes)
        slow = self.has_corners or (self.has_tips and ends)
        self.capture_speed = SLOW if slow else self.rest_speed
        self.waver = WAVER if self.exact else WAVER_OF_COAL
        self._ellipse = ellipse_of(robot, reached, entry, index)
        self.held: list[HeldPoint] | None = None

    @property
    def smaller_radius(self) -> float:
        """Of the balls around the two bodies that of the smaller one [m]."""
        return min(radius for _, radius in self._reaches)

    def distance(self, data: pin.Data) -> float:
        """The gap [m], negative where they overlap; ``data`` with placements.

        Bodies far from each other may be further apart than it says.
        """
        places = self._places(data)
        (a, reach_a), (b, reach_b) = self._reaches
        apart = gap_if_far(places[0].act(a).tolist(), reach_a, places[1].act(b).tolist(), reach_b)
        if apart > -np.inf:
            return apart
        return min(pair.gap(places)[0] for pair in self.pairs)

    @property
    def balls(self) -> np.ndarray:
        """(8,) the balls around both bodies: centre, in the joint's frame, and radius [m]."""
        (a, reach_a), (b, reach_b) = self._reaches
        return np.array([*a, reach_a, *b, reach_b])

    def drift(self, data: pin.Data) -> float:
        """Overlaps of less may be drift within a step [m]; ``data`` with placements."""
        places = self._places(data)
        return DRIFT * (1.0 + max(float(np.abs(place.translation).max()) for place in places))

    def hold(self, data: pin.Data | None) -> None:
        """Follow the points that touch now from here on, or with None let go of them.

        Only for bodies with corners, and for round ones on faces; ``data`` with placements.
        """
        self.held = None
        if data is not None and self.has_corners:
            self.held = self._touching(self._places(data))
        elif data is not None and self.has_tips:
            self.held = self._touching_tips(self._places(data), TOUCHING)

    def in_table(self) -> list[TableRow] | None:
        """The held points as rows of a table; None where points are found anew each time."""
        if self.held is None or self._ellipse is not None:
            return None
        return [point.row(self.joint_ids) for point in self.held]

    def keep(self, points: np.ndarray) -> None:
        """Let go of held points but those told: (k,) True for what stays."""
        self.held = [p for p, stays in zip(self.held or (), points, strict=True) if stays]

    def held_gaps(self, data: pin.Data) -> np.ndarray:
        """(k,) the gap of each held point [m]; ``data`` with placements."""
        return gaps_and_ends(self.held or (), self._places(data))[0]

    def held_inside(self, data: pin.Data) -> np.ndarray:
        """(k,) how far each held point is from the end of its face or edges [m]."""
        return gaps_and_ends(self.held or (), self._places(data))[1]

    def point_again(
        self,
        pieces: tuple[int, int],
        feature: CornerOnFace | EdgesCross | TipOnFace,
        kept: Sequence[float],
    ) -> HeldPoint:
        """A held point out of what there was of it."""
        if isinstance(feature, TipOnFace):
            return held_tip(self._both(pieces), feature, kept, pieces)
        bodies = self._bodies(pieces)
        if isinstance(feature, CornerOnFace):
            return held_corner(bodies, feature, kept, pieces)
        return held_crossing(bodies, feature, kept, pieces)

    def spots(self, data: pin.Data) -> list[tuple[np.ndarray, np.ndarray]]:
        """By point, (3,) where it is and (3, 3) its axes t₁, t₂, n; ``data`` with placements.

        Of friction by direction the tangents have its units (``ways_of_ellipse``).
        """
        return self._spots(data, self._margin)

    def _spots(self, data: pin.Data, margin: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """As ``spots``; points that are found anew up to so far apart."""
        places, own = self._places(data), self._ellipse
        points = self._points(places, margin)
        if points is None:
            meeting = self._meeting(places, margin)
            found = [(p.position, contact_axes(p.normal)) for p in meeting]
        else:
            found = spots_of(points, places)
        if own is None:
            return found
        return [(position, own.axes(axes, data)) for position, axes in found]

    def rows(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(3k, nv) of all points that touch; ``data`` with joint Jacobians."""
        return self._rows_of(data, self.spots(data))

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(3k,) the rows' rates at zero joint acceleration.

        ``data`` with placements, velocities, and accelerations at zero joint acceleration.
        """
        places = self._places(data)
        points = self._points(places, self._margin)
        if points is None:
            if self._shifted is None:
                self._shifted = self._model.createData()
            here = self._wandering(data)[1]
            # Points move by the way of a body's turn there.
            size = self.smaller_radius if self.exact else 0.0
            near = self._margin + MOVED * MOVE * size

            def found(data: pin.Data) -> tuple[np.ndarray, np.ndarray]:
                return self._wandering(data, near)

            return bias_by_differences(self._model, self._shifted, found, here, q, v)
        speeds, rates = (
            np.array([of[i].vector for i in self.joint_ids]) for of in (data.v, data.a)
        )
        table = table_of([point.row((0, 1)) for point in points])
        _, rates = rows_and_bias(table, Kinematics(in_arrays(places), speeds, rates, *NO_SPEEDS))
        if (ellipse := self._ellipse) is not None:
            # Where tangential rates count, nothing slips: how fast the units turn does not.
            by_point = zip(spots_of(points, places), rates.reshape(-1, 3), strict=True)
            own = [ellipse.ways(axes, data).T.dot(rate) for (_, axes), rate in by_point]
            return np.array(own).ravel()
        return rates

    def _places(self, data: pin.Data) -> list[pin.SE3]:
        return [data.oMi[joint_id] for joint_id in self.joint_ids]

    def _placed(self, places: list[pin.SE3]) -> list[Solids]:
        return [
            [(solid, place * placement) for solid, placement in pieces]
            for pieces, place in zip(self._pieces, places, strict=True)
        ]

    def _meeting(
        self, places: list[pin.SE3], margin: float | None = None
    ) -> Iterator[MeetingPoint]:
        first, other = self._placed(places)
        return meeting_points(first, other, self._margin if margin is None else margin)

    def _touching(self, places: list[pin.SE3], *, of_corners: bool = False) -> list[HeldPoint]:
        """The corners and edges that touch."""
        found: list[HeldPoint] = []
        for point in self._meeting(places):
            if point.feature is not None and (self.has_corners or of_corners):
                if point.gap > TOUCHING:
                    continue
                bodies = self._bodies(point.pieces)
                found.append(held_point(bodies, point.feature, point.normal, places, point.pieces))
        return found

    def _points(self, places: list[pin.SE3], margin: float) -> list[HeldPoint] | None:
        """Those held, or those that could be held now, tips up to so far apart; None without."""
        if self.held is not None or not (self.has_corners or self.has_tips):
            return self.held
        return self._touching(places) if self.has_corners else self._touching_tips(places, margin)

    def _touching_tips(self, places: list[pin.SE3], margin: float) -> list[HeldPoint] | None:
        """The tips and corners that touch; None where one is no tip on a face."""
        found: list[HeldPoint] = []
        if self._has_features:
            found = self._touching(places, of_corners=True)
        for i, one in enumerate(self._shapes[0]):
            for j, two in enumerate(self._shapes[1]):
                if not have_features(one, two):
                    tips = held_tips(self._both((i, j)), places, margin, (i, j))
                    if tips is None:
                        return None
                    found += tips
        return found or None

    def _pair(self, supports: list[list[Shape]], i: int, j: int) -> PairOfPieces:
        """Two pieces, each with its placement in the frame of its joint."""
        (one, at_one), (two, at_two) = self._pieces[0][i], self._pieces[1][j]
        a, b = self._polyhedra[0][i], self._polyhedra[1][j]
        polyhedra = None if a is None or b is None or not can_be_separated(a, b) else (a, b)

        def gap(places: Sequence[pin.SE3]) -> tuple[float, np.ndarray]:
            if polyhedra is not None:
                return separation_at(polyhedra[0], places[0], polyhedra[1], places[1])
            a, b = places[0] * at_one, places[1] * at_two
            value, normal = gap_and_normal(one, a, two, b)
            if not abs(normal.dot(normal) - 1.0) < UNIT:
                # Where bodies touch, coal may lose the direction.
                normal = a.translation - b.translation
                normal = normal / max(float(np.linalg.norm(normal)), NONZERO)
            return value, normal

        both = supports[0][i], supports[1][j]
        over = is_exact(one, two) and any(len(shape.normal) for shape in both)
        return PairOfPieces(gap, both, polyhedra, over)

    def _both(self, pieces: tuple[int, int]) -> list[Any]:
        return [of[i] for of, i in zip(self._shapes, pieces, strict=True)]

    def _bodies(self, pieces: tuple[int, int]) -> tuple[Polyhedron, Polyhedron]:
        first, other = (of[i] for of, i in zip(self._shapes, pieces, strict=True))
        if not (isinstance(first, Polyhedron) and isinstance(other, Polyhedron)):
            raise ValueError("a curved body has no corners")
        return first, other

    def _wandering(
        self, data: pin.Data, margin: float | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """(3k, nv) rows and (k, 3) points; ``data`` with joint Jacobians."""
        spots = self._spots(data, self._margin if margin is None else margin)
        points = np.array([position for position, _ in spots]).reshape(-1, 3)
        return self._rows_of(data, spots), points

    def _rows_of(
        self, data: pin.Data, spots: Sequence[tuple[np.ndarray, np.ndarray]]
    ) -> np.ndarray:
        """(3k, nv); ``data`` with joint Jacobians."""
        if not spots:
            return np.empty((0, self._model.nv))
        return np.vstack([rows_at(self._model, data, self.joint_ids, *spot) for spot in spots])
