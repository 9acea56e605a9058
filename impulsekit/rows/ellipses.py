"""Friction by direction: where its axes lie, and the tangents in which the ellipse is a circle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..robot import Robot
from ..scene import Collision, Contact
from ..scene.coefficients import EllipticFriction, units_of_ellipse
from .reach import ReachedModel

__all__ = ["Ellipse", "axis_in_plane", "ellipse_of", "ways_of_ellipse"]

# An axis of friction whose part in the plane is shorter has none.
ALONG_NORMAL = 1e-6


def axis_in_plane(
    friction: EllipticFriction, axes: np.ndarray, turn: np.ndarray, entry: int
) -> np.ndarray:
    """(2,) unit: the first axis of an ellipse in the tangents of a contact.

    Args:
        friction: the ellipse.
        axes: (3, 3) t₁, t₂, n of the contact, by column.
        turn: (3, 3) the axes of the frame that is touched, in the same coordinates.
        entry: which contact of the scene it is.

    Raises:
        InputError: it is along the normal.
    """
    axis = axes[:, :2].T.dot(turn.dot(friction.along))
    length = float(np.hypot(axis[0], axis[1]))
    if not length > ALONG_NORMAL:
        raise InputError(
            f"contacts[{entry}]: the axis `along` of its EllipticFriction is along the "
            "normal here; give one in the plane of the contact"
        )
    return axis / length


def ways_of_ellipse(
    friction: EllipticFriction, axes: np.ndarray, turn: np.ndarray, entry: int
) -> np.ndarray:
    """(3, 3) what makes of impulses or forces (y, P_n) those along ``axes``: A and 1.

    ``units_of_ellipse`` has A; arguments and errors as for ``axis_in_plane``.
    """
    found = np.eye(3)
    found[:2, :2] = units_of_ellipse(friction, axis_in_plane(friction, axes, turn, entry))
    return found


@dataclass(frozen=True, eq=False)
class Ellipse:
    """Friction by direction of one contact.

    Attributes:
        friction: the ellipse.
        entry: which contact of the scene it is.
        joint_id: the joint whose frame carries its axes; 0 for the world.
        turn: (3, 3) the axes of the frame that is touched in the joint's.
    """

    friction: EllipticFriction
    entry: int
    joint_id: int
    turn: np.ndarray

    def ways(self, axes: np.ndarray, data: pin.Data) -> np.ndarray:
        """``ways_of_ellipse`` for ``axes`` in the world; ``data`` with placements of joints."""
        return ways_of_ellipse(self.friction, axes, self.turn_in_world(data), self.entry)

    def turn_in_world(self, data: pin.Data) -> np.ndarray:
        """(3, 3) the axes of the frame that is touched in the world's."""
        return data.oMi[self.joint_id].rotation.dot(self.turn)

    def axes(self, axes: np.ndarray, data: pin.Data) -> np.ndarray:
        """(3, 3) axes with tangents [t₁ t₂] A, for which µ is 1; as for ``ways``."""
        return axes.dot(self.ways(axes, data))


def ellipse_of(
    robot: Robot, reached: ReachedModel, entry: Contact | Collision, index: int
) -> Ellipse | None:
    """The ellipse of a contact of the scene; None of other friction."""
    if not isinstance(entry.friction, EllipticFriction):
        return None
    return Ellipse(entry.friction, index, *_touched_frame(robot, reached, entry))


def _touched_frame(
    robot: Robot, reached: ReachedModel, entry: Contact | Collision
) -> tuple[int, np.ndarray]:
    """The joint of the frame that is touched, and the frame's rotation in it."""
    if isinstance(entry, Collision):
        from ..robot.geometry import geometry_ids

        shape = robot.collision_model.geometryObjects[geometry_ids(robot, entry.other)[0][0]]
        frame_id = shape.parentFrame
    else:
        frame_id = robot.frame_id(entry.against)
    frame = robot.model.frames[frame_id]
    return reached.joint_id(frame.parentJoint), frame.placement.rotation
