"""Tables for joint reactions and link velocities of a batch, out of a scene."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..motion.tree.of_model import KINDS, room_of, tree_of
from ..rows.entries import FramePair, FunctionRows, frame_pair, rows_of_entry
from ..scene import Contact, JointStop, Scene
from ..scene.contacts import turns
from .errors import NoKernelError

__all__ = ["JointLoads"]


class Loads(NamedTuple):
    """Impulses from outside, each one number along a direction.

    joint: on whose body it acts. column: of the number. sign: 1, or -1 for the other end.
    axes_of: in whose axes the direction is (0: the world's). point_on: in whose frame the point
    is. is_moment: a couple, which has no point.
    """

    joint: np.ndarray
    column: np.ndarray
    sign: np.ndarray
    axes_of: np.ndarray
    direction: np.ndarray
    point_on: np.ndarray
    point: np.ndarray
    is_moment: np.ndarray


class Links(NamedTuple):
    """The joint that carries each link, and its mass centre there [m]."""

    joint: np.ndarray
    com: np.ndarray


class JointLoads:
    """Reactions and link velocities of a scene's batches.

    Raises:
        NoKernelError: the robot has a joint, or the scene an entry, that only ``solve`` knows.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._rows: list[tuple[Any, ...]] = []
        self._columns = 0
        model = scene.robot.model
        tree = tree_of(model)
        if tree is None:
            unknown = {j.shortname() for j in list(model.joints)[1:]} - KINDS.keys()
            raise NoKernelError(f"loads of joints of the kind {', '.join(sorted(unknown))}")
        self._tree = tree
        for impulse in scene.impulses:
            self._entry(impulse)
        for contact in scene.contacts:
            self._contact(contact)
        for constraint in scene.held:
            self._entry(constraint)
        columns = list(zip(*self._rows, strict=True)) or [()] * 8
        kinds = (np.int64, np.int64, float, np.int64, float, np.int64, float, np.bool_)
        shapes = ((), (), (), (), (3,), (), (3,), ())
        self._loads = Loads(
            *(
                np.array(column, dtype=kind).reshape(-1, *shape)
                for column, kind, shape in zip(columns, kinds, shapes, strict=True)
            )
        )
        links = scene.robot.links
        self._links = Links(
            np.array([link.joint_id for link in links], dtype=np.int64),
            np.array([link.com_in_joint for link in links], dtype=float).reshape(-1, 3),
        )

    def write(
        self,
        q: np.ndarray,
        dv: np.ndarray,
        given: np.ndarray,
        contacts: np.ndarray,
        constraints: np.ndarray,
        reactions: np.ndarray | None,
        bodies: np.ndarray | None,
    ) -> None:
        """Fill the arrays that were asked for.

        Args:
            q: (B, nq) or (1, nq). dv: (B, nv). given: (B or 1, columns) known impulses.
            contacts: (B, contacts, 3). constraints: (B, rows).
            reactions: (B, joints, 6) or None. bodies: (B, links, 6) or None.
        """
        from .kernels.joint_loads import joint_loads

        size = len(dv)
        numbers = np.concatenate(
            [
                np.broadcast_to(given, (size, given.shape[1])),
                contacts.reshape(size, -1),
                constraints,
            ],
            axis=1,
        )
        joints, links = len(self._tree.joints) - 1, len(self._links.joint)
        told = np.empty((0, joints, 6)) if reactions is None else np.empty((size, joints, 6))
        moved = np.empty((size, 0 if bodies is None else links, 6))
        joint_loads(
            self._tree,
            room_of(self._scene.robot.model),
            self._loads,
            self._links,
            np.ascontiguousarray(np.broadcast_to(q, (size, q.shape[1])), dtype=float),
            np.ascontiguousarray(dv, dtype=float),
            np.ascontiguousarray(numbers, dtype=float),
            told,
            moved,
        )
        if reactions is not None:
            reactions[:] = told
        if bodies is not None:
            bodies[:] = moved

    def _add(
        self, joint: int, column: int, sign: float, axes_of: int, direction: Any, point: Any,
        is_moment: bool,
    ) -> None:  # fmt: skip
        point_on, at = point
        if joint > 0:
            self._rows.append((joint, column, sign, axes_of, direction, point_on, at, is_moment))

    def _pair(self, said: FramePair, axes: tuple[int, np.ndarray]) -> None:
        """One number for each row of two frames, whose axes are constant in those of a joint."""
        axes_of, rotation = axes
        first, other = said.first, said.other
        point = first.joint_id, first.placement.translation
        far = point if said.coincides else (other.joint_id, other.placement.translation)
        for joint, sign, at in ((first.joint_id, 1.0, point), (other.joint_id, -1.0, far)):
            for k, row in enumerate(said.select):
                direction, column = rotation[:, row % 3], self._columns + k
                self._add(joint, column, sign, axes_of, direction, at, row > 2)

    def _contact(self, entry: Any) -> None:
        if turns(entry):
            # Its moments are in no column.
            raise NoKernelError("loads by contacts that resist rolling or spin")
        if isinstance(entry, Contact):
            self._pair(frame_pair(self._scene.robot, entry), (0, np.eye(3)))
        elif not isinstance(entry, JointStop):
            raise _unknown(entry)
        self._columns += 3

    def _entry(self, entry: Any) -> None:
        """A known impulse or a constraint."""
        said = rows_of_entry(self._scene.robot, entry)
        if isinstance(said, FunctionRows) or getattr(said, "carrier", None) == "line":
            raise _unknown(entry)
        if isinstance(said, FramePair):
            self._pair(said, said.carrying)
        self._columns += len(said.labels)


def _unknown(entry: Any) -> NoKernelError:
    return NoKernelError(f"loads by a {type(entry).__name__}, whose point differs in each row")
