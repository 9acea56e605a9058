"""Exudyn: the mass matrix of its kinematic tree, one step, its contacts, its motion.

Contacts are Exudyn's sphere on
a triangle: a spring with the damper of Carvalho & Martins and friction that is proportional below
a creep speed, followed by its implicit trapezoidal rule; steps and creep go with the root of
the stiffness. Without friction it goes to every law's answer; with it, to one
about 1 % off Stronge's.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from ..problems.problem import Problem
from .exudyn_touch import add_touch
from .exudyn_tree import ExudynTree, exudyn_settings, struck_system
from .mechanism import is_blow, is_flight, is_landing, mechanism_of
from .method import Answer, Method
from .swing import approach_speed, half_swing

__all__ = ["METHODS"]

NEEDS = ("exudyn",)
STEP = 1e-6
# Exudyn wants a restitution above zero.
LEAST = 1e-3
# Half swings that are followed: an impact, and those it sets off.
LASTS = 3.0
# Steps times contacts times the size of the matrices: about a second.
MOST_WORK = 5e4
# Approaches below this share of the fastest have no restitution.
SLOWEST = 1e-6


def _by_mass_matrix(problem: Problem) -> Answer:
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree = ExudynTree(mechanism)
    # At rest, so that the loads are all there is on the right.
    still = np.zeros(len(tree.q))
    container, system = struck_system(mechanism, tree, still, 1.0)
    solver = exu.MainSolverImplicitSecondOrder()
    solver.InitializeSolver(system, exudyn_settings(1.0, 1))
    q, v, size = np.zeros(len(tree.q)), mechanism.v, len(tree.q)
    data, current = system.systemData, exu.ConfigurationType.Current

    def velocity_after() -> np.ndarray:
        data.SetODE2Coordinates(q, current)
        solver.ComputeMassMatrix(system)
        solver.ComputeODE2RHS(system)
        momentum = solver.GetSystemResidual()[:size]
        return v + np.linalg.solve(solver.GetSystemMassMatrix(), momentum)

    # The container owns what the solver points into.
    velocity_after.owner = container  # type: ignore[attr-defined]
    return velocity_after


def _by_motion(problem: Problem, step: float, solver: str) -> Answer:
    """The jump by the mass matrix, then steps of one of Exudyn's solvers."""
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree, after_blow = ExudynTree(mechanism), _by_mass_matrix(problem)
    container, system, _ = tree.system(mechanism.v, gravity=problem.scene.gravity)
    system.Assemble()
    steps = max(1, round(problem.duration / step))
    settings = exudyn_settings(problem.duration / steps, steps)
    data, moments = system.systemData, exu.ConfigurationType

    def state_after() -> np.ndarray:
        data.SetODE2Coordinates_t(after_blow(), moments.Initial)
        system.SolveDynamic(
            settings, solverType=getattr(exu.DynamicSolverType, solver), showHints=False
        )
        q = tree.q + data.GetODE2Coordinates(moments.Current)
        return np.concatenate([q, data.GetODE2Coordinates_t(moments.Current)])

    state_after.owner = container  # type: ignore[attr-defined]
    return state_after


def _suits_motion(problem: Problem) -> bool:
    """Joints of one degree of freedom alone: others are turned through angles that end."""
    robot = problem.scene.robot
    return is_flight(problem) and robot.nq == robot.nv


def _by_step(problem: Problem) -> Answer:
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree = ExudynTree(mechanism)
    container, system = struck_system(mechanism, tree, mechanism.v, STEP)
    return _solved(container, system, exudyn_settings(STEP, 1), exu.DynamicSolverType.ExplicitEuler)


def _solved(container: Any, system: Any, settings: Any, solver: Any) -> Answer:
    """The velocities at the end of a run of Exudyn's."""
    import exudyn as exu

    def velocity_after() -> np.ndarray:
        try:
            system.SolveDynamic(settings, solverType=solver, showHints=False)
        except exu.SolverError:
            return np.full(system.systemData.ODE2Size(), np.nan)
        return np.array(system.systemData.GetODE2Coordinates_t(exu.ConfigurationType.Current))

    velocity_after.owner = container  # type: ignore[attr-defined]
    return velocity_after


def _by_contacts(problem: Problem, stiffness: float) -> Answer:
    import exudyn as exu

    mechanism = mechanism_of(problem)
    tree = ExudynTree(mechanism)
    container, system, item = tree.system(mechanism.v)
    approach = approach_speed(problem, mechanism)
    swing = half_swing(problem, mechanism, stiffness)
    # The middle of the sphere stays in front of the triangle.
    radius = 2.0 * approach * swing

    for touch in mechanism.touches:
        add_touch(
            system,
            tree,
            mechanism,
            item,
            touch,
            radius,
            dynamicFriction=touch.friction,
            frictionProportionalZone=approach / math.sqrt(stiffness),
            contactStiffness=stiffness,
            restitutionCoefficient=max(touch.restitution, LEAST),
            minimumImpactVelocity=SLOWEST * approach,
            impactModel=2,
        )
    system.Assemble()
    steps = int(LASTS * math.sqrt(stiffness))
    settings = exudyn_settings(LASTS * swing / steps, steps)
    settings.timeIntegration.newton.useModifiedNewton = False
    return _solved(container, system, settings, exu.DynamicSolverType.TrapezoidalIndex2)


def _suits_contacts(problem: Problem, stiffness: float) -> bool:
    work = math.sqrt(stiffness) * len(problem.scene.contacts) * problem.scene.robot.nv**2
    return is_landing(problem) and work <= MOST_WORK


METHODS: tuple[Method, ...] = (
    Method("exudyn, mass matrix", is_blow, _by_mass_matrix, peer=True, needs=NEEDS),
    Method("exudyn, one step", is_blow, _by_step, peer=True, needs=NEEDS, setting=STEP),
    *(
        Method(
            "exudyn, contacts",
            partial(_suits_contacts, stiffness=stiffness),
            partial(_by_contacts, stiffness=stiffness),
            peer=True,
            needs=NEEDS,
            setting=stiffness,
        )
        for stiffness in (1e3, 1e4, 1e5, 1e6, 1e7)
    ),
    *(
        each
        for name, solver, steps in (
            ("generalized alpha", "GeneralizedAlpha", (1e-3, 1e-4)),
            ("RK44", "RK44", (4e-3, 1e-3, 2.5e-4)),
        )
        for each in Method(
            f"exudyn, {name}",
            _suits_motion,
            partial(_by_motion, solver=solver),
            peer=True,
            needs=NEEDS,
        ).at(steps)
    ),
)
