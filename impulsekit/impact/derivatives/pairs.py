"""Rows of relative velocity between two bodies, and their derivatives.

A pair has up to six rows, u = Rᵀ (v_a(c_a) − v_b(c_b)) and the same of ω. The axes R
turn with the world, a or b; the point c_b is one of b or the one that coincides with c_a.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...rows.entries import FramePair, FunctionRows, axes_of_line, rows_of_entry
from .motion import Motion
from .pulls import Pulls, skew

if TYPE_CHECKING:
    from ...robot import Robot
    from .expanded import ExpandedModel

__all__ = [
    "FixedRows",
    "PairRows",
    "PlacedPair",
    "Side",
    "entry_rows",
    "of_functions",
    "pair_rows",
]

_EYE = np.eye(3)


class FixedRows:
    """Rows (k, nv) that do not depend on the configuration: locks, couplings, stops."""

    def __init__(self, matrix: np.ndarray) -> None:
        self.matrix, self.count = matrix, len(matrix)

    def placed(self, motion: Motion) -> FixedRows:
        """Itself: it stands everywhere alike."""
        return self

    def change_of_velocity(self) -> np.ndarray | None:
        """(k, nv) ∂(G v)/∂q at the speeds of the motion; None for zero."""
        return None

    def pull(self, pulls: Pulls, impulse: np.ndarray) -> None:
        """Nothing: ∂(Gᵀp)/∂q is zero."""

    is_level = False

    def turned(self, impulse: np.ndarray) -> np.ndarray | None:
        """(3, nv) how an impulse (3,) in the world turns with the axes; None for not."""
        return None


class PairRows:
    """Rows between two bodies of a model.

    Args:
        first, other: the joints that carry a and b; 0 for the world.
        at: (3,) c_a in the joint of a (or in the world).
        other_at: (3,) c_b in the joint of b; None for the point that coincides with c_a.
        axes_joint: the joint that R turns with; 0 for the world.
        axes: (3, 3) R in that joint's frame.
        select: which of the six rows there are.

    Attributes:
        angular: whether any of the rows is one of ω.
        count: how many rows there are.
    """

    def __init__(
        self,
        first: int,
        other: int,
        at: np.ndarray,
        other_at: np.ndarray | None,
        axes_joint: int,
        axes: np.ndarray,
        select: tuple[int, ...],
    ) -> None:
        self.first, self.other, self.axes_joint = first, other, axes_joint
        self.at = at
        self.point = pin.SE3(_EYE, at)
        self.other_point = None if other_at is None else pin.SE3(_EYE, other_at)
        self.angular, self.count = any(row > 2 for row in select), len(select)
        # (k, 6): the rows, of the velocity of the point and of ω in the joint of the axes.
        self.selector = np.kron(np.eye(2), axes.T)[list(select)]
        # In the world's own axes nothing has to be turned.
        self.is_level = axes_joint == 0 and bool(np.array_equal(self.selector, np.eye(6)[:3]))

    def placed(self, motion: Motion) -> PlacedPair:
        """The rows at a configuration."""
        a, b, fixed = self.first, self.other, self.axes_joint
        places = motion.placements
        sides: list[Side] = []
        if a > 0:
            sides.append(Side(a, 1.0, self.point, *motion.jacobians(a, self.point), None))
        if b > 0:
            point = self.other_point
            if point is None:
                here = places[a].act(self.at) if a > 0 else self.at
                point = pin.SE3(_EYE, places[b].actInv(here))
            raw, jacobian = motion.jacobians(b, point)
            moved: np.ndarray | None = None
            if self.other_point is None:
                # The point is where that of a is, not where it was in b.
                moved = sides[0].jacobian[:3] - jacobian[:3] if a > 0 else -jacobian[:3]
            sides.append(Side(b, -1.0, point, raw, jacobian, moved))
        turn: np.ndarray | None = None
        selector = self.selector
        if fixed > 0:
            turning = next((side.jacobian for side in sides if side.joint == fixed), None)
            if turning is None:
                _, turning = motion.jacobians(fixed, pin.SE3.Identity())
            turn = turning[3:]
            rotation = places[fixed].rotation
            selector = (selector.reshape(-1, 3) @ rotation.T).reshape(-1, 6)
        return PlacedPair(motion, sides, selector, turn, self.angular, self.is_level)


class LineRows(PairRows):
    """Rows along the line between two points, which turns as these move.

    With d = (c_a − c_b)/L, ḋ = (1 − d dᵀ)(v_a − v_b)/L, so the line turns by d × (v_a − v_b)/L.
    """

    def __init__(self, first: int, other: int, said: FramePair) -> None:
        ends = [np.array(site.placement.translation) for site in (said.first, said.other)]
        super().__init__(first, other, ends[0], ends[1], 0, _EYE, said.select)
        self._ends, self._axes, self._select = ends, said.axes, list(said.select)
        self.is_level = False

    def placed(self, motion: Motion) -> PlacedPair:
        """The rows at a configuration."""
        places, sides, ends = motion.placements, [], []
        for joint, sign, at in zip((self.first, self.other), (1.0, -1.0), self._ends, strict=True):
            ends.append(places[joint].act(at) if joint > 0 else at)
            if joint > 0:
                point = pin.SE3(_EYE, at)
                sides.append(Side(joint, sign, point, *motion.jacobians(joint, point), None))
        between = ends[0] - ends[1]
        selector = np.kron(np.eye(2), axes_of_line(between, self._axes).T)[self._select]
        # Nothing acts across a rope, whose rows are those of a contact.
        selector[:-1] = 0.0
        relative = sum((side.sign * side.jacobian[:3] for side in sides), motion.zero[:3])
        turn = skew(between).dot(relative) / between.dot(between)
        return PlacedPair(motion, sides, selector, turn, False)


class Side(NamedTuple):
    """One body of a pair.

    Attributes:
        joint: the one that carries it.
        sign: 1 for a, −1 for b.
        point: of the body.
        raw, jacobian: how the point moves and turns with the body: (6, ·) with the
            configuration of the expanded model, and (6, nv) with that of the robot.
        moved: (3, nv) how the point of the pair leaves that of the body; None for not.
    """

    joint: int
    sign: float
    point: pin.SE3
    raw: np.ndarray
    jacobian: np.ndarray
    moved: np.ndarray | None


class PlacedPair:
    """A pair at a configuration.

    Args:
        sides: of its bodies; those that do not move are left out.
        selector: (k, 6) the rows, of relative velocity and ω in the world's axes.
        turn: (3, nv) how the axes turn with the configuration; None for not.
        angular: whether any of the rows is one of ω.
        is_level: whether the axes are the world's, and the rows those of the velocity.

    Attributes:
        matrix: (k, nv) G, the rows.
    """

    def __init__(
        self,
        motion: Motion,
        sides: Sequence[Side],
        selector: np.ndarray,
        turn: np.ndarray | None,
        angular: bool,
        is_level: bool = False,
    ) -> None:
        self._motion, self._sides, self._selector = motion, sides, selector
        self._turn, self._angular = turn, angular
        self.is_level = is_level
        # A body that hangs on the world by fixed joints alone moves nowhere.
        both = motion.zero
        if sides:
            both = sides[0].jacobian if sides[0].sign > 0.0 else -sides[0].jacobian
        if len(sides) == 2:
            both = both - sides[1].jacobian
        self._relative = both
        self.matrix = self._in_axes(both)

    def _in_axes(self, table: np.ndarray) -> np.ndarray:
        if self.is_level:
            return table[:3]
        return self._selector[:, : len(table)].dot(table)

    def change_of_velocity(self) -> np.ndarray | None:
        """(k, nv) ∂(G v)/∂q at the speeds of the motion; None for zero."""
        if not self._sides:
            return None
        motion = self._motion
        total = np.zeros(0)
        for joint, sign, point, _, _, moved in self._sides:
            change = motion.change_of_velocity(joint, point)
            if moved is not None:
                change = change + skew(motion.turning(joint)).dot(moved)
            if self._angular:
                change = np.concatenate((change, motion.change_of_turning(joint)))
            if sign < 0.0:
                change = total - change if len(total) else -change
            total = change
        if self._turn is not None and motion.speeds is not None:
            speeds = self._relative.dot(motion.speeds)
            total = total + _crossing(speeds)[: len(total)].dot(self._turn)
        return self._in_axes(total)

    def pull(self, pulls: Pulls, impulse: np.ndarray) -> None:
        """Add ∂(Gᵀp)/∂q."""
        couple: np.ndarray | None = None
        if self.is_level:
            force = impulse
        else:
            wrench = impulse.dot(self._selector)
            force, couple = wrench[:3], wrench[3:] if self._angular else None
        for _, sign, _, raw, jacobian, moved in self._sides:
            if sign < 0.0:
                force, couple = -force, None if couple is None else -couple
            if moved is not None:
                pulls.add(jacobian[3:].T.dot(skew(-force).dot(moved)))
            pulls.push(raw, force, couple)
            if self._turn is not None:
                pulls.add(jacobian[:3].T.dot(skew(-force).dot(self._turn)))
                if couple is not None:
                    pulls.add(jacobian[3:].T.dot(skew(-couple).dot(self._turn)))

    def turned(self, impulse: np.ndarray) -> np.ndarray | None:
        """(3, nv) how an impulse (3,) in the world turns with the axes."""
        return None if self._turn is None else -skew(impulse).dot(self._turn)


def _crossing(wrench: np.ndarray) -> np.ndarray:
    """(6, 3) K with K θ = (f × θ, c × θ) for a wrench or twist (f, c)."""
    x, y, z, a, b, c = wrench.tolist()
    return np.array(
        (
            (0.0, -z, y),
            (z, 0.0, -x),
            (-y, x, 0.0),
            (0.0, -c, b),
            (c, 0.0, -a),
            (-b, a, 0.0),
        )
    )


def pair_rows(expanded: ExpandedModel, said: FramePair) -> PairRows:
    """The rows of what an entry says of two frames."""
    first, other = said.first, said.other
    if said.carrier == "line":
        return LineRows(
            expanded.joint_ids[first.joint_id], expanded.joint_ids[other.joint_id], said
        )
    carrier, axes = said.carrying
    return PairRows(
        expanded.joint_ids[first.joint_id],
        expanded.joint_ids[other.joint_id],
        np.array(first.placement.translation),
        # The world stands still: any of its points will do.
        None if said.coincides or not other.moves else np.array(other.placement.translation),
        expanded.joint_ids[carrier],
        axes,
        said.select,
    )


def of_functions() -> InputError:
    """The error for rows that are functions of q, whose own derivatives nobody gives."""
    return InputError(
        "derivatives of scenes with a GapConstraint or a GapContact are not available: they "
        "would take second derivatives of its functions"
    )


def entry_rows(robot: Robot, expanded: ExpandedModel, entry: Any) -> PairRows | FixedRows:
    """The rows of an impulse, a constraint or a contact between two frames."""
    said = rows_of_entry(robot, entry)
    if isinstance(said, FramePair):
        return pair_rows(expanded, said)
    if isinstance(said, FunctionRows):
        raise of_functions()
    return FixedRows(said.matrix(robot.model))
