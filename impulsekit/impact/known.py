"""Known impulses brought to the model: I = Jᵀp (Chang & Huston 1995, eq. (18))."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from pinocchio import computeFrameJacobian

from ..rows.entries import Site
from ..rows.pair import jacobian_in_world_axes
from ..rows.reach import ReachedModel
from ..scene import AppliedImpulse, Scene

__all__ = ["Blow", "KnownImpulses"]

_REFERENCE = {"world": pin.LOCAL_WORLD_ALIGNED, "local": pin.LOCAL}


@dataclass(frozen=True, eq=False)
class Blow:
    """One applied impulse at a frame made for it.

    Attributes:
        joint_id: the joint that carries the struck frame.
        frame_id: a frame at the struck point, with the struck frame's axes.
        placement: of that frame in the joint's.
        wrench: (6,) linear [N s] before angular [N m s], about the point, in ``axes``.
        axes: "world" or "local".
    """

    joint_id: int
    frame_id: int
    placement: pin.SE3
    wrench: np.ndarray
    axes: str

    @property
    def reference(self) -> pin.ReferenceFrame:
        """The reference frame in which a Jacobian meets ``wrench``."""
        return _REFERENCE[self.axes]


class KnownImpulses:
    """The known impulses of a scene on its reached model.

    Attributes:
        blows: the applied impulses.
        joint_impulse: (nv,) the impulses inside joints, or None where there is none.
        unit: a power of two by which all are multiplied, so that none is denormal or near
            overflow; 1 but for such sizes, and where anything else moves in the scene.
    """

    def __init__(self, scene: Scene, reached: ReachedModel, *, alone: bool = False) -> None:
        self.model = reached.model
        self.unit = _unit_of(scene) if alone else 1.0
        blows = []
        joint_impulse = np.zeros(self.model.nv)
        for i, entry in enumerate(scene.impulses):
            if isinstance(entry, AppliedImpulse):
                blows.append(self._blow(scene, reached, entry, i))
            else:
                joint_id = reached.joint_id(scene.robot.joint_id(entry.joint))
                joint = self.model.joints[joint_id]
                own = self.unit * np.array(entry.impulse)
                joint_impulse[joint.idx_v : joint.idx_v + joint.nv] += own
        self.blows = tuple(blows)
        self.joint_impulse = joint_impulse if joint_impulse.any() else None
        self._uneven = reached.has_uneven_lengths
        # A single blow is by far the commonest; it is told apart once, not at each solve.
        self._single = (
            (blows[0].frame_id, blows[0].reference, blows[0].wrench)
            if len(blows) == 1
            and self.joint_impulse is None
            and self.model.nv > 1
            and not self._uneven
            else None
        )

    def _blow(self, scene: Scene, reached: ReachedModel, entry: AppliedImpulse, i: int) -> Blow:
        site = Site.of(scene.robot, entry.frame, entry.at)
        joint_id, placement = reached.joint_id(site.joint_id), site.placement
        frame_id = self.model.addFrame(
            pin.Frame(f"impulse {i}", joint_id, 0, placement, pin.FrameType.OP_FRAME), False
        )
        wrench = self.unit * np.array([*entry.linear, *entry.angular])
        return Blow(joint_id, frame_id, placement, wrench, entry.axes)

    def generalized_impulse(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(nv,) I = Jᵀp, summed over the impulses."""
        if self._single is not None:
            frame_id, reference, wrench = self._single
            return wrench.dot(computeFrameJacobian(self.model, data, q, frame_id, reference))
        total = np.zeros(self.model.nv)
        if self.joint_impulse is not None:
            total += self.joint_impulse
        for blow in self.blows:
            if self._uneven and blow.axes == "world":
                jacobian = jacobian_in_world_axes(self.model, data, q, blow.frame_id)
            else:
                jacobian = computeFrameJacobian(self.model, data, q, blow.frame_id, blow.reference)
            # With one degree of freedom Pinocchio gives (6,) for (6, 1).
            total += blow.wrench.dot(jacobian.reshape(6, -1))
        return total

    def external_forces(self, data: pin.Data) -> list[tuple[int, pin.Force]]:
        """Each blow as a spatial force in its joint's own frame, with the joint's index.

        The placements in ``data`` have to be those of the configuration wherever a blow
        is given in world axes.
        """
        forces = []
        for blow in self.blows:
            if blow.axes == "local":
                at_point = pin.Force(blow.wrench)
            else:
                # Only the rotation enters, so a base far from the origin costs no digits.
                rotation = data.oMi[blow.joint_id].rotation.dot(blow.placement.rotation)
                at_point = pin.Force(blow.wrench[:3].dot(rotation), blow.wrench[3:].dot(rotation))
            forces.append((blow.joint_id, blow.placement.act(at_point)))
        return forces


# Blows of other sizes are brought near 1: their products would leave the doubles.
_SMALLEST, _LARGEST = 1e-150, 1e150


def _unit_of(scene: Scene) -> float:
    """The power of two that brings the largest number of the impulses near 1, if they need it."""
    numbers = [0.0]
    for entry in scene.impulses:
        if isinstance(entry, AppliedImpulse):
            numbers += [*entry.linear, *entry.angular]
        else:
            numbers += np.ravel(entry.impulse).tolist()
    largest = max(map(abs, numbers))
    if not largest or _SMALLEST < largest < _LARGEST:
        return 1.0
    return math.ldexp(1.0, min(-math.frexp(largest)[1], 1000))
