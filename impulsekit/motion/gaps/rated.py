"""Gaps that come with their rates: of points over planes, and of joints before their limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...geometry.point_table import PLANE, ROPE, STOP, TableRow
from ...robot import Robot
from ...rows.ellipses import ways_of_ellipse
from ...rows.entries import FramePair, FunctionRows, frame_pair, joint_rows
from ...rows.pair import Pair
from ...rows.reach import ReachedModel
from ...scene import Contact, GapContact, JointStop, Rope
from ...scene.coefficients import EllipticFriction, friction_at_rest

__all__ = ["FunctionGap", "PlaneGap", "RopeGap", "StopGap"]


class _RatedGap:
    """What gaps with rates have in common with those of colliding bodies: they hold no points."""

    has_rate = exact = True
    held = None
    waver = rest_speed = capture_speed = 0.0


class _PairGap(_RatedGap):
    """Of a point and what it meets or hangs on."""

    arms: float
    _pair: Pair

    def spots(self, data: pin.Data) -> list[tuple[np.ndarray, np.ndarray]]:
        """(3,) the point, (3, 3) its axes (n along a rope), in a list; ``data`` with placements."""
        point, _ = self._pair.placements(data)
        return [(point.translation.copy(), self._pair.axes(data))]

    def rows(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(3, nv); ``data`` with joint Jacobians."""
        return self._pair.rows(data)

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(3,) the rows' rates at zero joint acceleration."""
        return self._pair.bias(data)


class PlaneGap(_PairGap):
    """A point over a plane: n·(p − o), and n·(v_p − v_plane there)."""

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Contact, index: int) -> None:
        self.entry, self.friction = index, friction_at_rest(entry.friction)
        self._model = reached.model
        said = _in_own_units(frame_pair(robot, entry), entry.friction, index)
        self._pair = Pair(reached, said)
        self._fixed = not said.other.moves
        self.joint_ids = (self._pair.first.joint_id, self._pair.other.joint_id)
        # In the world, or in the axes of the plane's frame.
        self._origin = said.other.placement.translation
        self.arms = _arms(reached.model, self._pair.first.frame_id)
        self.arms += float(np.abs(self._origin).max())
        if not self._fixed:
            self.arms += _arms(reached.model, self._pair.other.frame_id)

    def in_table(self) -> list[TableRow]:
        """The point as the row of a table."""
        pair = self._pair
        joint_id, axes = (0, pair.said.axes) if self._fixed else self._carrying()
        at = pair.first.placement.translation
        numbers = np.concatenate([at, axes.T.ravel(), self._origin, [1.0]])
        return [(PLANE, pair.first.joint_id, joint_id, numbers)]

    def _carrying(self) -> tuple[int, np.ndarray]:
        """The joint of a plane that moves, and (3, 3) R in its frame."""
        return self._pair.other.joint_id, self._pair.said.carrying[1]


def _in_own_units(said: FramePair, friction: object, index: int) -> FramePair:
    """A plane with the tangents for which µ is 1, where friction is an ellipse."""
    if not isinstance(friction, EllipticFriction):
        return said
    # The axes of what moves are in its frame, as the ellipse is.
    turn = np.eye(3) if said.other.moves else said.other.placement.rotation
    ways = ways_of_ellipse(friction, said.axes, turn, index)
    return replace(said, axes=said.axes.dot(ways))


class RopeGap(_PairGap):
    """Two points on a rope: its length − |p − o|, and the rate of that."""

    friction = 0.0

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Rope, index: int) -> None:
        self.entry, self._length = index, entry.length
        self._pair = Pair(reached, frame_pair(robot, entry))
        ends = (self._pair.first, self._pair.other)
        self.arms = sum(_arms(reached.model, end.frame_id) for end in ends) + entry.length

    def in_table(self) -> list[TableRow]:
        """The rope as the row of a table."""
        first, other, numbers = self._pair.first, self._pair.other, np.zeros(16)
        numbers[:3], numbers[3:6] = first.placement.translation, other.placement.translation
        numbers[6] = self._length
        return [(ROPE, first.joint_id, other.joint_id, numbers)]


class FunctionGap(_RatedGap):
    """A gap that is a function of q, and the rate of that."""

    def __init__(self, robot: Robot, entry: GapContact, index: int, name: str) -> None:
        self.entry, self.friction = index, entry.friction
        self.said = FunctionRows(robot, entry, name)

    def in_table(self) -> None:
        """No compiled code knows it."""

    def gap_and_rate(self, q: np.ndarray, v: np.ndarray) -> tuple[float, float]:
        """The gap and its rate at a state."""
        return float(self.said.value(q)[0]), float(self.said.matrix_at(q)[2].dot(v))

    def spots(self, data: pin.Data) -> list[tuple[None, np.ndarray]]:
        """No place in the world; its forces are told by row."""
        return [(None, np.eye(3))]

    def rows(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(3, nv)."""
        return self.said.matrix_at(q)

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(3,) the rows' rates at zero joint acceleration."""
        return self.said.bias(q, v)


class StopGap(_RatedGap):
    """A joint before one of its limits.

    Attributes:
        entry: which contact of the scene it is.
        sign: 1 for the lower limit, -1 for the upper one: which way it pushes.
    """

    friction = 0.0

    def __init__(
        self, robot: Robot, reached: ReachedModel, entry: JointStop, index: int, side: int
    ) -> None:
        said = joint_rows(robot, entry)
        (((joint_id, _, _),),) = said.terms
        joint = reached.model.joints[reached.joint_id(joint_id)]
        self.entry = index
        self._row, self._entry_in_q = joint.idx_v, joint.idx_q
        self.sign = 1.0 if side == 0 else -1.0
        self._limit = entry.limits(robot)[side]
        self.arms = abs(self._limit)
        self._rows = np.zeros((3, reached.model.nv))
        self._rows[2] = self.sign * said.matrix(reached.model, reached.joint_id)[0]

    def in_table(self) -> list[TableRow]:
        """The stop as the row of a table."""
        numbers = np.zeros(16)
        numbers[:3] = self._rows[2, self._row], self.sign, self._limit
        return [(STOP, self._row, self._entry_in_q, numbers)]

    def rows(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(3, nv), of which only the normal row is used."""
        return self._rows

    def bias(self, data: pin.Data, q: np.ndarray, v: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(3,) zero."""
        return np.zeros(3)


def _arms(model: pin.Model, frame_id: int) -> float:
    """How far apart the joints that carry a frame, and it, are together [m]."""
    frame = model.frames[frame_id]
    joint_ids = [j for j in model.supports[frame.parentJoint] if j > 0]
    arms = [model.jointPlacements[j].translation for j in joint_ids]
    return sum(float(np.abs(arm).max()) for arm in [*arms, frame.placement.translation])
