"""Pinocchio's ADMM on a given Delassus matrix."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

__all__ = ["admm"]

# Contacts whose masses differ by more than this are scaled one by one.
ALIKE = 1e-2
NULL = 1e-14


def admm(
    delassus: np.ndarray,
    shifted: np.ndarray,
    friction: np.ndarray,
    tolerance: float,
    most: int = 1000,
) -> tuple[np.ndarray, int]:
    """An impulse near the solution, and how many iterations it took.

    The velocities given are ξ without contact impulse: restitution, one coefficient per
    contact and for the normal alone, is in their normal parts already.

    Args:
        delassus: (3n, 3n) W [1/kg].
        shifted: (3n,) b [m/s].
        friction: (n,) µ.
        tolerance: for feasibility and complementarity [m/s].
        most: how many iterations at most.
    """
    import pinocchio as pin

    n = len(friction)
    work = _workspace(n)
    for model, mu in zip(work.contacts, friction.tolist(), strict=True):
        model.setFriction(mu)
    settings = work.settings
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = tolerance
    settings.max_iterations = most
    # ADMM's tolerances are absolute: with the rows scaled they are velocities.
    sizes = delassus.diagonal().reshape(n, 3).max(axis=1)
    size = float(sizes.max())
    scale: float | np.ndarray = 1.0 / size
    scaled = delassus / size
    if float(sizes.min()) < ALIKE * size:
        # Each contact in units of its own mass; one factor for its three rows keeps cones cones.
        units = np.repeat(1.0 / np.sqrt(np.maximum(sizes, NULL * size)), 3)
        scale, scaled = units, delassus * units * units[:, None]
        largest = float(np.abs(shifted).max())
        shifted = shifted * units
        settings.absolute_feasibility_tol *= float(np.abs(shifted).max()) / largest
        settings.absolute_complementarity_tol = settings.absolute_feasibility_tol
    result = pin.ADMMSolverResult()
    work.solver.solve(
        pin.DelassusOperatorDense(scaled),
        shifted,
        work.models,
        work.datas,
        settings,
        result,
    )
    return result.retrieveConstraintImpulses() * scale, int(result.iterations)


class _Workspace:
    """What Pinocchio wants besides the matrix, for n contacts.

    Rows are given ready, so the contacts sit anywhere on a model that is never looked at.
    """

    def __init__(self, n: int) -> None:
        import pinocchio as pin

        model = pin.Model()
        model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "contact")
        self.models, self.datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
        for _ in range(n):
            contact = pin.PointContactConstraintModel(model, 1, pin.SE3.Identity())
            self.models.append(pin.ConstraintModel(contact))
        # The list holds copies: these are references into it.
        self.contacts: list[Any] = [self.models[i].extract() for i in range(n)]
        for i in range(n):
            self.datas.append(self.models[i].createData())
        self.solver = pin.ADMMConstraintSolver(3 * n)
        self.settings = pin.ADMMSolverSettings()
        self.settings.relative_feasibility_tol = 0.0
        self.settings.relative_complementarity_tol = 0.0


class _Workspaces(threading.local):
    """The workspaces of this thread, by the number of contacts."""

    def __init__(self) -> None:
        self.by_count: dict[int, _Workspace] = {}


_workspaces = _Workspaces()


def _workspace(n: int) -> _Workspace:
    work = _workspaces.by_count.get(n)
    if work is None:
        work = _workspaces.by_count[n] = _Workspace(n)
    return work
