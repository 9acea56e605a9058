"""Points of frames, and the rows of two at a configuration with their rates, by Pinocchio.

Formulas and conventions: ``frame_pair``.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from pinocchio import computeFrameJacobian, getFrameJacobian

from ..geometry.vectors import Vector, along
from .entries import FramePair, Site
from .frame_pair import PointMotion, motion_at, passing, relative_rate, turning_of_line
from .reach import ReachedModel, branch_of

__all__ = ["Pair", "PointOnFrame", "ends_at", "jacobian_in_world_axes", "sizes_of_terms"]

_ALIGNED = pin.LOCAL_WORLD_ALIGNED
# No arm, and no turning.
_HERE = (0.0, 0.0, 0.0)


class PointOnFrame:
    """A point of a frame, with a frame of its own in the model.

    Attributes:
        joint_id: the joint that carries it; 0 for the world.
        moves: whether one does.
        frame_id: the frame at the point, with the axes of the frame it belongs to.
        placement: of that frame in the joint's.
    """

    def __init__(self, reached: ReachedModel, site: Site) -> None:
        self.joint_id = reached.joint_id(site.joint_id)
        self.moves, self.placement = site.moves, site.placement
        name = f"point {reached.model.nframes}"
        self.frame_id = reached.model.addFrame(
            pin.Frame(name, self.joint_id, 0, self.placement, pin.FrameType.OP_FRAME), False
        )
        self._uneven = reached.has_uneven_lengths

    def jacobian(
        self,
        model: pin.Model,
        data: pin.Data,
        q: np.ndarray | None,
        reference: pin.ReferenceFrame,
    ) -> np.ndarray:
        """(6, nv) linear before angular; without q, of ``data`` with joint Jacobians."""
        if q is None:
            jacobian: np.ndarray = getFrameJacobian(model, data, self.frame_id, reference)
        elif self._uneven and reference == pin.LOCAL_WORLD_ALIGNED:
            return jacobian_in_world_axes(model, data, q, self.frame_id)
        else:
            jacobian = computeFrameJacobian(model, data, q, self.frame_id, reference)
        # With one degree of freedom Pinocchio gives (6,) for (6, 1).
        return jacobian if jacobian.ndim == 2 else jacobian.reshape(6, 1)


def jacobian_in_world_axes(
    model: pin.Model, data: pin.Data, q: np.ndarray, frame_id: int
) -> np.ndarray:
    """(6, nv) ``computeFrameJacobian`` in LOCAL_WORLD_ALIGNED, with the digits of LOCAL.

    Pinocchio forms the former from places in the world: where a short lever hangs on a long
    one, its digits are lost. Those of LOCAL are formed from the frame upwards, and leave the
    frame's own placement behind.
    """
    local = computeFrameJacobian(model, data, q, frame_id, pin.LOCAL)
    rotation: np.ndarray = data.iMf[0].rotation
    return np.matmul(rotation, local.reshape(2, 3, -1)).reshape(6, -1)


class Pair:
    """A pair of frames on a reached model, which is given a frame for each point.

    Attributes:
        said: the pair.
        first, other: the two points.
    """

    def __init__(self, reached: ReachedModel, said: FramePair) -> None:
        self.said, self._model = said, reached.model
        self.first, self.other = (PointOnFrame(reached, site) for site in (said.first, said.other))
        rows = list(said.select)
        # All six rows, or the first three, are a slice: no copy.
        self._select = slice(0, len(rows)) if rows == list(range(len(rows))) else rows
        self._carries = said.coincides and said.other.moves
        self._turns = said.carrier != "world"
        self._on_line = said.carrier == "line"
        self._turn = None if said.is_level else said.axes.T.copy()
        self._reference = _ALIGNED
        # Against the world, in its axes or in the frame's own, Pinocchio's Jacobian is the answer.
        self.is_alone = (
            said.first.moves
            and not said.other.moves
            and said.carrier in ("world", "first")
            and (self._turn is None or not said.angular)
        )
        if self.is_alone and self._turns:
            self._reference = pin.LOCAL
        self._turn_selected = None if self._turn is None or said.angular else self._turn[rows]

    @property
    def ends_that_move(self) -> list[PointOnFrame]:
        """Those of the two points that a joint carries."""
        return [end for end in (self.first, self.other) if end.moves]

    @property
    def is_free(self) -> bool:
        """Whether the one point that moves hangs under a free-flyer: no row can vanish there."""
        ends = self.ends_that_move
        roots = [self._model.joints[branch_of(self._model, end.joint_id)] for end in ends]
        return [root.shortname() for root in roots] == ["JointModelFreeFlyer"]

    def placements(self, data: pin.Data) -> tuple[pin.SE3, pin.SE3]:
        """Of both points, with the axes of their frames; ``data`` with placements of joints."""
        first = pin.updateFramePlacement(self._model, data, self.first.frame_id)
        other = pin.updateFramePlacement(self._model, data, self.other.frame_id)
        return first, other

    def axes(self, data: pin.Data) -> np.ndarray:
        """(3, 3) R in the world; ``data`` with placements of joints."""
        return self.said.axes_at(*self.placements(data)) if self._turns else self.said.axes

    def jacobian(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(k, nv) the rows at q; ``data`` may hold anything."""
        if self.is_alone:
            rows = self.first.jacobian(self._model, data, q, self._reference)
            if self._turn_selected is None:
                return rows[self._select]
            return self._turn_selected.dot(rows[:3])
        first, other = self.ends(data, q)
        return self._selected(first - other)

    def rows(self, data: pin.Data) -> np.ndarray:
        """(k, nv) the rows; ``data`` with joint Jacobians."""
        first, other = self.ends(data)
        return self._selected(first - other)

    def ends(self, data: pin.Data, q: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """(6, nv) of both ends, whose difference has the rows.

        At the point of the first where they coincide, in the axes of the rows. Without q, of
        ``data`` with joint Jacobians.
        """
        model, turn = self._model, self._turn
        first, other = (
            end.jacobian(model, data, q, _ALIGNED) if end.moves else np.zeros((6, model.nv))
            for end in (self.first, self.other)
        )
        if self._turns or self._carries:
            if q is not None:
                pin.forwardKinematics(model, data, q)
            one, two = self.placements(data)
            if self._carries:
                other = other.copy()
                other[:3] -= pin.skew(one.translation - two.translation).dot(other[3:])
            if self._turns:
                turn = self.said.axes_at(one, two).T
        if turn is None:
            return first, other
        return _turned(turn, first), _turned(turn, other)

    def _selected(self, rows: np.ndarray) -> np.ndarray:
        """What there is of six rows, or of the first three."""
        rows = rows[self._select]
        if self._on_line:
            # Nothing acts across a rope, whose rows are those of a contact.
            rows[:-1] = 0.0
        return rows

    def distance(self, data: pin.Data) -> float:
        """How far both points are apart [m]; ``data`` with placements of joints."""
        first, other = self.placements(data)
        return float(np.linalg.norm(first.translation - other.translation))

    def bias(self, data: pin.Data) -> np.ndarray:
        """(k,) the rates of the rows' velocities where no joint accelerates.

        ``data`` with placements, velocities, and accelerations at zero joint acceleration.
        """
        said = self.said
        if not (said.other.moves or self._turns) and self._turn is None:
            own = self.first.frame_id
            rate = pin.getFrameClassicalAcceleration(self._model, data, own, _ALIGNED)
            return rate.vector[self._select]
        places = self.placements(data)
        between = places[0].translation - places[1].translation
        first, first_spin = self._motion(data, self.first, _HERE)
        arm = tuple(between.tolist()) if self._carries else _HERE
        other, other_spin = self._motion(data, self.other, arm)
        if self._carries:
            other = passing(other, first.velocity)
        turning = _HERE
        if self._on_line:
            length, w = float(np.sqrt(between.dot(between))), along(first[0], -1.0, other[0])
            turning = turning_of_line(tuple((between / length).tolist()), length, w)
        elif self._turns:
            turning = (first if said.carrier == "first" else other).spin
        turn = said.axes_at(*places).T
        rate = turn.dot(relative_rate(first, other, turning))
        if said.angular:
            spin_rate = turn.dot(relative_rate(first_spin, other_spin, turning))
            rate = np.concatenate([rate, spin_rate])
        return self._selected(rate)

    def _motion(
        self, data: pin.Data, end: PointOnFrame, arm: Vector
    ) -> tuple[PointMotion, PointMotion]:
        """How the point at an arm from an end moves, and likewise how its ω does."""
        velocity = pin.getFrameVelocity(self._model, data, end.frame_id, _ALIGNED).vector.tolist()
        rate = pin.getFrameAcceleration(self._model, data, end.frame_id, _ALIGNED).vector.tolist()
        spin, spin_rate = tuple(velocity[3:]), tuple(rate[3:])
        point = motion_at(tuple(velocity[:3]), tuple(rate[:3]), spin, spin_rate, arm)
        return point, PointMotion(spin, spin_rate, spin)


def ends_at(
    model: pin.Model, data: pin.Data, joint_ids: tuple[int, int], point: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(6, nv) of two bodies at a point of the world, in its axes; zero for the world."""
    first, other = (
        # With one degree of freedom Pinocchio gives (6,) for (6, 1).
        getFrameJacobian(
            model, data, joint_id, pin.SE3(np.eye(3), data.oMi[joint_id].actInv(point)), _ALIGNED
        ).reshape(6, -1)
        if joint_id > 0
        else np.zeros((6, model.nv))
        for joint_id in joint_ids
    )
    return first, other


def sizes_of_terms(first: np.ndarray, other: np.ndarray, arm: float) -> np.ndarray:
    """(6, nv) what the rows of two ends (6, nv) are differences of: it tells zero from rounding.

    ``arm``: what turns a point moves it by differences of places of this size [m].
    """
    sizes = np.abs(first) + np.abs(other)
    # Axes mix within a triple, so its rows share their size.
    sizes[:3] = np.sqrt((sizes[:3] ** 2).sum(axis=0))
    sizes[3:] = np.sqrt((sizes[3:] ** 2).sum(axis=0))
    sizes[:3] += arm * sizes[3:]
    return sizes


def _turned(turn: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(6, nv) both triples of rows, turned."""
    return np.matmul(turn, rows.reshape(2, 3, -1)).reshape(6, -1)
