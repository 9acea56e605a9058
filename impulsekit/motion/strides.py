"""Many steps of a motion in one compiled call, until something happens."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .chart import Chart
from .compiled_advance import HAPPENS, Log, Track, advance
from .compiled_model import NO_POINTS, tableau
from .compiled_mover import Mover
from .compiled_settle import Stand
from .compiled_stepper import CompiledStepper
from .crossing import Seen
from .explicit import Output
from .footing import NOTHING, Footing
from .path import Path
from .present import Present

__all__ = ["MOST", "Stride", "Strides"]

# So many steps are made at once at most.
MOST = 32


@dataclass(frozen=True)
class Stride:
    """Steps that were made at once.

    Attributes:
        why: what ended them, as ``advance`` says it.
        count: how many they are, without the one in which something happens.
        seen: of ``HAPPENS`` what that is.
        last: of ``HAPPENS`` the output of that step, and its end [s].
    """

    why: int
    count: int
    seen: Seen = Seen(False, False)  # noqa: RUF009
    last: tuple[Output, float] | None = None


class Strides:
    """Makes them, where all that moves and may be met is known to compiled code.

    Args:
        now: the motion. mover: what compiled code knows of it.
        chart, stepper, path: of its flight.
    """

    def __init__(
        self, now: Present, mover: Mover, chart: Chart, stepper: CompiledStepper, path: Path
    ) -> None:
        self._now, self._mover, self._chart = now, mover, chart
        self._stepper, self._path = stepper, path
        self._logs: dict[int, Log] = {}
        self._turning = chart.turning.astype(float)
        gaps = now.gaps
        self._known = mover.driven.is_constant and (gaps is None or bool(gaps.tabled.all()))
        advance.load()

    @property
    def can(self) -> bool:
        """Whether there is compiled code for what moves now."""
        return self._known and advance.is_compiled and not self._now.passing

    def wait(self, seconds: float) -> None:
        """Steps took so long in another way [s]."""
        if self._known:
            advance.wait(seconds)

    def make(self, until: float, most: int, deepest: np.ndarray) -> Stride | None:
        """Steps from the present state to a time [s], ``most`` or fewer; None if there are none.

        ``deepest``: (m,) how deep gaps may be.
        """
        now, stepper, mover = self._now, self._stepper, self._mover
        found = mover.now()
        if found is None:
            return None
        contacts = now.resting.contacts
        log, work = self._log(len(contacts), most), stepper.work
        system = found._replace(
            reference=self._chart.reference.copy(), sliding=now.resting.sliding()
        )
        resting = [contact.gap for contact in contacts]
        ways, begins = now.resting.ways_of_slip()
        watched = mover.watched(now.base, resting, ways, begins)
        stand = Stand(ways, begins, now.resting.grown, False, False)
        longest = math.inf if now.settings.max_step is None else now.settings.max_step
        clock = np.array([now.t, stepper.length, until, longest, math.inf, *stepper.before])
        table = None if now.gaps is None else now.gaps.rated_table
        track = Track(
            now.q.copy(),
            now.v.copy(),
            clock,
            self._turning,
            NO_POINTS if table is None else table,
            deepest,
        )
        work.before[:], work.slopes[0] = stepper.y, stepper.f
        why, count, made, stops = advance(
            system, tableau(), work, watched, stand, track, log, *stepper.tolerances
        )
        mover.count(made)
        start = self._keep(log, count, now.t)
        if count:
            if contacts:
                now.resting.note(*log.rest.copy())
            now.resting.slide_as(ways, begins)
            now.t, now.q, now.v = start, track.q, track.v
            self._chart.reference = system.reference
            stepper.go_on(start, work.before.copy(), work.slopes[0].copy(), clock)
        if why != HAPPENS:
            return Stride(why, count)
        end = float(log.ends[count])
        last = Output(start, end - start, log.before[count].copy(), log.powers[count].copy())
        after = work.slopes[len(tableau().result)].copy()
        stepper.go_on(end, work.after.copy(), after, clock)
        return Stride(why, count, mover.seen(watched, float(clock[4]), stops), (last, end))

    def _keep(self, log: Log, count: int, t: float) -> float:
        """Add steps to the path; where they end [s]."""
        now, footing = self._now, NOTHING
        for k in range(count):
            end = float(log.ends[k])
            if now.resting.contacts and not (footing is not NOTHING and _as_before(log, k)):
                now.resting.slide_as(log.slides[k], log.begins[k])
                footing = Footing.of(now.resting, now.gaps)
            dense = Output(t, end - t, log.before[k].copy(), log.powers[k].copy())
            self._path.append(t, end, log.references[k].copy(), dense, footing)
            t = end
        return t

    def _log(self, points: int, most: int) -> Log:
        log = self._logs.get(points)
        if log is None:
            nq, nv = len(self._now.q), len(self._now.v)
            log = Log(
                np.zeros(MOST),
                np.zeros((MOST, nq)),
                np.zeros((MOST, 2 * nv)),
                np.zeros((MOST, 7, 2 * nv)),
                np.zeros((MOST, points, 3)),
                np.zeros((MOST, points), dtype=bool),
                np.zeros((3, 3 * points)),
            )
            self._logs[points] = log
        return log._replace(ends=log.ends[:most])


def _as_before(log: Log, k: int) -> bool:
    """Whether points did in a step what they did in the one before."""
    same = np.array_equal(log.slides[k], log.slides[k - 1])
    return same and np.array_equal(log.begins[k], log.begins[k - 1])
