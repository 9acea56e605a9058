"""Mass matrix, placements and Jacobians of the whole robot at one configuration."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin

from .._core import ConstrainedMass
from ..robot.masses import crba_of, symmetric
from ..robot.model_checks import check_capacity
from ..rows.entries import Site
from ..scene import AppliedImpulse
from ..scene.scene import ThreadCache
from .flat.scene import flat_of
from .singular import singular_joints, singular_mass

if TYPE_CHECKING:
    from .._core import StateRows
    from ..scene import Scene
    from .flat.scene import FlatScene

__all__ = ["Mechanics"]


class Responses(NamedTuple):
    """Responses to unit impulses on points under bilateral constraints.

    Attributes:
        velocity_changes: (nv, 3n) Δv.
        multipliers: (m, 3n) λ.
        delassus: (3n, 3n) W [1/kg].
    """

    velocity_changes: np.ndarray
    multipliers: np.ndarray
    delassus: np.ndarray

    @classmethod
    def of(cls, held: ConstrainedMass, points: np.ndarray) -> Responses:
        """The responses to impulses on points' rows (3n, nv)."""
        count, nv = points.shape
        found = held.respond(np.ascontiguousarray(points))
        size = len(found.multipliers) // max(count, 1)
        return cls(
            found.velocity_changes.reshape(count, nv).T,
            found.multipliers.reshape(count, size).T,
            found.W.reshape(count, count),
        )


class _Workspace:
    """Memory that the impacts of a scene share within a thread.

    Attributes:
        model: of the whole robot.
    """

    def __init__(self, scene: Scene) -> None:
        self.model = scene.robot.model

    @cached_property
    def data(self) -> pin.Data:
        check_capacity(self.model)
        return self.model.createData()

    @cached_property
    def model_without_gravity(self) -> pin.Model:
        model = pin.Model(self.model)
        model.gravity.setZero()
        return model


_workspaces = ThreadCache(_Workspace)


class Mechanics:
    """The robot of a scene at q, for what is asked of an impact after it was solved.

    Its workspace is not the solver's, so it stays true whatever is solved next. Making one
    takes far longer than a solve, and Pinocchio's data grows with the cube of the joints, so
    all impacts of a scene share one in each thread, and each use overwrites it.
    """

    def __init__(self, scene: Scene, q: np.ndarray, v: np.ndarray | None = None) -> None:
        self.scene = scene
        self._v = np.zeros(scene.robot.nv) if v is None else v
        self.model = scene.robot.model
        self.q = q

    def scratch(self) -> pin.Data:
        """Pinocchio's data, to be overwritten by whoever asks."""
        return _workspaces.of(self.scene).data

    @property
    def flat(self) -> FlatScene:
        """The scene in the core."""
        return flat_of(self.scene)

    @cached_property
    def _rows(self) -> StateRows:
        return self.flat.rows(self.q, self._v)

    @cached_property
    def constraint_matrix(self) -> np.ndarray:
        """(m, nv) A at q."""
        return self._rows.A.reshape(-1, self.model.nv)

    @cached_property
    def _placements(self) -> list[pin.SE3]:
        data = self.scratch()
        pin.forwardKinematics(self.model, data, self.q)
        # The list shares the data's memory; copies outlive its next use.
        return [pin.SE3(placement) for placement in data.oMi]

    def joint_placement(self, joint_id: int) -> pin.SE3:
        """The placement of a joint's frame in the world."""
        return self._placements[joint_id]

    @cached_property
    def joint_rotations(self) -> list[np.ndarray]:
        """(3, 3) the axes of every joint's frame in the world, by joint index."""
        return [placement.rotation for placement in self._placements]

    @property
    def model_without_gravity(self) -> pin.Model:
        """A copy of the robot's model in which nothing falls; not to be changed."""
        return _workspaces.of(self.scene).model_without_gravity

    @cached_property
    def mass_matrix(self) -> np.ndarray:
        """(nv, nv) the generalized masses a_lp (Chang & Huston 1995, eq. (30)), symmetric."""
        data = self.scratch()
        return symmetric(
            crba_of(self.model)(self.model, data, self.q).reshape(self.model.nv, self.model.nv)
        )

    @cached_property
    def constrained_mass(self) -> ConstrainedMass:
        """M under the bilateral rows, filled up by them where it is singular without.

        Raises:
            SingularMassError: they do not make up for what M lacks.
        """
        rows = self._rows.A
        found = ConstrainedMass(
            np.ascontiguousarray(self.mass_matrix), self.flat.model.core.parents,
            np.ascontiguousarray(rows), list(self.flat.vectors), self._rows.wider,
        )  # fmt: skip
        if found.weak >= 0:
            rows = rows.reshape(-1, self.model.nv)
            raise singular_mass(self.model, singular_joints(self.model, self.mass_matrix, rows))
        return found

    def responses(self, points: np.ndarray) -> Responses:
        """Return responses to unit impulses on points' rows (3n, nv) under the bilateral rows."""
        return Responses.of(self.constrained_mass, points)

    def carried_energy(self, v: np.ndarray) -> np.ndarray:
        """(nv,) twice the kinetic energy of what hangs on each degree of freedom's joint [J].

        By the Cauchy-Schwarz inequality row i of M v is at most √(M_ii 2T_i) of it.
        """
        model, data = self.model, self.scratch()
        # Pinocchio takes no arrays that are read-only.
        pin.forwardKinematics(model, data, self.q, v.copy())
        twice = np.zeros(model.njoints)
        for i in range(model.njoints - 1, 0, -1):
            own = slice(model.idx_vs[i], model.idx_vs[i] + model.nvs[i])
            twice[i] += model.inertias[i].vtiv(data.v[i]) + model.armature[own] @ v[own] ** 2
            twice[model.parents[i]] += twice[i]
        if len(model.mimicking_joints):
            twice[:] = twice[0]
        of_joint = np.repeat(np.arange(model.njoints), model.nvs)
        return twice[of_joint]

    def frame_placement(self, frame: str) -> pin.SE3:
        """The placement of a frame in the world."""
        site = Site.of(self.scene.robot, frame)
        return self._placements[site.joint_id] * site.placement

    def point_jacobian(self, frame: str, at: np.ndarray, axes: str = "world") -> np.ndarray:
        """(6, nv) Jacobian of a point of a frame, linear before angular, in ``axes``."""
        site = Site.of(self.scene.robot, frame, at)
        # From the joint upwards: a robot far away keeps its digits.
        own = pin.computeJointJacobian(self.model, self.scratch(), self.q, site.joint_id)
        jacobian = site.placement.inverse().action @ own.reshape(6, self.model.nv)
        if axes == "local":
            return jacobian
        turn = self._placements[site.joint_id].rotation @ site.placement.rotation
        return np.matmul(turn, jacobian.reshape(2, 3, -1)).reshape(6, -1)

    def impulse_jacobian(self, entry: AppliedImpulse) -> np.ndarray:
        """(6, nv) Jacobian of the struck point in the axes of the impulse."""
        return self.point_jacobian(entry.frame, np.array(entry.at), entry.axes)

    def known_impulses(self) -> dict[str, np.ndarray]:
        """By entry name, (nv,) Jᵀp of a known impulse (Chang & Huston 1995, eq. (18))."""
        shares = {}
        names = self.scene.entry_names("impulses")
        for name, entry in zip(names, self.scene.impulses, strict=True):
            if isinstance(entry, AppliedImpulse):
                share = np.array(entry.values) @ self.impulse_jacobian(entry)
            else:
                share = np.zeros(self.model.nv)
                share[self.joint_rows(entry.joint)] = entry.impulse
            shares[name] = share
        return shares

    def joint_rows(self, joint: str) -> slice:
        """Return the entries of v that belong to a joint."""
        item = self.model.joints[self.scene.robot.joint_id(joint)]
        return slice(item.idx_v, item.idx_v + item.nv)

    def impulse_scale(self) -> np.ndarray:
        """(nv,) the sum of the absolute terms that make up each row of I."""
        total = np.zeros(self.model.nv)
        for entry in self.scene.impulses:
            if isinstance(entry, AppliedImpulse):
                wrench = np.abs(entry.values)
                total += wrench @ np.abs(self.impulse_jacobian(entry))
            else:
                total[self.joint_rows(entry.joint)] += np.abs(entry.impulse)
        return total
