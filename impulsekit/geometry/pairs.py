"""Two convex shapes in the frame of one of them, which is chosen by the shapes alone.

Whichever is named first, and wherever both are, the same numbers are worked out: the digits of
their places in the world are not in them, and a swap turns the normal round, no more.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from .convex import Convex, HalfSpace
from .patch import touching_patch
from .polyhedron import MOST_PRODUCTS
from .separate import separate

__all__ = ["ConvexPair", "has_closed_form"]


def has_closed_form(one: Convex | HalfSpace | None, two: Convex | HalfSpace | None) -> bool:
    """Whether a pair can be compared; not hulls of too many corners, and no two half-spaces."""
    if one is None or two is None:
        return False
    if isinstance(one, HalfSpace) or isinstance(two, HalfSpace):
        return isinstance(one, Convex) or isinstance(two, Convex)
    if one.is_polyhedron and two.is_polyhedron:
        return False
    ways = (_count(one) + len(one.ways)) * (_count(two) + len(two.ways))
    return ways * (_count(one) + _count(two)) <= MOST_PRODUCTS


class ConvexPair:
    """Two convex shapes with their placements; ``has_closed_form`` of them.

    Args:
        one, two: the shapes in their own frames.
        place_one, place_two: where they are.
    """

    def __init__(
        self,
        one: Convex | HalfSpace,
        place_one: pin.SE3,
        two: Convex | HalfSpace,
        place_two: pin.SE3,
    ) -> None:
        self._swapped = _rank(two) < _rank(one)
        if self._swapped:
            one, place_one, two, place_two = two, place_two, one, place_one
        if isinstance(two, HalfSpace):
            raise TypeError("two half-spaces")
        turn = place_one.rotation
        self._place = place_one
        self._ground = one
        away = turn.T.dot(place_two.translation - place_one.translation)
        self._other = two.at(turn.T.dot(place_two.rotation), away)
        self._found: tuple[float, np.ndarray] | None = None

    def separate(self) -> tuple[float, np.ndarray]:
        """The gap [m], and its normal (3,) in the world, from the second to the first."""
        gap, normal = self._separate()
        # Within, it goes from the first to the second.
        normal = self._place.rotation.dot(normal)
        return gap, normal if self._swapped else -normal

    def points(self, margin: float) -> tuple[np.ndarray, list[tuple[np.ndarray, float]]]:
        """That normal, and the points (3,) in the world with their gaps, no more than a margin.

        None are told if and only if the gap is larger than the margin.
        """
        gap, normal = self._separate()
        found: list[tuple[np.ndarray, float]] = []
        if gap <= margin:
            found = touching_patch(self._other, self._ground, gap, normal, margin)
        return self.separate()[1], [(self._place.act(place), here) for place, here in found]

    def _separate(self) -> tuple[float, np.ndarray]:
        """The gap [m], and the normal from the ground to the other in the ground's frame."""
        if self._found is None:
            if isinstance(self._ground, HalfSpace):
                normal = self._ground.normal
                below = float(self._other.support(-normal[None, :])[0])
                self._found = -below - self._ground.height, normal
            else:
                self._found = separate(self._other, self._ground)
        return self._found


def _count(shape: Convex) -> int:
    return len(shape.points) + len(shape.centres)


def _rank(shape: Convex | HalfSpace) -> tuple[float, ...]:
    """The ground comes first: what is flat, and of two of a kind the larger one."""
    if isinstance(shape, HalfSpace):
        return (0.0,)
    kind = 1 if shape.is_polyhedron else 4 - len(shape.centres)
    size = float(np.abs(shape.points).sum() + np.abs(shape.centres).sum())
    return float(kind), float(-len(shape.points)), -size, -float(shape.radii.sum()), -shape.radius
