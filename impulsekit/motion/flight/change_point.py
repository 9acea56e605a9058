"""Change points: linkages that pass a configuration at which their constraints lose rank.

A parallelogram is flat twice a turn. Its rows depend on each other there, and next to it rounding
divided by their smallest singular value is larger than any tolerance: steps shrink, and end at
rows that cannot hold together. Nothing happens to the motion itself, whose velocity goes on along
the branch on which it came. So the polynomial through states well before is followed to the other
side, and taken if it obeys constraints and accelerations there. At a dead centre, where a driven
linkage cannot go on, it does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import ContradictionError
from ..course.present import Present
from ..dynamics.held import HeldRows
from ..record.path import NODES, Interpolant, Path
from ..steps.steppers import Dense
from ..tree.chart import Chart
from ..zeros.roots import States

__all__ = ["Step", "find_leap", "strays"]

# So many steps are looked back: where they shrink, they do so by a fifth at least.
MOST_BACK = 100
# How far a leap reaches, in lengths of the way to the change point: half as far behind it as it
# began before. It is at least this part of the longest step: some 1e-3 rad, at which rounding of
# positions (1e-12) turns rods by 1e-9.
REACH, LEAST_REACH = 1.5, 1e-2
# The polynomial is one through states of a time so many times as long: a quarter of it beyond its
# end, errors in them are some 400 times as large (Chebyshev's T₇ at 1.5).
LEARNT = 4.0
# Behind, velocities may be off by this part of the largest, as constraints and accelerations tell;
# another branch, or a force that jumped, is off by the whole. Accelerations of the polynomial are
# told from values of it this part of the leap apart.
OFF, BRANCHES_APART = 1e-6, 1e-3
# Where a step is looked at, in parts of it, and by how many times rtol it may be off there.
LOOKED_AT, WITHIN = (0.3, 0.6, 0.85), 1e3


@dataclass(frozen=True, eq=False)
class Step:
    """One step of the integrator, or the way past a change point.

    Attributes:
        start, end: [s].
        reference: (nq,) of the chart it was made in.
        dense: y = (x, v) at a time within it.
        states: (q, v) at a time within it.
    """

    start: float
    end: float
    reference: np.ndarray
    dense: Dense
    states: States


def find_leap(now: Present, path: Path, since: float, until: float) -> tuple[int, Step] | None:
    """The way past the change point that a motion has come near to; None where there is none.

    And before it, how many pieces of the path are kept.

    Of all steps from which a leap could begin, that which leads to the least errors behind it.

    Args:
        now: the motion, stuck; nothing rests.
        path: what has been followed.
        since: nothing has happened from then on [s]: no impact, no force that jumped.
        until: nothing is known to happen before [s].
    """
    if now.held is None:
        return None
    starts = path.step_times[-MOST_BACK:]
    skipped = len(path) - len(starts)
    longest = float(np.diff([*starts, now.t]).max(initial=0.0))
    best: tuple[int, Step] | None = None
    least = math.inf
    for i, start in enumerate(starts.tolist()):
        length = max(REACH * (now.t - start), LEAST_REACH * longest)
        if start - LEARNT * length < since or start + length > until:
            continue
        leap = _learnt(now, path, start, length)
        off = _off_behind(now.held, leap)
        if off < OFF:
            off += _gained(now, leap)
        if off < min(least, OFF):
            best, least = (skipped + i, leap), off
    return best


def _learnt(now: Present, path: Path, start: float, length: float) -> Step:
    """A leap by the polynomial through states of the path before it."""
    chart, nv = Chart(now.model), now.model.nv
    begin = start - LEARNT * length
    known = [path.state(t) for t in (begin + NODES * (start - begin)).tolist()]
    chart.centred(known[-1][0])
    values = np.array([np.concatenate([chart.coordinates(q), v]) for q, v in known])
    chart.unwrap(values)
    dense = Interpolant(begin, start, values)

    def states(t: float) -> tuple[np.ndarray, np.ndarray]:
        y = dense(t)
        return np.array(chart.configuration(y[:nv])), y[nv:].copy()

    return Step(start, start + length, chart.reference, dense, states)


def _off_behind(held: HeldRows, leap: Step) -> float:
    """By which part of the terms in them velocities or places of constraints are off behind it."""
    q, v = leap.states(leap.end)
    off, terms = _velocities_off(held, q, v, leap.end)
    moved, of_rows = held.drift(q, leap.end)
    off = np.concatenate([off, np.abs(moved) / (leap.end - leap.start)])
    terms = np.concatenate([terms, terms[of_rows]])
    return float((off[off > 0.0] / terms[off > 0.0]).max(initial=0.0))


def _gained(now: Present, leap: Step) -> float:
    """By which part velocities may be off for accelerations that are, at the end of a leap."""
    length = leap.end - leap.start
    apart = BRANCHES_APART * length
    middle = leap.end - 0.5 * apart
    before, after = leap.states(leap.end - apart)[1], leap.states(leap.end)[1]
    try:
        rate = now.dynamics.acceleration(middle, *leap.states(middle))
    except ContradictionError:
        return math.inf
    off = float(np.abs((after - before) / apart - rate).max())
    return off * length / float(np.abs(after).max()) if math.isfinite(off) else math.inf


def strays(now: Present, start: float, end: float, states: States) -> bool:
    """Whether a step leaves the constraints within it, though not at its end.

    Dense output needs stages of its own: next to a change point these may be off where the step
    is not.
    """
    held = now.held
    if held is None or now.resting.acts:
        return False
    allowed = max(OFF, WITHIN * now.settings.rtol)
    for part in LOOKED_AT:
        t = start + part * (end - start)
        off, terms = _velocities_off(held, *states(t), t)
        if (off > allowed * terms).any():
            return True
    return False


def _velocities_off(
    held: HeldRows, q: np.ndarray, v: np.ndarray, t: float
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) how far velocities of rows are off, and (m,) the size of the terms in them."""
    rows, wanted = held.rows.matrix(held.data, q), held.velocity_at(t)
    # Rows, and the speeds that they hold, may be of rounding alone: all that moves counts.
    terms = held.rows.magnitude(held.data, q).sum(axis=1) * float(np.abs(v).max()) + np.abs(wanted)
    return np.abs(rows.dot(v) - wanted), terms
