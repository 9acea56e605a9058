"""Rows of relative velocity between two bodies, and their derivatives.

Formulas and conventions: ``rows.frame_pair``. Its rates are turned into derivatives by giving them
(3, nv) columns, ∂/∂q, for what has a rate there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...rows.entries import FramePair, FunctionRows, rows_of_entry
from ...rows.frame_pair import turning_of_line
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
        expanded: the model.
        said: what an entry says of two frames.

    Attributes:
        count: how many rows there are.
    """

    def __init__(self, expanded: ExpandedModel, said: FramePair) -> None:
        self._said, self.count = said, len(said.select)
        joint_ids = expanded.joint_ids
        self._joints = joint_ids[said.first.joint_id], joint_ids[said.other.joint_id]
        self._point, self._other_point = (
            pin.SE3(_EYE, site.placement.translation) for site in (said.first, said.other)
        )
        self._rows = np.eye(6)[list(said.select)].reshape(-1, 3)
        self._still = self._selector(said.axes) if said.carrier == "world" else None
        # In the world's own axes nothing has to be turned.
        self._is_level = self._still is not None and np.array_equal(self._still, np.eye(6)[:3])

    def placed(self, motion: Motion) -> PlacedPair:
        """The rows at a configuration."""
        (a, b), said, places = self._joints, self._said, motion.placements
        sides: list[Side] = []
        if a > 0:
            sides.append(Side(a, 1.0, self._point, *motion.jacobians(a, self._point), None))
        if b > 0:
            point = self._other_point
            if said.coincides:
                here = places[a].act(self._point.translation)
                point = pin.SE3(_EYE, places[b].actInv(here))
            raw, jacobian = motion.jacobians(b, point)
            moved: np.ndarray | None = None
            if said.coincides:
                # The point is where that of a is, not where it was in b.
                moved = sides[0].jacobian[:3] - jacobian[:3] if a > 0 else -jacobian[:3]
            sides.append(Side(b, -1.0, point, raw, jacobian, moved))
        angular = bool(said.angular)
        if self._still is not None:
            return PlacedPair(motion, sides, self._still, None, angular, self._is_level)
        first, other = places[a] * said.first.placement, places[b] * said.other.placement
        selector = self._selector(said.axes_at(first, other))
        turn: np.ndarray | None = None
        if said.carrier == "line":
            # Nothing acts across a rope, whose rows are those of a contact.
            selector[:-1] = 0.0
            between = first.translation - other.translation
            relative = sum((side.sign * side.jacobian[:3] for side in sides), motion.zero[:3])
            length = float(np.sqrt(between.dot(between)))
            n = tuple((between / length).tolist())
            turn = np.array(turning_of_line(n, length, tuple(relative)))
        else:
            sign = 1.0 if said.carrier == "first" else -1.0
            turn = next((side.jacobian[3:] for side in sides if side.sign == sign), None)
        return PlacedPair(motion, sides, selector, turn, angular)

    def _selector(self, axes: np.ndarray) -> np.ndarray:
        """(k, 6) the rows, of w and ω in world axes."""
        return self._rows.dot(axes.T).reshape(-1, 6)


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
            speeds = self._relative.dot(motion.speeds)[: len(total)].reshape(-1, 3)
            total = total + np.concatenate([skew(w).dot(self._turn) for w in speeds])
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
        return PairRows(expanded, said)
    if isinstance(said, FunctionRows):
        raise of_functions()
    return FixedRows(said.matrix(robot.model))
