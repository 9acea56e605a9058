"""Points at which round bodies touch a face of a polyhedron, followed as both move.

A tip is where a part of the round body reaches furthest against the normal n of the face: of a
ball of radius ρ about p (a sphere, either end of a capsule) and of a rim about c (radius r, axis
a; a cylinder or cone),

    x = p − ρ n,        x = c − r d,  d = (n − (n·a) a) / |n − (n·a) a|,

which moves over both bodies at ẋ, with p, c and a fixed in one and n in the other. Of a rim that
lies flat on the face points fixed on it stand for all of it. With v, a, ω the velocities and
accelerations of the material points at x, ' of the body of the face, and R axes fixed there,

    u = Rᵀ (v − v'),   u̇ = Rᵀ (a + ω × (ẋ − v) − a' − ω' × (ẋ − v') − ω' × (v − v')).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .axes import contact_axes, cross
from .convex import Convex
from .features import beside
from .held_points import Motions, Places, point_motion
from .polyhedron import Polyhedron

__all__ = ["HeldTip", "TipOnFace", "held_tips"]

# A rim whose far side is this near to the face [m] lies flat; one that is followed comes to lie
# where it is nearer than the second.
LIES_FLAT, COMES_FLAT = 3e-8, 2e-8
# So many points stand for a rim that lies flat.
RIM_POINTS = 8


@dataclass(frozen=True)
class TipOnFace:
    """A tip of one body on a face of the other.

    Attributes:
        side: whose tip it is, 0 for the first body.
        tip: its number among the points, then the circles, of the round body.
        face: the number of the face.
        rolls: whether it is where the body reaches furthest; False of a point fixed on the body.
    """

    side: int
    tip: int
    face: int
    rolls: bool


class HeldTip:
    """A tip of a round body on a face of a polyhedron.

    Args:
        bodies: both, in the frames of their joints.
        feature: which tip and face.
        kept: (9,) the axes t₁, t₂, n in the frame of the face's body, row by row; of a fixed
            point (12,), the point in the frame of its own joint behind them.
        pieces: the numbers of the two, of bodies that are several.

    Attributes:
        feature, kept, pieces: as given.
    """

    def __init__(
        self,
        bodies: Sequence[Convex | Polyhedron],
        feature: TipOnFace,
        kept: Sequence[float],
        pieces: tuple[int, int] = (0, 0),
    ) -> None:
        self.feature, self.kept, self.pieces = feature, tuple(kept), pieces
        self._own, self._plane = feature.side, 1 - feature.side
        body, ground = bodies[self._own], bodies[self._plane]
        if not (isinstance(body, Convex) and isinstance(ground, Polyhedron)):
            raise ValueError("a tip is of a round body on a polyhedron")
        self._ground = ground
        self._sign = 1.0 if feature.side == 0 else -1.0
        self._normal = ground.normals[feature.face]
        self._height = float(ground.heights[feature.face])
        self._axes = np.array(self.kept[:9]).reshape(3, 3)
        spots = np.concatenate((body.points, body.centres))
        self._ball, self._rim, self._axis = body.radius, 0.0, body.axis
        if feature.rolls:
            self._at = spots[feature.tip]
            if feature.tip >= len(body.points):
                self._rim = float(body.radii[feature.tip - len(body.points)])
        else:
            self._at, self._ball = np.array(self.kept[9:12]), 0.0

    def _tip(self, places: Places) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
        """(3,) x, (3,) n, (3,) d and |n − (n·a) a| (0 where there is no rim), in the world."""
        own, plane = places[self._own], places[self._plane]
        n = plane.rotation.dot(self._normal)
        x, d, sine = own.act(self._at) - self._ball * n, n, 0.0
        if self._rim:
            a = own.rotation.dot(self._axis)
            d = n - n.dot(a) * a
            sine = float(np.sqrt(d.dot(d)))
            # Flat against the face, any point of the rim is as near.
            d = d / sine if sine > 0.0 else plane.rotation.dot(self._axes[:, 0])
            x = x - self._rim * d
        return x, n, d, sine

    def in_numbers(self) -> tuple[tuple[int, int], np.ndarray]:
        """Which body is whose, the tip's and the face's, and (21,) what a table says of it.

        The middle, the axes column by column and a point of the face, each in the frame of its
        body's joint, the sign of the rows, the radii of ball and rim, and the rim's axis.
        """
        on_plane = self._height * self._normal
        round_part = [self._sign, self._ball, self._rim, *self._axis]
        numbers = np.concatenate([self._at, self._axes.T.ravel(), on_plane, round_part])
        return (self._own, self._plane), numbers

    def _over(self, places: Places, x: np.ndarray) -> np.ndarray:
        return places[self._plane].actInv(x)

    def gap(self, places: Places) -> float:
        """[m]; negative inside."""
        x = self._tip(places)[0]
        return float(self._normal.dot(self._over(places, x))) - self._height

    def within(self, places: Places) -> float:
        """How far it is inside the face [m], negative beside it."""
        return beside(self._ground, self.feature.face, self._over(places, self._tip(places)[0]))

    def inside(self, places: Places) -> float:
        """The same, or how far its rim is from lying flat [m]; negative beyond."""
        room = self.within(places)
        if not self._rim:
            return room
        return min(room, 2.0 * self._rim * self._tip(places)[3] - COMES_FLAT)

    def place(self, places: Places) -> tuple[np.ndarray, np.ndarray]:
        """(3,) the point and (3, 3) its axes t₁, t₂, n."""
        return self._tip(places)[0], places[self._plane].rotation.dot(self._axes)

    def bias(self, places: Places, velocities: Motions, accelerations: Motions) -> np.ndarray:
        """(3,) the rates of the rows' velocities where no joint accelerates."""
        x, n, d, sine = self._tip(places)
        own, plane = self._own, self._plane
        (v, rate), (below, below_rate) = (
            point_motion(places[i], velocities[i], accelerations[i], x) for i in (own, plane)
        )
        spin, turning = (places[i].rotation.dot(velocities[i].angular) for i in (own, plane))
        moves = v
        if self._ball or self._rim:
            # The material point of the middle, and how the way from there to the tip turns.
            n_rate = cross(turning, n)
            moves = v + cross(spin, places[own].act(self._at) - x) - self._ball * n_rate
        if self._rim and sine > 0.0:
            a = places[own].rotation.dot(self._axis)
            a_rate = cross(spin, a)
            out = n_rate - (n_rate.dot(a) + n.dot(a_rate)) * a - n.dot(a) * a_rate
            moves = moves - self._rim / sine * (out - d.dot(out) * d)
        change = rate + cross(spin, moves - v) - below_rate - cross(turning, moves - below)
        change = change - cross(turning, v - below)
        axes = places[plane].rotation.dot(self._axes)
        return self._sign * axes.T.dot(change)


def held_tips(
    bodies: Sequence[Convex | Polyhedron],
    places: Places,
    margin: float,
    pieces: tuple[int, int] = (0, 0),
) -> list[HeldTip] | None:
    """The tips of a round body that touch a polyhedron, to be followed.

    None where they touch otherwise than tips on one face, beside its edges.

    Args:
        bodies: a round one and a polyhedron, in either order, in the frames of their joints.
        places: of the joints.
        margin: tips no further from the face touch [m].
        pieces: the numbers of the two, of bodies that are several.
    """
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
    axes = contact_axes(places[1 - own].rotation.dot(n) * (1.0 if own == 0 else -1.0))
    kept = places[1 - own].rotation.T.dot(axes).ravel().tolist()
    found: list[HeldTip] = []
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
                found.append(HeldTip(bodies, flat, fixed, pieces))
        else:
            found.append(HeldTip(bodies, TipOnFace(own, tip, face, True), kept, pieces))
    if any(tip.within(places) < 0.0 for tip in found):
        return None
    return [tip for tip in found if tip.gap(places) <= margin]
