"""impulsekit's own ways: as a user calls it."""

from __future__ import annotations

import warnings
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from impulsekit.batch.long import long_tree
from impulsekit.batch.solve import solve_batch
from impulsekit.checking.demands import constraint_rows, known_impulses
from impulsekit.checking.system import reference_robot
from impulsekit.errors import ImpulsekitError, SetupWarning
from impulsekit.impact import ImpactSolver, solve
from impulsekit.motion import simulate
from impulsekit.reference import Arithmetic

from ..problems.problem import Problem
from .method import Answer, Method

# Of a batch.
STATES = 1024
# Of one that is large enough for all threads.
MANY_STATES = 16384
# Of Kane's equations in Python; beyond, a call takes seconds.
MOST_SPEEDS_FOR_KANE = 60
# From loose to tight.
MOTION_SETTINGS: dict[str, tuple[float, ...]] = {
    "dop853": (1e-4, 1e-6, 1e-8, 1e-10, 1e-12),
    "radau": (1e-4, 1e-6, 1e-8),
    "rk4": (4e-3, 2e-3, 1e-3),
    "semi-implicit": (4e-3, 1e-3),
}


def is_known_blow(problem: Problem) -> bool:
    """Whether nothing acts but known impulses, and only the velocities after are asked."""
    scene = problem.scene
    return not (scene.constraints or scene.contacts or problem.duration)


def _is_impact(problem: Problem) -> bool:
    return not problem.duration


def _is_motion(problem: Problem) -> bool:
    return bool(problem.duration)


def _once(problem: Problem) -> Answer:
    scene, q, v = problem.scene, problem.q, problem.v
    # Problems are drawn at random: what their first solve warns of is meant.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SetupWarning)
        solve(scene, q, v)
    return lambda: solve(scene, q, v).v_after


def _solver(problem: Problem) -> Answer:
    solver, q, v = ImpactSolver(problem.scene), problem.q, problem.v
    return lambda: solver.solve(q, v).v_after


def _is_batched(problem: Problem) -> bool:
    """Whether it is a scene at one instant."""
    return _is_impact(problem)


def _batch(
    problem: Problem,
    threads: int | None = None,
    states: int = STATES,
) -> Answer:
    """The problem's state first, and as many others around it, so that no branch repeats."""
    robot, rng = problem.scene.robot, np.random.default_rng(0)
    steps = 0.05 * rng.uniform(-1.0, 1.0, (states, robot.nv))
    steps[0] = 0.0
    q = np.array([pin.integrate(robot.model, problem.q, step) for step in steps])
    q[0] = problem.q
    v = problem.v * (1.0 + 0.1 * rng.uniform(-1.0, 1.0, (states, robot.nv)))
    v[0] = problem.v
    return lambda: solve_batch(problem.scene, q, v, threads=threads).v_after[0]


def _is_quick_batch(problem: Problem) -> bool:
    """Whether a large batch takes milliseconds, not seconds."""
    return len(problem.scene.contacts) <= 1 and _is_batched(problem)


def _is_long_tree(problem: Problem) -> bool:
    if not is_known_blow(problem):
        return False
    try:
        long_tree(problem.scene.robot)
    except ImpulsekitError:
        return False
    return True


def _long(problem: Problem) -> Answer:
    tree, impulses = long_tree(problem.scene.robot), problem.scene.impulses
    return lambda: tree.solve(impulses, problem.q, problem.v).v_after


def _is_for_kane(problem: Problem) -> bool:
    scene = problem.scene
    small = scene.robot.nv <= MOST_SPEEDS_FOR_KANE
    return small and _is_impact(problem) and not scene.contacts


def _kane(problem: Problem) -> Answer:
    """Chang & Huston's equations as the paper has them, in numpy."""
    scene, q, v = problem.scene, problem.q, problem.v
    reference = reference_robot(scene.robot, Arithmetic.double())
    system, known = reference.system, known_impulses(reference, scene.impulses)

    def velocity_after() -> np.ndarray:
        rows = None
        if scene.constraints:
            rows = constraint_rows(reference, system.kinematics(q), v, scene.constraints)
        return system.impact(q, v, known.loads, known.in_joints, rows).y_after

    return velocity_after


def _motion(problem: Problem, setting: float, method: str) -> Answer:
    adaptive = method in ("dop853", "radau")
    settings: dict[str, Any] = (
        {"rtol": setting, "atol": 1e-2 * setting} if adaptive else {"step": setting}
    )

    def state_at_end() -> np.ndarray:
        motion = simulate(
            problem.scene,
            problem.q,
            problem.v,
            duration=problem.duration,
            samples=2,
            method=method,
            **settings,
        )
        return np.concatenate([motion.q[-1], motion.v[-1]])

    return state_at_end


_batched = partial(Method, states=STATES)
METHODS: tuple[Method, ...] = (
    Method("impulsekit, solve", _is_impact, _once),
    Method("impulsekit, solver", _is_impact, _solver),
    _batched("impulsekit, batch", _is_batched, _batch),
    _batched("impulsekit, batch on one thread", _is_batched, partial(_batch, threads=1)),
    _batched(
        "impulsekit, large batch",
        _is_quick_batch,
        partial(_batch, states=MANY_STATES),
        states=MANY_STATES,
    ),
    Method("impulsekit, long tree", _is_long_tree, _long),
    Method("impulsekit, Kane in numpy", _is_for_kane, _kane),
    *(
        each
        for method, settings in MOTION_SETTINGS.items()
        for each in Method(
            f"impulsekit, simulate {method}", _is_motion, partial(_motion, method=method)
        ).at(settings)
    ),
)
