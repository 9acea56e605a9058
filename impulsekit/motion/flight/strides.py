"""Many steps of a motion in one compiled call, until something happens."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..course.meetings import hold_of, ledger_of
from ..course.present import Present
from ..events.crossing import Seen
from ..record.path import Path
from ..steps.explicit import Output, tableau
from ..steps.tables import NO_POINTS
from ..travel.advance import HAPPENS, Log, Track, until_closing
from ..travel.journey import Trip, travel
from ..travel.mover import Mover
from ..tree.chart import Chart
from .stepper import CompiledStepper
from .stretch import Stretch

__all__ = ["MOST", "Stride", "Strides"]

# So many steps are made at once at most.
MOST = 64


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

    Attributes:
        known: whether compiled code may make many steps of this motion.
    """

    def __init__(
        self, now: Present, mover: Mover, chart: Chart, stepper: CompiledStepper, path: Path
    ) -> None:
        self._now, self._mover, self._chart = now, mover, chart
        self._stepper, self._path = stepper, path
        self._log, self._ledger = self._made_log(), ledger_of(now, MOST)
        self._turning = chart.turning.astype(float)
        gaps = now.gaps
        self.known = mover.driven.is_constant and (gaps is None or bool(gaps.tabled.all()))
        travel.load()

    @property
    def can(self) -> bool:
        """Whether there is compiled code for what moves now."""
        return self.known and travel.is_compiled and not self._now.passing

    def wait(self, seconds: float) -> None:
        """Steps took so long in another way [s]."""
        if self.known:
            travel.wait(seconds)
            if travel.is_compiled:
                # Steps made singly are to be those that are made at once.
                until_closing.compile()

    def make(self, until: float, most: int, deepest: np.ndarray) -> Stride | None:
        """Steps from the present state to a time [s], ``most`` or fewer; None if there are none.

        ``deepest``: (m,) how deep gaps may be.
        """
        now, stepper, mover = self._now, self._stepper, self._mover
        found = mover.now()
        if found is None:
            return None
        log, work, hold = self._log._replace(ends=self._log.ends[:most]), stepper.work, hold_of(now)
        system = found._replace(
            reference=self._chart.reference.copy(), sliding=now.resting.sliding()
        )
        ledger = self._ledger
        track, watched = self._track(until, deepest), mover.asked(now.base.copy())
        trip = Trip(
            tableau(), work, watched, track, log, hold, ledger, *stepper.tolerances
        )  # fmt: skip
        work.before[:], work.slopes[0] = stepper.y, stepper.f
        why, count, made, stops = travel(system, trip)
        mover.count(made)
        if count:
            stretch = Stretch(log, ledger, count, now.gaps, now.resting)
            self._path.extend(log.starts[:count].tolist(), stretch.piece)
        n = int(hold.number[0])
        now.resting.slip_as(hold.ways[:n])
        if count:
            if n:
                now.resting.note(*log.rest[:, : 3 * n].copy())
            now.t = float(track.clock[0])
            now.q, now.v = track.q, track.v
            self._chart.reference = system.reference
            stepper.go_on(now.t, work.before.copy(), work.slopes[0].copy(), track.clock)
        if why != HAPPENS:
            return Stride(why, count)
        end = float(log.ends[count])
        start, length = float(log.starts[count]), float(log.lengths[count])
        last = Output(start, length, log.before[count].copy(), log.powers[count].copy())
        after = work.slopes[len(tableau().result)].copy()
        stepper.go_on(end, work.after.copy(), after, track.clock)
        seen = mover.seen(watched, float(track.clock[4]), stops)
        return Stride(why, count, seen, (last, end))

    def _track(self, until: float, deepest: np.ndarray) -> Track:
        """Where the motion is, and how far it may go."""
        now, stepper = self._now, self._stepper
        longest = math.inf if now.settings.max_step is None else now.settings.max_step
        clock = np.array([now.t, stepper.length, until, longest, math.inf, *stepper.before])
        table = None if now.gaps is None else now.gaps.rated_table
        all_gaps = NO_POINTS if table is None else table
        return Track(now.q.copy(), now.v.copy(), clock, self._turning, all_gaps, deepest)

    def _made_log(self) -> Log:
        m, nq, nv = len(self._now.base), len(self._now.q), len(self._now.v)
        return Log(
            np.zeros(MOST),
            np.zeros(MOST),
            np.zeros(MOST),
            np.zeros((MOST, nq)),
            np.zeros((MOST, 2 * nv)),
            np.zeros((MOST, 7, 2 * nv)),
            np.zeros((MOST, m, 3)),
            np.zeros((3, 3 * m)),
        )
