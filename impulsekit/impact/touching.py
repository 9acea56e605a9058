"""Which contacts touch at a configuration, and the rows of their relative velocity.

Each touching point has three rows, two tangents and the normal: u = Rᵀ (v_frame −
v_against), with R = [t₁ t₂ n] in the world.
"""

from __future__ import annotations

from collections.abc import Container
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import getFrameJacobian

from ..geometry.axes import contact_axes
from ..robot import Robot
from ..scene import Collision, Contact, JointStop, Scene
from .points import PointOnFrame
from .reach import ReachedModel

__all__ = ["ContactRows", "PointOnWorldPlane", "Touch"]

# A joint this near its limit, relative to the limit's size, is at its stop.
AT_STOP = 1e-9


class Touch(NamedTuple):
    """One touching point.

    Attributes:
        entry: the index of the contact in the scene.
        axes: (3, 3) columns t₁, t₂, n in the world; None for a joint stop.
        joint_ids, frame_ids: of the two bodies in the whole model, first the one that
            receives the impulse; (0, 0) for a joint stop.
        jacobian: (3, nv) of the model the rows were made for.
        position: (3,) world [m], where it came with the touching; None where it is the
            contact's own point, or for a joint stop.
        gap: [m], likewise.
    """

    entry: int
    axes: np.ndarray | None
    joint_ids: tuple[int, int]
    frame_ids: tuple[int, int]
    jacobian: np.ndarray
    position: np.ndarray | None = None
    gap: float | None = None


class ContactRows:
    """The contacts of a scene on a reached model."""

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        self.model = reached.model
        self._entries = [
            _compiled(scene.robot, reached, entry, i) for i, entry in enumerate(scene.contacts)
        ]
        self._needs_places = any(entry.needs_places for entry in self._entries)

    def touching(
        self, data: pin.Data, q: np.ndarray, only: Container[int] | None = None
    ) -> list[Touch]:
        """The touching points at q, with their rows.

        ``only``: the indices of the contacts that take part. A joint stop among them
        counts as touched at its nearer limit. None for all, by the rules of the scene.
        """
        if self._needs_places:
            pin.computeJointJacobians(self.model, data, q)
        touches: list[Touch] = []
        for i, entry in enumerate(self._entries):
            if only is None:
                entry.touch(touches, self.model, data, q)
            elif i in only:
                if isinstance(entry, _AtStop):
                    entry.touch_nearer(touches, q)
                else:
                    entry.touch(touches, self.model, data, q)
        return touches


class PointOnWorldPlane:
    """A point against a plane in the world: the commonest contact, and the quickest."""

    needs_places = False

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Contact, index: int) -> None:
        self._point = PointOnFrame(robot, reached, entry.frame, entry.at)
        frame_ids = (robot.frame_id(entry.frame), robot.frame_id(entry.against))
        frames = robot.model.frames
        axes = contact_axes(frames[frame_ids[1]].placement.rotation @ np.array(entry.normal))
        # On level ground the world's axes are the contact's own.
        self._turn = None if np.array_equal(axes, np.eye(3)) else axes.T.copy()
        joint_ids = (frames[frame_ids[0]].parentJoint, frames[frame_ids[1]].parentJoint)
        self._known = (index, axes, joint_ids, frame_ids)

    def jacobian(self, model: pin.Model, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(3, nv) the rows t₁, t₂, n."""
        jacobian = self._point.jacobian(model, data, q, pin.LOCAL_WORLD_ALIGNED)[:3]
        return jacobian if self._turn is None else self._turn.dot(jacobian)

    def touch_of(self, jacobian: np.ndarray) -> Touch:
        """The touching point with its rows."""
        return Touch(*self._known, jacobian)

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        touches.append(self.touch_of(self.jacobian(model, data, q)))


class _Pair:
    """Two bodies that meet at a point of the world, as rows."""

    needs_places = True

    def __init__(
        self, robot: Robot, reached: ReachedModel, index: int, frame_ids: tuple[int, int]
    ) -> None:
        frames = robot.model.frames
        self._index = index
        self._frame_ids = frame_ids
        self._joint_ids = (frames[frame_ids[0]].parentJoint, frames[frame_ids[1]].parentJoint)
        self._reached_ids = tuple(reached.joint_id(joint_id) for joint_id in self._joint_ids)
        # The axes of the rows are the world's: of the placement only the place counts.
        self._placement = pin.SE3.Identity()

    def rows(
        self, model: pin.Model, data: pin.Data, position: np.ndarray, axes: np.ndarray
    ) -> np.ndarray:
        """(3, nv) Rᵀ (J_first − J_other) at a point of the world."""
        first, other = self._reached_ids
        if not other > 0:
            moves = self._linear(model, data, first, position)
        elif not first > 0:
            moves = -self._linear(model, data, other, position)
        else:
            moves = self._linear(model, data, first, position) - self._linear(
                model, data, other, position
            )
        return axes.T.dot(moves)

    def _linear(
        self, model: pin.Model, data: pin.Data, joint_id: int, position: np.ndarray
    ) -> np.ndarray:
        """(3, nv) the rows of a point of the world that goes with a joint."""
        self._placement.translation = data.oMi[joint_id].actInv(position)
        jacobian = getFrameJacobian(model, data, joint_id, self._placement, pin.LOCAL_WORLD_ALIGNED)
        # With one degree of freedom Pinocchio gives (6,) for (6, 1).
        return jacobian[:3] if jacobian.ndim == 2 else jacobian.reshape(6, 1)[:3]


class _OnMovingPlane(_Pair):
    """A point against a plane, either of which may move."""

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Contact, index: int) -> None:
        ids = (robot.frame_id(entry.frame), robot.frame_id(entry.against))
        super().__init__(robot, reached, index, ids)
        frames = robot.model.frames
        self._at = frames[ids[0]].placement.act(np.array(entry.at))
        self._normal = frames[ids[1]].placement.rotation @ np.array(entry.normal)

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        first, other = self._reached_ids
        position = data.oMi[first].act(self._at)
        axes = contact_axes(data.oMi[other].rotation @ self._normal)
        rows = self.rows(model, data, position, axes)
        touches.append(Touch(self._index, axes, self._joint_ids, self._frame_ids, rows))


class _AtStop:
    """A joint at one of its limits."""

    needs_places = False

    def __init__(self, robot: Robot, reached: ReachedModel, entry: JointStop, index: int) -> None:
        joint = reached.model.joints[reached.joint_id(robot.joint_id(entry.joint))]
        self._index = index
        self._entry_in_q = joint.idx_q
        lower, upper = entry.limits(robot)
        self._sides = []
        for limit, sign in ((lower, 1.0), (upper, -1.0)):
            jacobian = np.zeros((3, reached.model.nv))
            jacobian[2, joint.idx_v] = sign
            self._sides.append((limit, sign, jacobian))

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        for limit, sign, jacobian in self._sides:
            gap = sign * (q[self._entry_in_q] - limit)
            if gap <= AT_STOP * max(1.0, abs(limit)):
                touches.append(Touch(self._index, None, (0, 0), (0, 0), jacobian, gap=gap))

    def touch_nearer(self, touches: list[Touch], q: np.ndarray) -> None:
        """Touch the limit that is nearer, however far it is."""
        at = q[self._entry_in_q]
        limit, sign, jacobian = min(self._sides, key=lambda side: side[1] * (at - side[0]))
        gap = sign * (at - limit)
        touches.append(Touch(self._index, None, (0, 0), (0, 0), jacobian, gap=gap))


class _Colliding(_Pair):
    """Two bodies whose geometry meets somewhere."""

    def __init__(self, robot: Robot, reached: ReachedModel, entry: Collision, index: int) -> None:
        from ..geometry.collision import solid_of
        from ..robot.geometry import geometry_ids

        objects = robot.collision_model.geometryObjects
        pieces = [geometry_ids(robot, name)[0] for name in (entry.first, entry.other)]
        frame_ids = (objects[pieces[0][0]].parentFrame, objects[pieces[1][0]].parentFrame)
        super().__init__(robot, reached, index, frame_ids)
        self._margin = entry.margin
        self._pieces = [
            [(solid_of(objects[i].geometry), objects[i].placement) for i in ids] for ids in pieces
        ]

    def touch(self, touches: list[Touch], model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        from ..geometry.collision import meeting_points

        first, other = (
            [(solid, data.oMi[joint_id] * placement) for solid, placement in pieces]
            for pieces, joint_id in zip(self._pieces, self._reached_ids, strict=True)
        )
        for point in meeting_points(first, other, self._margin):
            axes = contact_axes(point.normal)
            rows = self.rows(model, data, point.position, axes)
            touches.append(
                Touch(
                    self._index,
                    axes,
                    self._joint_ids,
                    self._frame_ids,
                    rows,
                    point.position,
                    point.gap,
                )
            )


def _compiled(
    robot: Robot, reached: ReachedModel, entry: object, index: int
) -> PointOnWorldPlane | _OnMovingPlane | _AtStop | _Colliding:
    if isinstance(entry, JointStop):
        return _AtStop(robot, reached, entry, index)
    if isinstance(entry, Collision):
        return _Colliding(robot, reached, entry, index)
    if not isinstance(entry, Contact):
        raise TypeError(type(entry).__name__)
    if robot.model.frames[robot.frame_id(entry.against)].parentJoint == 0:
        return PointOnWorldPlane(robot, reached, entry, index)
    return _OnMovingPlane(robot, reached, entry, index)
