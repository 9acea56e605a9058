"""Points of frames, and their Jacobians with all their digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from pinocchio import computeFrameJacobian, getFrameJacobian

if TYPE_CHECKING:
    from .entries import Site
    from .reach import ReachedModel

__all__ = ["PointOnFrame", "jacobian_in_world_axes"]


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
