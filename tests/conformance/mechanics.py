"""M, the rows of contacts and constraints and the known impulses of a scene, from Pinocchio.

Nothing of the library's own algebra is used: its scene is read, Pinocchio gives M and J.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

import impulsekit as ik

WORLD_AXES = pin.LOCAL_WORLD_ALIGNED


@dataclass(frozen=True, eq=False)
class Mechanics:
    """M Δv = f + Jᵀ P + Aᵀ λ at one state, with A v⁺ = ``aim``.

    Attributes:
        M: (nv, nv). v: (nv,) before. f: (nv,) of the known impulses.
        J: (3n, nv) of n contact points: two tangents, then the normal.
        axes: (n, 3, 3) their directions as columns, in world axes.
        A: (m, nv) of the constraints. aim: (m,).
    """

    M: np.ndarray
    v: np.ndarray
    f: np.ndarray
    J: np.ndarray
    axes: np.ndarray
    A: np.ndarray
    aim: np.ndarray

    @cached_property
    def held_inverse(self) -> np.ndarray:
        """(nv, nv) what turns impulses into Δv while the constraints hold."""
        inverse = np.linalg.inv(self.M)
        inverse = 0.5 * (inverse + inverse.T)
        if not len(self.A):
            return inverse
        half = inverse @ self.A.T
        return inverse - half @ np.linalg.pinv(self.A @ half, rcond=1e-12) @ half.T

    @cached_property
    def W(self) -> np.ndarray:
        """(3n, 3n) Delassus' matrix."""
        return self.J @ self.held_inverse @ self.J.T

    @cached_property
    def v_free(self) -> np.ndarray:
        """(nv,) the velocities without contacts: blows and constraints alone."""
        after = self.v + np.linalg.solve(self.M, self.f)
        if not len(self.A):
            return after
        half = np.linalg.solve(self.M, self.A.T)
        gram = self.A @ half
        return after - half @ np.linalg.pinv(gram, rcond=1e-12) @ (self.A @ after - self.aim)

    def after(self, P: np.ndarray) -> np.ndarray:
        """(nv,) v⁺ of contact impulses (3n,) in the contacts' own axes."""
        return self.v_free + self.held_inverse @ self.J.T @ P

    def in_own_axes(self, impulses: np.ndarray) -> np.ndarray:
        """(3n,) impulses (n, 3) of world axes in the contacts' own."""
        return np.einsum("nij,ni->nj", self.axes, np.asarray(impulses)).ravel()

    def left_of_momentum(self, v_after: np.ndarray, P: np.ndarray, held: np.ndarray) -> float:
        """|M Δv − f − Jᵀ P − Aᵀ λ|, relative to its terms."""
        momentum, of_contacts = self.M @ (v_after - self.v), self.J.T @ P
        of_held = self.A.T @ held
        off = np.abs(momentum - self.f - of_contacts - of_held).max()
        terms = np.abs(self.M) @ np.abs(v_after - self.v) + np.abs(self.J.T) @ np.abs(P)
        terms = terms + np.abs(self.A.T) @ np.abs(held) + np.abs(self.f)
        return float(off / terms.max())


def mechanics_of(scene: ik.Scene, q: np.ndarray, v: np.ndarray) -> Mechanics:
    """M, rows and known impulses of a scene of ``Contact``, ``PointAnchor``, ``JointLock`` and
    ``AppliedImpulse``, each given in world axes."""
    model = scene.robot.model
    data = model.createData()
    M = np.array(pin.crba(model, data, q))
    M = np.triu(M) + np.triu(M, 1).T
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)

    def at_point(frame: str, place: np.ndarray) -> np.ndarray:
        """(6, nv) the velocity of the point of a frame at a place of the world."""
        if frame == "world":
            return np.zeros((6, model.nv))
        i = scene.robot.frame_id(frame)
        rows = np.array(pin.getFrameJacobian(model, data, i, WORLD_AXES))
        x, y, z = place - data.oMf[i].translation
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        rows[:3] -= cross @ rows[3:]
        return rows

    def place_of(frame: str, point: np.ndarray) -> np.ndarray:
        point = np.asarray(point, dtype=float)
        return point if frame == "world" else data.oMf[scene.robot.frame_id(frame)].act(point)

    f = np.zeros(model.nv)
    for blow in scene.impulses:
        place = place_of(blow.frame, blow.at)
        f += at_point(blow.frame, place).T @ np.array([*blow.linear, *blow.angular])
    rows, axes = [], []
    for contact in scene.contacts:
        place = place_of(contact.frame, contact.at)
        turn = np.eye(3)
        if contact.against != "world":
            turn = data.oMf[scene.robot.frame_id(contact.against)].rotation
        own = _axes(turn @ np.array(contact.normal))
        relative = at_point(contact.frame, place)[:3] - at_point(contact.against, place)[:3]
        rows.append(own.T @ relative)
        axes.append(own)
    held = []
    for entry in scene.constraints:
        if isinstance(entry, ik.JointLock):
            held.append(np.eye(model.nv)[[model.joints[model.getJointId(entry.joint)].idx_v]])
            continue
        place = place_of(entry.frame, entry.at)
        held.append(at_point(entry.frame, place)[:3] - at_point(entry.other, place)[:3])
    A = np.vstack(held) if held else np.zeros((0, model.nv))
    J = np.vstack(rows) if rows else np.zeros((0, model.nv))
    return Mechanics(M, np.array(v, dtype=float), f, J, np.array(axes), A, np.zeros(len(A)))


def _axes(normal: np.ndarray) -> np.ndarray:
    """(3, 3) two tangents and the normal as columns; any tangents do."""
    least = np.eye(3)[np.abs(normal).argmin()]
    first = np.cross(least, normal)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first), normal])
