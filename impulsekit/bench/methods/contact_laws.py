"""The solvers of contact laws, each alone on the Delassus matrix of the problem.

``solve`` combines Newton on the modes with sweeps in closed form and with splitting
(``laws.frictional``). Here sweeps alone, and Pinocchio's ADMM, have to go the whole way.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio as pin

from ...impact.factor import SparseFactor
from ...impact.known import KnownImpulses
from ...laws.approach import sweep
from ...laws.at_once import hit_contacts
from ...laws.compiled import entry
from ...laws.words import NEWTON
from ...laws.workspace import workspace
from ...rows.constraints import needs_places
from ...rows.contacts import ContactRows
from ...rows.reach import reached_model, touched_joints
from ...scene import Contact, Law
from ..problems.problem import Problem
from .method import Answer, Method
from .pinocchio_admm import admm

__all__ = ["METHODS"]

# Settings of ADMM [of the size of the velocities], and of sweeps [fifties].
TOLERANCES, ROUNDS = (1e-3, 1e-6, 1e-9, 1e-12), (1.0, 4.0, 16.0)

# W, b, µ and the size of the velocities to P; a setting last.
LawSolver = Callable[..., np.ndarray]


def _has_contacts(problem: Problem) -> bool:
    """Points on planes alone, under Newton's law at the end of the impact."""
    scene = problem.scene
    return (
        bool(scene.contacts)
        and scene.law == Law()
        and not (scene.constraints or problem.duration)
        and scene.robot.nv > 1
        and all(isinstance(entry, Contact) for entry in scene.contacts)
    )


def _is_rough(problem: Problem) -> bool:
    return _has_contacts(problem) and any(entry.friction for entry in _points(problem))


def _is_smooth(problem: Problem) -> bool:
    return _has_contacts(problem) and not _is_rough(problem)


def _points(problem: Problem) -> list[Contact]:
    return [entry for entry in problem.scene.contacts if isinstance(entry, Contact)]


def _by_law(law: LawSolver, problem: Problem, *settings: float) -> Answer:
    """Rows, CRBA with Cholesky, W, and one solver of the law at its settings."""
    scene, q, v = problem.scene, problem.q, problem.v
    places = needs_places(scene.robot, scene)
    reached = reached_model(scene.robot.model, touched_joints(scene), keep_places=places)
    known, rows = KnownImpulses(scene, reached), ContactRows(scene, reached)
    model, data = reached.model, reached.model.createData()
    factor = SparseFactor(model, data)
    friction = np.array([entry.friction for entry in _points(problem)])
    restitution = np.array([float(entry.restitution) for entry in _points(problem)])  # type: ignore[arg-type]

    def velocity_after() -> np.ndarray:
        own = reached.configuration(q)
        before = v[reached.v_index]
        impulse = known.generalized_impulse(data, own)
        jacobian = np.vstack([touch.jacobian for touch in rows.touching(data, own)])
        pin.crba(model, data, own)
        pin.cholesky.decompose(model, data)
        half = factor.half(jacobian, impulse[None])
        slip = jacobian @ before
        shifted = slip + half[:, -1] @ half[:, :-1]
        shifted[2::3] += restitution * np.minimum(slip[2::3], 0.0)
        delassus = half[:, :-1].T @ half[:, :-1]
        push = law(delassus, shifted, friction, float(np.abs(shifted).max()), *settings)
        after = v.copy()
        after[reached.v_index] += factor.solve(impulse + push @ jacobian)
        return after

    return velocity_after


def _active_set(
    delassus: np.ndarray, shifted: np.ndarray, friction: np.ndarray, scale: float
) -> np.ndarray:
    none = np.zeros_like(friction)
    return hit_contacts(delassus, shifted, shifted, none, none, none, NEWTON)[2]


def _admm(
    delassus: np.ndarray,
    shifted: np.ndarray,
    friction: np.ndarray,
    scale: float,
    tolerance: float,
) -> np.ndarray:
    return admm(delassus, shifted, friction, tolerance * scale, 5000)[0]


def _sweeps(
    delassus: np.ndarray,
    shifted: np.ndarray,
    friction: np.ndarray,
    scale: float,
    rounds: float,
) -> np.ndarray:
    return sweep_contacts(delassus, shifted, friction, scale, 50 * int(rounds))


@entry(lambda: (np.eye(6), np.ones(6), np.ones(2), 1.0, 1), seconds=2.0)
def sweep_contacts(
    delassus: np.ndarray, shifted: np.ndarray, friction: np.ndarray, scale: float, sweeps: int
) -> np.ndarray:
    """P after so many sweeps over the contacts, each in closed form."""
    n = len(friction)
    work = workspace(n)
    for i in range(n):
        work.mu[i] = friction[i]
    for r in range(3 * n):
        work.b[r] = shifted[r]
        for c in range(3 * n):
            work.W[r, c] = delassus[r, c]
    sweep(work, n, scale, sweeps)
    return work.P


METHODS: tuple[Method, ...] = (
    Method("impulsekit, active set", _is_smooth, partial(_by_law, _active_set)),
    *Method("impulsekit, ADMM alone", _is_rough, partial(_by_law, _admm)).at(TOLERANCES),
    *Method("impulsekit, Gauss-Seidel alone", _is_rough, partial(_by_law, _sweeps)).at(ROUNDS),
)
