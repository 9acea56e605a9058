"""Bare Pinocchio, and dense numpy and scipy on Pinocchio's M: one would write these by hand.

Nothing is checked, no law is looked after, no books are kept.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from impulsekit.scene import AppliedImpulse, Contact, FrameAnchor, JointImpulse, PointAnchor, Scene
from impulsekit.scene.constraints import DIRECTIONS

from ..problems.problem import Problem
from .method import Answer, Method


def _is_blow(problem: Problem) -> bool:
    scene = problem.scene
    plain = all(isinstance(b, JointImpulse) or b.axes == "world" for b in scene.impulses)
    rest = scene.constraints or scene.contacts or problem.duration
    return plain and not rest and scene.robot.nv > 1


def _is_held(problem: Problem) -> bool:
    """Points and frames that the world holds still."""
    scene = problem.scene
    return (
        bool(scene.constraints)
        and not (scene.contacts or problem.duration)
        and scene.robot.nv > 1
        and all(
            isinstance(c, PointAnchor | FrameAnchor)
            and c.other == "world"
            and getattr(c, "axes", "world") == "world"
            and not (callable(c.velocity) or np.any(c.velocity))
            for c in scene.constraints
        )
    )


def _lands(problem: Problem) -> bool:
    """Points on level ground."""
    scene = problem.scene
    return (
        bool(scene.contacts)
        and not (scene.constraints or scene.impulses or problem.duration)
        and scene.robot.nv > 1
        and all(
            isinstance(c, Contact) and c.against == "world" and c.normal == (0.0, 0.0, 1.0)
            for c in scene.contacts
        )
    )


class Points:
    """A model with frames where a scene strikes, holds and touches."""

    def __init__(self, scene: Scene) -> None:
        self.model = pin.Model(scene.robot.model)
        self.joint_impulse = np.zeros(self.model.nv)
        self.blows: list[tuple[int, np.ndarray]] = []
        self.rows: list[tuple[int, list[int]]] = []
        for entry in scene.impulses:
            if isinstance(entry, AppliedImpulse):
                wrench = np.array([*entry.linear, *entry.angular])
                self.blows.append((self._frame(entry.frame, entry.at), wrench))
            else:
                joint = self.model.joints[self.model.getJointId(entry.joint)]
                self.joint_impulse[joint.idx_v : joint.idx_v + joint.nv] += entry.impulse
        for held in (*scene.constraints, *scene.contacts):
            if isinstance(held, FrameAnchor):
                kept = [DIRECTIONS.index(name) for name in held.directions]
            else:
                kept = [0, 1, 2]
            self.rows.append((self._frame(held.frame, held.at), kept))  # type: ignore[union-attr]
        self.data = self.model.createData()

    def _frame(self, name: str, at: Any) -> int:
        frame = self.model.frames[self.model.getFrameId(name)]
        place = frame.placement * pin.SE3(np.eye(3), np.array(at))
        new = pin.Frame(
            f"point {self.model.nframes}", frame.parentJoint, 0, place, pin.FrameType.OP_FRAME
        )
        return self.model.addFrame(new, False)

    def impulse(self, q: np.ndarray) -> np.ndarray:
        """(nv,) I."""
        total = self.joint_impulse.copy()
        for frame_id, wrench in self.blows:
            total += wrench @ pin.computeFrameJacobian(
                self.model, self.data, q, frame_id, pin.LOCAL_WORLD_ALIGNED
            )
        return total

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """(m, nv) the rows that are held or touched."""
        return np.vstack(
            [
                pin.computeFrameJacobian(
                    self.model, self.data, q, frame_id, pin.LOCAL_WORLD_ALIGNED
                )[kept]
                for frame_id, kept in self.rows
            ]
        )

    def masses(self, q: np.ndarray) -> np.ndarray:
        """(nv, nv) M, both triangles."""
        upper = pin.crba(self.model, self.data, q)
        return np.triu(upper) + np.triu(upper, 1).T

    def cholesky(self, q: np.ndarray) -> None:
        """CRBA and the sparse factor, into the data."""
        pin.crba(self.model, self.data, q)
        pin.cholesky.decompose(self.model, self.data)


def _crba(problem: Problem) -> Answer:
    points, q, v = Points(problem.scene), problem.q, problem.v

    def velocity_after() -> np.ndarray:
        impulse = points.impulse(q)
        points.cholesky(q)
        return v + pin.cholesky.solve(points.model, points.data, impulse)

    return velocity_after


def _aba(problem: Problem) -> Answer:
    """The blows as forces on joints, with gravity away and all at rest."""
    points, q, v = Points(problem.scene), problem.q, problem.v
    model, data = points.model, points.data
    model.gravity.setZero()
    at_rest = np.zeros(model.nv)
    forces = pin.StdVec_Force()
    for _ in range(model.njoints):
        forces.append(pin.Force.Zero())
    (only, *more) = points.blows or [(0, np.zeros(6))]

    def on_joint(frame_id: int, wrench: np.ndarray) -> tuple[int, pin.Force]:
        frame = model.frames[frame_id]
        turned = data.oMi[frame.parentJoint].rotation @ frame.placement.rotation
        local = pin.Force(wrench[:3] @ turned, wrench[3:] @ turned)
        return frame.parentJoint, frame.placement.act(local)

    def velocity_after() -> np.ndarray:
        pin.forwardKinematics(model, data, q)
        joint, force = on_joint(*only)
        forces[joint] = force
        for blow in more:
            joint, force = on_joint(*blow)
            forces[joint] = forces[joint] + force
        return v + pin.aba(model, data, q, at_rest, points.joint_impulse, forces)

    return velocity_after


def _impulse_dynamics(problem: Problem) -> Answer:
    """Its own impact: rows that are held, one e for all of them, contacts that cannot slip."""
    points, q, v = Points(problem.scene), problem.q, problem.v
    model, data = points.model, points.data
    struck = bool(problem.scene.impulses)
    e = float(getattr(problem.scene.contacts[0], "restitution", 0.0)) if _lands(problem) else 0.0

    def velocity_after() -> np.ndarray:
        jacobian, before = points.jacobian(q), v
        if struck:
            impulse = points.impulse(q)
            points.cholesky(q)
            before = v + pin.cholesky.solve(model, data, impulse)
            return pin.impulseDynamics(model, data, before, jacobian, e, 0.0)
        return pin.impulseDynamics(model, data, q, v, jacobian, e, 0.0)

    return velocity_after


def _admm(problem: Problem, tolerance: float) -> Answer:
    """Pinocchio's own solver of Coulomb's law, e in the normal rows."""
    points, q, v = Points(problem.scene), problem.q, problem.v
    model, data = points.model, points.data
    entries = [entry for entry in problem.scene.contacts if isinstance(entry, Contact)]
    restitution = np.array([float(entry.restitution) for entry in entries])  # type: ignore[arg-type]
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for _ in entries:
        point = pin.PointContactConstraintModel(model, 1, pin.SE3.Identity())
        models.append(pin.ConstraintModel(point))
    for i, entry in enumerate(entries):
        models[i].extract().setFriction(entry.friction)
        datas.append(models[i].createData())
    solver = pin.ADMMConstraintSolver(3 * len(entries))
    settings = pin.ADMMSolverSettings()
    settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = tolerance
    settings.max_iterations = 5000

    def velocity_after() -> np.ndarray:
        jacobian = points.jacobian(q)
        points.cholesky(q)
        moved = np.array([pin.cholesky.solve(model, data, row) for row in jacobian])
        delassus = moved @ jacobian.T
        size = delassus.diagonal().max()
        slip = jacobian @ v
        slip[2::3] += restitution * np.minimum(slip[2::3], 0.0)
        result = pin.ADMMSolverResult()
        operator = pin.DelassusOperatorDense(delassus / size)
        solver.solve(operator, slip, models, datas, settings, result)
        return v + (result.retrieveConstraintImpulses() / size) @ moved

    return velocity_after


def _dense(solver: Callable[[np.ndarray, np.ndarray], np.ndarray], problem: Problem) -> Answer:
    """M Δv = I, or with rows held the whole of [M Jᵀ; J 0]."""
    points, q, v = Points(problem.scene), problem.q, problem.v
    held = bool(points.rows)

    def velocity_after() -> np.ndarray:
        impulse, masses = points.impulse(q), points.masses(q)
        if not held:
            return v + solver(masses, impulse)
        jacobian = points.jacobian(q)
        n, m = len(v), len(jacobian)
        whole = np.zeros((n + m, n + m))
        whole[:n, :n], whole[:n, n:], whole[n:, :n] = masses, jacobian.T, jacobian
        return v + solver(whole, np.concatenate([impulse, -(jacobian @ v)]))[:n]

    return velocity_after


def _cholesky(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    import scipy.linalg

    return scipy.linalg.cho_solve(scipy.linalg.cho_factor(matrix, lower=True), right)


METHODS: tuple[Method, ...] = (
    Method("pinocchio, crba + cholesky", _is_blow, _crba, peer=True),
    Method("pinocchio, aba", _is_blow, _aba, peer=True),
    Method(
        "pinocchio, impulseDynamics",
        lambda problem: _is_held(problem) or _lands(problem),
        _impulse_dynamics,
        peer=True,
    ),
    *Method("pinocchio, ADMM", _lands, _admm, peer=True).at((1e-3, 1e-6, 1e-9, 1e-12)),
    Method(
        "numpy, LU",
        lambda problem: _is_blow(problem) or _is_held(problem),
        partial(_dense, np.linalg.solve),
        peer=True,
    ),
    Method("scipy, Cholesky", _is_blow, partial(_dense, _cholesky), peer=True),
)
