"""impulsekit's own ways: as a user calls it, and each algorithm by itself."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from ...batch.long import long_tree
from ...batch.plans import plan_batch
from ...batch.solve import solve_batch, warm_up
from ...checking.demands import constraint_rows, known_impulses
from ...checking.system import reference_robot
from ...errors import ImpulsekitError, SetupWarning
from ...impact import ImpactSolver, solve
from ...impact.algorithms import ByAba, ByCrba, ByDenseCholesky
from ...impact.constrained import ConstrainedJump
from ...impact.known import KnownImpulses
from ...motion import simulate
from ...reference import Arithmetic
from ...robot.massless import is_always_regular
from ...rows.constraints import needs_places
from ...rows.reach import ReachedModel, reached_model, touched_joints
from ..problems.problem import Problem
from . import contact_laws
from .method import Answer, Method

__all__ = ["METHODS", "is_known_blow"]

NUMBA = ("numba",)
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


def _has_rows(problem: Problem) -> bool:
    """Constraints, or contacts under the law that the general way is made for."""
    return _is_impact(problem) and bool(problem.scene.constraints or problem.scene.contacts)


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


def _reached(problem: Problem) -> ReachedModel:
    scene = problem.scene
    places = needs_places(scene.robot, scene)
    return reached_model(scene.robot.model, touched_joints(scene), keep_places=places)


def _algorithm(make: Callable[[KnownImpulses], Any], problem: Problem) -> Answer:
    """One of the ways to Δv, whatever the plan would choose."""
    reached, v = _reached(problem), problem.v
    way = make(KnownImpulses(problem.scene, reached))

    def velocity_after() -> np.ndarray:
        after = v.copy()
        after[reached.v_index] += way.velocity_jump(reached.configuration(problem.q))
        return after

    return velocity_after


def _by_crba(known: KnownImpulses) -> ByCrba:
    return ByCrba(known, always_regular=is_always_regular(known.model))


def _by_delassus(problem: Problem) -> Answer:
    """The way of constraints and contacts, for a single contact too, which has its own."""
    reached, q, v = _reached(problem), problem.q, problem.v
    known = KnownImpulses(problem.scene, reached)
    jump = ConstrainedJump(problem.scene, known, reached)

    def velocity_after() -> np.ndarray:
        after = v.copy()
        own, _ = jump.solve(reached.configuration(q), v[reached.v_index])
        after[reached.v_index] += own
        return after

    return velocity_after


def _is_batched(problem: Problem) -> bool:
    """Whether the kernels know the scene."""
    return _is_impact(problem) and plan_batch(problem.scene)[0] is not None


def _batch(
    problem: Problem,
    threads: int | None = None,
    number: type[np.floating] = np.float64,
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
    warm_up(problem.scene, dtype=number)
    return lambda: solve_batch(problem.scene, q, v, threads=threads, dtype=number).v_after[0]


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


_batched = partial(Method, needs=NUMBA, states=STATES)
METHODS: tuple[Method, ...] = (
    Method("impulsekit, solve", _is_impact, _once),
    Method("impulsekit, solver", _is_impact, _solver),
    Method("impulsekit, aba", is_known_blow, partial(_algorithm, ByAba)),
    Method("impulsekit, crba", is_known_blow, partial(_algorithm, _by_crba)),
    Method("impulsekit, dense", is_known_blow, partial(_algorithm, ByDenseCholesky)),
    Method("impulsekit, delassus", _has_rows, _by_delassus),
    *contact_laws.METHODS,
    _batched("impulsekit, batch", _is_batched, _batch),
    _batched("impulsekit, batch on one thread", _is_batched, partial(_batch, threads=1)),
    _batched(
        "impulsekit, batch in float32",
        _is_batched,
        partial(_batch, number=np.float32),
        precision="float32",
    ),
    _batched(
        "impulsekit, large batch",
        _is_quick_batch,
        partial(_batch, states=MANY_STATES),
        states=MANY_STATES,
    ),
    Method("impulsekit, long tree", _is_long_tree, _long, needs=NUMBA),
    Method("impulsekit, Kane in numpy", _is_for_kane, _kane),
    *(
        each
        for method, settings in MOTION_SETTINGS.items()
        for each in Method(
            f"impulsekit, simulate {method}", _is_motion, partial(_motion, method=method)
        ).at(settings)
    ),
)
