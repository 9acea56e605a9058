"""One step of DOP853 with the tree, the forces and the law of resting points in compiled code.

The formulas of the step are those of ``explicit``, those of the accelerations of ``dynamics``.
"""

from __future__ import annotations

import math

import numpy as np

from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import entry
from ...laws.dense import put
from ...laws.half import is_safe, solve_mass
from ...laws.tolerances import RESIDUAL_LIMIT
from ..forces.laws import add_torques, push_bodies
from ..tree.bodies import (
    begin_forces,
    look_at,
    take_forces,
    write_factor,
    write_jacobian,
)
from ..tree.coordinates import write_configuration, write_rate
from ..tree.pressed import Found, Loaded, press
from .explicit import Tableau, error_of_sums, first_guess, first_length, first_powers
from .system import TOLERANCES, System, Work
from .tables import example_step

__all__ = [
    "NOT_SOLVED",
    "SOLVED",
    "UNSAFE",
    "accelerate",
    "attempt",
    "begin_steps",
    "evaluate",
    "rates_at",
    "try_step",
]

# What became of a step: done, no forces at rest, a pivot of M that is rounding.
SOLVED, NOT_SOLVED, UNSAFE = 0, 1, 2


@borrowing
def evaluate(system: System, driven: np.ndarray, y: np.ndarray, rates: np.ndarray) -> int:
    """Write ẏ (2 nv,) of y = (x, v); what became of it."""
    nv = len(system.load)
    write_configuration(system.tree, system.reference, y[:nv], system.q)
    write_rate(system.tree, y[:nv], system.q, y[nv:], rates[:nv])
    return accelerate(system, driven, y[nv:], rates[nv:])


@borrowing
def accelerate(system: System, driven: np.ndarray, v: np.ndarray, rate: np.ndarray) -> int:
    """Write v̇ (nv,) at ``system.q``; what became of it."""
    tree, room, load, q = system.tree, system.room, system.load, system.q
    nv = len(load)
    look_at(tree, room, q, v)
    write_factor(tree, room)
    begin_forces(tree, room)
    push_bodies(system.loads, driven, room.kinematics.places, room.kinematics.speeds, room.force)
    put(system.loads.constant, load)
    add_torques(system.loads, driven, q, v, load)
    take_forces(tree, room, load)
    total = 0.0
    for k in range(nv):
        total += load[k]
    if not abs(total) < math.inf:
        rate[:] = math.nan
        return SOLVED
    if len(system.table.whole) == 0:
        if not is_safe(room.factor):
            return UNSAFE
        solve_mass(room.factor, load)
        put(load, rate)
        return SOLVED
    write_jacobian(tree, room)
    found = Found(rate, system.last, system.accelerations, system.slip)
    state = Loaded(system.table, room.kinematics, room.factor, system.sliding, load, v)
    residual = press(state, found)
    if residual < 0.0:
        return UNSAFE
    return SOLVED if residual <= RESIDUAL_LIMIT else NOT_SOLVED


@borrowing
def _stage(system: System, tableau: Tableau, work: Work, s: int, h: float) -> int:
    """Write the slope of a stage."""
    for k in range(len(work.trial)):
        total = 0.0
        for j in range(s):
            total += tableau.weights[s, j] * work.slopes[j, k]
        work.trial[k] = work.before[k] + total * h
    return evaluate(system, work.driven[s], work.trial, work.slopes[s])


@entry(example_step, seconds=24.0, apart=True)
def attempt(
    system: System, tableau: Tableau, work: Work, h: float, rtol: float, atol: float
) -> tuple[int, float]:
    """Try a step of length h; with its dense output where its error is below 1.

    Returns:
        What became of it, and its error in units of what is allowed.
    """
    system, tableau, work = borrowed(system), borrowed(tableau), borrowed(work)
    return try_step(system, tableau, work, h, rtol, atol)


@borrowing
def try_step(
    system: System, tableau: Tableau, work: Work, h: float, rtol: float, atol: float
) -> tuple[int, float]:
    """As ``attempt``."""
    before, after, slopes = work.before, work.after, work.slopes
    count, size = len(tableau.result), len(work.before)
    for s in range(1, count):
        state = _stage(system, tableau, work, s, h)
        if state != SOLVED:
            return state, math.inf
    for k in range(size):
        total = 0.0
        for j in range(count):
            total += tableau.result[j] * slopes[j, k]
        after[k] = before[k] + h * total
    state = evaluate(system, work.driven[count], after, slopes[count])
    if state != SOLVED:
        return state, math.inf
    error = _error(tableau, work, h, rtol, atol)
    if not error < 1.0:
        return SOLVED, error
    for s in range(count + 1, len(slopes)):
        state = _stage(system, tableau, work, s, h)
        if state != SOLVED:
            return state, math.inf
    powers = work.powers
    for k in range(size):
        change = after[k] - before[k]
        found = first_powers(h, change, slopes[0, k], slopes[count, k])
        powers[0, k], powers[1, k], powers[2, k] = found
        for i in range(len(tableau.dense)):
            total = 0.0
            for j in range(len(slopes)):
                total += tableau.dense[i, j] * slopes[j, k]
            powers[3 + i, k] = h * total
    return SOLVED, error


@entry(lambda: _examples_of_rates(), seconds=1.0)
def rates_at(system: System, driven: np.ndarray, y: np.ndarray, rates: np.ndarray) -> int:
    """``evaluate`` as Python calls it."""
    return evaluate(borrowed(system), borrowed(driven), borrowed(y), borrowed(rates))


def _examples_of_rates() -> tuple:
    system, _, work, *_ = example_step()
    return system, work.driven[0], work.before, work.after


def _examples_of_begin() -> tuple:
    system, _, work, *_ = example_step()
    return system, work, work.before, 1.0, *TOLERANCES


@entry(_examples_of_begin, seconds=2.0, apart=True)
def begin_steps(
    system: System, work: Work, y: np.ndarray, span: float, rtol: float, atol: float
) -> tuple[int, float]:
    """Write the rates of y (2 nv,) as the first slope of ``work``.

    Returns:
        What became of it, and a first step [s] of at most ``span``; see ``explicit.first_guess``.
        With a ``span`` of 0, where it is known already, it is not looked for.
    """
    system, work, y = borrowed(system), borrowed(work), borrowed(y)
    rates, size = work.slopes[0], len(y)
    state = evaluate(system, work.driven[0], y, rates)
    if state != SOLVED or not span > 0.0:
        return state, 0.0
    guess = min(first_guess(_size(y, y, rtol, atol), _size(rates, y, rtol, atol)), span)
    for k in range(size):
        work.trial[k] = y[k] + guess * rates[k]
    state = evaluate(system, work.driven[0], work.trial, work.slopes[1])
    if state != SOLVED:
        return state, 0.0
    for k in range(size):
        work.trial[k] = work.slopes[1, k] - rates[k]
    bend = _size(work.trial, y, rtol, atol) / guess
    return SOLVED, min(first_length(guess, _size(rates, y, rtol, atol), bend), span)


@borrowing
def _size(values: np.ndarray, y: np.ndarray, rtol: float, atol: float) -> float:
    """The root mean square of values in units of what is allowed of y."""
    total = 0.0
    for k in range(len(y)):
        total += (values[k] / (atol + abs(y[k]) * rtol)) ** 2
    return math.sqrt(total / len(y))


@borrowing
def _error(tableau: Tableau, work: Work, h: float, rtol: float, atol: float) -> float:
    """The error of a step in units of what is allowed."""
    square, other, size = 0.0, 0.0, len(work.before)
    for k in range(size):
        scale = atol + max(abs(work.before[k]), abs(work.after[k])) * rtol
        fifth, third = 0.0, 0.0
        for j in range(tableau.errors.shape[1]):
            fifth += tableau.errors[0, j] * work.slopes[j, k]
            third += tableau.errors[1, j] * work.slopes[j, k]
        square += (fifth / scale) ** 2
        other += (third / scale) ** 2
    return error_of_sums(h, square, other, size)
