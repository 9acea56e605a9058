"""Laws of contact on random bodies, each held against its own statement.

No other program is asked: cones, complementarity, velocities after and energy are worked out here
from impulses alone, as the laws are written down. Bodies in space meet each other in a row, or one
of them stands on several points, which then depend on each other.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from impulsekit.errors import ImpulsekitError
from impulsekit.impact.contact_law import (
    ContactProblem,
    ContactSolution,
    Turning,
    friction_models,
    solve_contacts,
)
from impulsekit.laws.status import judged as judged_of
from impulsekit.scene.coefficients import EllipticFriction, FrictionTable, StaticKinetic
from impulsekit.scene.law import Law
from impulsekit.tolerances import NONZERO

from .sweep import STATES, Point, Sweep, seen

__all__ = ["CONTACTS", "SWEEPS", "Judged", "energetic", "points_of", "problem_of_points"]

# What may be left of a statement, relative to the velocities or impulses in play.
LEFT = 1e-9
# Slip below this share of the velocities has no direction.
STILL = 1e-7
CONTACTS = (1.0, 2.0, 3.0, 4.0)


@dataclass(frozen=True, eq=False)
class Judged:
    """An answer and what it leaves of its statement, relative; infinity for none."""

    solution: ContactSolution
    left: float


def _bodies(n: int, rng: np.random.Generator, *, stands: bool) -> tuple[np.ndarray, np.ndarray]:
    """(6n, 6k) rows of n contacts, points before turning, and (6k,) inverse masses.

    ``stands``: all are of one body on the ground; else each is between a body and the next.
    """
    count = 1 if stands else n + 1
    inverse = np.empty(6 * count)
    for body in range(count):
        mass, radius = 10.0 ** rng.uniform(-1, 1), rng.uniform(0.05, 0.3)
        inverse[6 * body : 6 * body + 3] = 1.0 / mass
        inverse[6 * body + 3 : 6 * body + 6] = 1.0 / (mass * radius**2 * rng.uniform(0.3, 1.0, 3))
    rows = np.zeros((6 * n, 6 * count))
    for i in range(n):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        ends = [(0, 1.0)] if stands else [(i, -1.0), (i + 1, 1.0)]
        for body, sign in ends:
            arm = rng.uniform(-0.3, 0.3, 3)
            if stands:
                turn, arm[2] = np.eye(3), -0.2
            at = 6 * body
            cross = np.cross(np.eye(3), arm)
            rows[3 * i : 3 * i + 3, at : at + 3] = sign * turn.T
            rows[3 * i : 3 * i + 3, at + 3 : at + 6] = sign * turn.T @ cross
            turns = slice(3 * (n + i), 3 * (n + i) + 3)
            rows[turns, at + 3 : at + 6] = sign * turn.T
    return rows, inverse


def _problem(n: int, rng: np.random.Generator, e: float, *, stands: bool) -> ContactProblem:
    """Contacts with turning rows at a random velocity, most of them approaching."""
    rows, inverse = _bodies(n, rng, stands=stands)
    v = rng.normal(size=rows.shape[1]) * np.tile([1, 1, 1, 3, 3, 3], rows.shape[1] // 6)
    if stands:
        v[2] -= 2.0
    before = rows @ v
    W = rows * inverse @ rows.T
    turning = Turning(np.arange(n), 10.0 ** rng.uniform(-4, -1, n), 10.0 ** rng.uniform(-4, -1, n))
    mu = rng.choice([0.0, 0.2, 0.5, 0.8], n)
    return ContactProblem(
        0.5 * (W + W.T), before, before, np.full(n, e), mu, np.zeros(n), turning=turning
    )


def _of_points(problem: ContactProblem) -> ContactProblem:
    """The problem without turning."""
    m = 3 * len(problem.friction)
    W = np.ascontiguousarray(problem.delassus[:m, :m])
    before = problem.velocity_before[:m].copy()
    return replace(problem, delassus=W, velocity_before=before, velocity_free=before, turning=None)


def problem_of_points(
    n: int, rng: np.random.Generator, e: float, *, stands: bool
) -> ContactProblem:
    """Contacts without turning at a random velocity."""
    return _of_points(_problem(n, rng, e, stands=stands))


def _ball(P: np.ndarray, speed: np.ndarray, limit: float, scale: float, still: float) -> float:
    """What is left of |P| ≤ limit, and P = −limit ξ/|ξ| where ξ ≠ 0; over ``scale``."""
    size = float(np.linalg.norm(speed))
    left = float(np.linalg.norm(P)) - limit
    if size > still:
        left = max(left, float(np.linalg.norm(P + limit * speed / size)))
    return left / scale


def _sides(problem: ContactProblem, P: np.ndarray, aim: np.ndarray, held: np.ndarray) -> float:
    """What is left of 0 ≤ P_n + held ⊥ ξ_n ≥ 0 of all contacts, relative."""
    m = 3 * len(problem.friction)
    speeds = max(float(np.abs(problem.velocity_before).max()), NONZERO)
    normal, xi = P[2:m:3] + held, aim[2:m:3]
    largest = max(float(np.abs(P).max()), float(held.max(initial=0.0)), NONZERO)
    both = np.minimum(np.maximum(normal, 0.0) / largest, np.maximum(xi, 0.0) / speeds)
    return float(np.max([-normal.min() / largest, -xi.min() / speeds, both.max()]))


def _sizes(problem: ContactProblem, P: np.ndarray) -> tuple[float, float]:
    """The speed below which slip has no direction, and the largest impulse."""
    speed = float(np.abs(problem.velocity_before).max())
    return STILL * speed, float(np.abs(P).max()) + NONZERO


def _energy(problem: ContactProblem, P: np.ndarray) -> tuple[float, float]:
    """What the impulses change the energy by, and the sizes that it is a sum of [J]."""
    after = problem.velocity_before + problem.delassus @ P
    change = 0.5 * float(P @ (problem.velocity_before + after))
    return change, float(np.abs(P) @ (np.abs(problem.velocity_before) + np.abs(after))) + NONZERO


def _end(problem: ContactProblem, solution: ContactSolution) -> tuple[np.ndarray, float]:
    """(m,) velocities by u⁻ + W P, and how far the answer's are from them, relative."""
    after = problem.velocity_before + problem.delassus @ solution.impulse
    size = float(np.abs(problem.velocity_before).max() + np.abs(after).max()) + NONZERO
    return after, float(np.abs(after - solution.velocity_after).max()) / size


def _turning(n: int, rng: np.random.Generator) -> Judged:
    """Rolling and torsional friction at so many contacts, Newton's law: six cones, energy."""
    e = float(rng.choice([0.0, 0.5]))
    problem = _problem(n, rng, e, stands=bool(rng.random() < 0.3))
    solution = solve_contacts(problem, Law())
    P = solution.impulse
    after, left = _end(problem, solution)
    m, turning = 3 * n, problem.turning
    aim = after.copy()
    aim[2:m:3] += e * np.minimum(problem.velocity_before[2:m:3], 0.0)
    left = max(left, _sides(problem, P, aim, np.zeros(n)))
    if turning is None:
        raise TypeError("nothing turns")
    still, scale = _sizes(problem, P)
    for i in range(n):
        normal, at = float(P[3 * i + 2]), m + 3 * i
        for own, reach in (
            (slice(3 * i, 3 * i + 2), problem.friction[i]),
            (slice(at, at + 2), turning.rolling[i]),
            (slice(at + 2, at + 3), turning.torsion[i]),
        ):
            left = max(left, _ball(P[own], after[own], reach * normal, scale, still))
    if e == 0.0:
        change, size = _energy(problem, P)
        left = max(left, change / size)
    return Judged(solution, left)


def _adhesion(n: int, rng: np.random.Generator) -> Judged:
    """Contacts that hold up to an impulse, e = 0: 0 ≤ P_n + A ⊥ u_n⁺ ≥ 0 and µ (P_n + A)."""
    problem = _of_points(_problem(n, rng, 0.0, stands=bool(rng.random() < 0.3)))
    held = rng.choice([0.0, 0.1, 1.0], n)
    problem = replace(problem, adhesion=held)
    solution = solve_contacts(problem, Law())
    P = solution.impulse
    after, left = _end(problem, solution)
    left = max(left, _sides(problem, P, after, held))
    still, scale = _sizes(problem, P)
    for i in range(n):
        limit = problem.friction[i] * (float(P[3 * i + 2]) + held[i])
        own = slice(3 * i, 3 * i + 2)
        left = max(left, _ball(P[own], after[own], limit, scale, still))
    change, size = _energy(problem, P)
    return Judged(solution, max(left, change / size))


def _friction(n: int, rng: np.random.Generator) -> Judged:
    """Static and kinetic friction, by slip speed and by direction, e = 0: cones, energy."""
    problem = _of_points(_problem(n, rng, 0.0, stands=bool(rng.random() < 0.2)))
    models: list[Any] = []
    axes: list[np.ndarray | None] = []
    for _ in range(n):
        kind, most = int(rng.integers(3)), float(rng.uniform(0.1, 0.7))
        angle = float(rng.uniform(0, 2 * math.pi))
        if kind == 0:
            models.append(StaticKinetic(most, most * float(rng.uniform(0.3, 1.0))))
        elif kind == 1:
            low = most * float(rng.uniform(0.5, 1.0))
            models.append(FrictionTable((0.0, 2.0), (most, low)))
        else:
            models.append(EllipticFriction(most, most * float(rng.uniform(0.1, 1.0))))
        axes.append(np.array([math.cos(angle), math.sin(angle)]) if kind == 2 else None)
    solution = solve_contacts(problem, Law(), friction_models(models, axes))
    P = solution.impulse
    after, left = _end(problem, solution)
    left = max(left, _sides(problem, P, after, np.zeros(n)))
    still, scale = _sizes(problem, P)
    for i, (model, axis) in enumerate(zip(models, axes, strict=True)):
        force, slip = P[3 * i : 3 * i + 2], after[3 * i : 3 * i + 2]
        normal, speed = float(P[3 * i + 2]), float(np.linalg.norm(slip))
        if axis is not None:
            # In units of the half axes the ellipse is a circle.
            mu = np.array([model.first, model.second])
            turn = np.array([[axis[0], -axis[1]], [axis[1], axis[0]]])
            force, slip, limit = turn.T @ force / mu, mu * (turn.T @ slip), normal
        else:
            limit = model(speed if speed > still else 0.0) * normal
        left = max(left, _ball(force, slip, limit, scale, still))
    change, size = _energy(problem, P)
    return Judged(solution, max(left, change / size))


def _lzb(n: int, rng: np.random.Generator) -> Judged:
    """Liu, Zhao & Brogliato's law: nothing approaches, cones, works of each contact, energy."""
    e, stands = float(rng.choice([0.0, 0.5, 1.0])), bool(rng.random() < 0.3)
    problem = problem_of_points(n, rng, e, stands=stands)
    if stands:
        # With friction they are of the sweep of paths.
        problem = replace(problem, friction=np.zeros(n))
    problem = replace(problem, stiffness=10.0 ** rng.uniform(4, 6, n))
    return energetic(problem, Law("lzb", exponent=float(rng.choice([1.0, 1.5]))))


def energetic(problem: ContactProblem, law: Law) -> Judged:
    """What is left of velocities, cones, works and energy of contacts with stiffness."""
    solution = solve_contacts(problem, law)
    P = solution.impulse
    after, left = _end(problem, solution)
    speeds, scale = float(np.abs(problem.velocity_before).max()), float(np.abs(P).max()) + NONZERO
    left = max(left, -float(P[2::3].min()) / scale, -float(after[2::3].min()) / speeds)
    across = np.hypot(P[0::3], P[1::3]) - problem.friction * P[2::3]
    change, size = _energy(problem, P)
    works = solution.normal_work, solution.friction_work
    left = max(left, float(across.max()) / scale, change / size)
    left = max(left, abs(float(works[0].sum() + works[1].sum()) - change) / size)
    return Judged(solution, max(left, *(float(work.max()) / size for work in works)))


def points_of(
    judged: Callable[[int, np.random.Generator], Judged],
    states: int | None = None,
    bound: float = LEFT,
) -> Any:
    """The cases of a sweep: so many states, each judged by what may be left, and timed."""

    def points(value: float, rng: np.random.Generator) -> list[Point]:
        found = []
        for i in range(states or STATES):
            start = time.perf_counter()
            try:
                told = judged(int(value), rng)
                own = judged_of(told.solution.status, told.solution.residual)
                status, left, valid = own.name, told.left, own.valid
            except ImpulsekitError as error:
                status, left, valid = type(error).__name__, math.nan, False
            seconds = time.perf_counter() - start
            verdict = "said so" if not valid else "right" if left <= bound else "wrong"
            # What is left in double precision is an error here, no residual in 50 digits.
            shown = left if valid else math.nan
            found.append(
                seen(i, "solve", status, verdict, seconds, error=shown, condition=math.nan)
            )
        return found

    points.__doc__ = judged.__doc__
    return points


SWEEPS = tuple(
    Sweep(f"statement-{name}", "contacts", CONTACTS, points_of(own), 420, logarithmic=False)
    for name, own in (
        ("turning", _turning),
        ("adhesion", _adhesion),
        ("friction", _friction),
        ("lzb", _lzb),
    )
)
