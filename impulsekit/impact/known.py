"""Δv of known impulses on a tree, by Pinocchio alone (Chang & Huston 1995).

With generalized speeds y and the generalized masses a_lp = M, the impulses F of forces and M of
couples on points with partial velocities v^l and ω^l give

    I_l = Σ_k v_k^l·∫F_k dt + ω_k^l·∫M_k dt          (18)
    a_lp Δy_p = I_l                                  (32)

In Pinocchio's words: I = Jᵀp with the Jacobian of the struck point, and M Δv = I. M is never
inverted: either CRBA and its Cholesky factor, or the articulated-body algorithm, which takes the
blows as external wrenches. Trees that hang on the world side by side do not feel each other, and
neither M nor I depends on where a root stands: what no blow reaches is left out, and roots are
brought to the origin, where Pinocchio's places in the world cost no digits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..rows.entries import Site
from ..scene import AppliedImpulse
from .plan import reached_joints

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["KnownImpulses"]

# Bound once: on a small robot the look-up of a name counts.
crba, decompose, cholesky_solve = pin.crba, pin.cholesky.decompose, pin.cholesky.solve
frame_jacobian = pin.computeFrameJacobian

_REFERENCE = {"world": pin.LOCAL_WORLD_ALIGNED, "local": pin.LOCAL}
_TRANSLATIONS = {"JointModelFreeFlyer": 3, "JointModelTranslation": 3, "JointModelPlanar": 2}
# Impulses of other sizes are brought near 1: their products would leave the doubles.
_SMALLEST, _LARGEST = 1e-150, 1e150


class KnownImpulses:
    """The known impulses of a scene, and Δv of them at one configuration after the other.

    Args:
        scene: of impulses alone.
        joints: those that they reach. algorithm: "aba" or "crba".
    """

    def __init__(self, scene: Scene, joints: Iterable[int], algorithm: str) -> None:
        robot = scene.robot
        self._model, self._q_index, self._v_index, ids = _branches(robot.model, joints)
        self._nv, self._entries = robot.nv, tuple(scene.impulses)
        self._roots = _root_translations(self._model)
        # Of each blow a frame at its point with the struck frame's axes; of each kick its speeds.
        self._frames: list[tuple[int, Any]] = []
        self._kicked: list[slice] = []
        for entry in self._entries:
            if isinstance(entry, AppliedImpulse):
                site = Site.of(robot, entry.frame, entry.at)
                frame = pin.Frame(
                    f"impulse {len(self._frames)}", ids.index(site.joint_id), 0, site.placement,
                    pin.FrameType.OP_FRAME,
                )  # fmt: skip
                frame_id = self._model.addFrame(frame, False)
                self._frames.append((frame_id, _REFERENCE[entry.axes]))
            else:
                joint = self._model.joints[ids.index(robot.joint_id(entry.joint))]
                self._kicked.append(slice(joint.idx_v, joint.idx_v + joint.nv))
        self._own = np.array([x for entry in self._entries for x in entry.values])
        self._take(self._own)
        self._data = self._model.createData()
        self._at_rest = np.zeros(self._model.nv)
        self._jump = self._by_aba if algorithm == "aba" else self._by_crba

    def _take(self, numbers: np.ndarray) -> None:
        """Take the numbers of the impulses: of each blow (6,) p, the sum of the kicks."""
        self._numbers, self._unit = numbers, _unit_of(numbers)
        scaled, frames, kicked = self._unit * numbers, iter(self._frames), iter(self._kicked)
        self._blows: list[tuple[int, Any, np.ndarray]] = []
        self._torque = np.zeros(self._model.nv)
        for entry in self._entries:
            part, scaled = np.split(scaled, [len(entry.values)])
            if isinstance(entry, AppliedImpulse):
                self._blows.append((*next(frames), part))
            else:
                self._torque[next(kicked)] += part
        self._is_whole = self._model.nv == self._nv and self._roots is None and self._unit == 1.0

    def velocity_jump(self, q: np.ndarray, numbers: np.ndarray | None = None) -> np.ndarray:
        """(nv,) Δv of the robot at q (nq,); ``numbers`` (columns,) of the impulses, if others."""
        if (self._own if numbers is None else numbers) is not self._numbers:
            self._take(self._own if numbers is None else numbers)
        if self._is_whole:
            return self._jump(q)
        own = q[self._q_index]
        if self._roots is not None:
            own = own.copy()
            own[self._roots] = 0.0
        dv = np.zeros(self._nv)
        dv[self._v_index] = self._jump(own) / self._unit
        return dv

    def _by_crba(self, q: np.ndarray) -> np.ndarray:
        """M Δv = I by composite rigid bodies and the sparse factor M = U D Uᵀ."""
        model, data = self._model, self._data
        impulse = self._torque
        for frame_id, reference, wrench in self._blows:
            impulse = impulse + wrench.dot(frame_jacobian(model, data, q, frame_id, reference))
        crba(model, data, q)
        decompose(model, data)
        return cholesky_solve(model, data, impulse)

    def _by_aba(self, q: np.ndarray) -> np.ndarray:
        """Δv as accelerations of a robot at rest under p as external wrenches, in O(n)."""
        model, data = self._model, self._data
        pin.forwardKinematics(model, data, q)
        forces = pin.StdVec_Force([pin.Force.Zero() for _ in range(model.njoints)])
        for frame_id, reference, wrench in self._blows:
            frame = model.frames[frame_id]
            if reference == pin.LOCAL_WORLD_ALIGNED:
                turn = data.oMi[frame.parentJoint].rotation.dot(frame.placement.rotation)
                wrench = np.concatenate([wrench[:3].dot(turn), wrench[3:].dot(turn)])
            own = frame.placement.act(pin.Force(wrench))
            forces[frame.parentJoint] = forces[frame.parentJoint] + own
        return pin.aba(model, data, q, self._at_rest, self._torque, forces)


def _branches(model: pin.Model, joints: Iterable[int]) -> tuple[pin.Model, Any, Any, list[int]]:
    """Return whole branches without gravity, their roots at the origin, and their placements.

    Returns:
        The model of the branches in which ``joints`` lie, the indices of its q and v in those of
        the whole, and by its joints those of the whole. Not Pinocchio's ``buildReducedModel``:
        it ends the process where a joint has no frame.
    """
    kept = reached_joints(model, joints)
    part = pin.Model()
    part.gravity.setZero()
    ids = [0, *kept]
    q_index: list[int] = []
    v_index: list[int] = []
    for j in kept:
        joint, place = model.joints[j], model.jointPlacements[j]
        if model.parents[j] == 0:
            place = pin.SE3(place.rotation, np.zeros(3))
        own = part.addJoint(ids.index(model.parents[j]), joint, place, model.names[j])
        part.appendBodyToJoint(own, model.inertias[j], pin.SE3.Identity())
        q_index += range(joint.idx_q, joint.idx_q + joint.nq)
        v_index += range(joint.idx_v, joint.idx_v + joint.nv)
    part.armature = model.armature[v_index]
    return part, _index(q_index), _index(v_index), ids


def _root_translations(model: pin.Model) -> Any:
    """Return the entries of q that are positions of roots in the world; None if there are none."""
    entries: list[int] = []
    for joint_id in range(1, model.njoints):
        if model.parents[joint_id] == 0:
            joint = model.joints[joint_id]
            count = _TRANSLATIONS.get(joint.shortname(), 0)
            entries += range(joint.idx_q, joint.idx_q + count)
    return _index(entries) if entries else None


def _index(entries: list[int]) -> Any:
    """The entries as a slice, which costs a view, or else as an array, which costs a copy."""
    first, last = entries[0], entries[-1] + 1
    return slice(first, last) if len(entries) == last - first else np.array(entries)


def _unit_of(numbers: np.ndarray) -> float:
    """The power of two that brings the largest number of the impulses near 1, if they need it."""
    largest = float(np.abs(numbers).max(initial=0.0))
    if not largest or _SMALLEST < largest < _LARGEST:
        return 1.0
    return math.ldexp(1.0, min(-math.frexp(largest)[1], 1000))
