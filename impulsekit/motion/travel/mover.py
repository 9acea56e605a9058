"""What compiled code knows of what moves in a scene: its tree, its forces, the points that rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..dynamics.accelerations import Dynamics
from ..events.crossing import Crossing, Seen
from ..events.look import Watched, look
from ..forces.tables import Driven
from ..rest.settle import settle_points
from ..steps.compiled import SOLVED, begin_steps, rates_at
from ..steps.system import System, Work
from ..steps.tables import NO_POINTS, NOTHING_SLIDES, work_of
from ..tree.chart import Chart
from ..tree.of_model import room_of, tree_of
from .advance import until_closing

__all__ = ["Mover", "mover_of"]

NOTHING_SEEN = Seen(False, False)


class Mover:
    """The tables of a scene for compiled code: its tree, its forces, and the points that rest.

    Attributes:
        driven: forces that are functions of time.
    """

    def __init__(
        self, dynamics: Dynamics, system: System, driven: Driven, chart: Chart, together: float
    ) -> None:
        self._dynamics, self._system, self._chart = dynamics, system, chart
        self._together = together
        self._driven = np.zeros(driven.count)
        self.driven = driven
        # To look at steps that were made.
        self.room = work_of(len(system.load), driven.count)

    def now(self) -> System | None:
        """For the points that rest now; None where some are found anew at each state."""
        dynamics, chart = self._dynamics, self._chart
        resting, gaps = dynamics.resting, dynamics.gaps
        table, sliding = NO_POINTS, NOTHING_SLIDES
        if resting.contacts:
            found = None if gaps is None else gaps.table(resting.contacts)
            if found is None or not resting.is_compiled:
                return None
            table, sliding = found, resting.sliding()
        count, old = 3 * len(table.whole), self._system
        last = old.last
        if len(last) != count:
            last = np.zeros((3, count))
            old = old._replace(last=last[0], accelerations=last[1], slip=last[2])
        old.last[:] = resting.last_forces(len(table.whole)) if count else 0.0
        self._system = old._replace(table=table, sliding=sliding, reference=chart.reference)
        return self._system

    def look(
        self, work: Work, span: tuple[float, float], base: np.ndarray, resting: Sequence[int]
    ) -> Seen:
        """What may happen in the last step.

        Args:
            work: of the step. span: from when to when it goes [s].
            base: (m,) what counts as zero of each gap [m].
            resting: the indices of gaps that are closed and stay so.
        """
        gaps, rests = self._dynamics.gaps, self._dynamics.resting
        if gaps is None:
            return NOTHING_SEEN
        watched = np.ones(len(base), dtype=bool)
        watched[list(resting)] = False
        others = bool((watched & ~gaps.tabled).any())
        held = not gaps.are_rated(rests.contacts)
        if others and (held or not resting):
            return Seen(True, bool(resting))
        seen = np.where(watched, base, np.inf)[gaps.tabled]
        if others:
            seen[:] = np.inf
        system, asked = self._system, self.asked(seen)
        if held:
            system = system._replace(table=NO_POINTS)
        t, stops, bends = look(system, work, asked, span[0], span[1] - span[0])
        found = self.seen(asked, t, stops or held)
        return Seen(True, found.stops) if others else replace(found, bends=bends)

    def asked(self, base: np.ndarray) -> Watched:
        """What is looked for, of gaps (m,) of which ``base`` counts as zero [m]."""
        gaps = self._dynamics.gaps
        table = None if gaps is None else gaps.rated_table
        none = np.zeros(0)
        return Watched(
            NO_POINTS if table is None else table,
            base,
            none if gaps is None else gaps.arms,
            self._together,
            np.zeros(len(base), dtype=bool),
            np.zeros((0, len(self._system.load))) if gaps is None else gaps.turning.speeds,
            np.zeros((2, len(base))),
        )

    def flown(self, reference: np.ndarray) -> System:
        """What moved in a step that was made in a chart at ``reference`` (nq,); nothing rests."""
        return self._system._replace(table=NO_POINTS, sliding=NOTHING_SLIDES, reference=reference)

    def seen(self, watched: Watched, t: float, stops: bool) -> Seen:
        """What was found at a time [s], infinity for none, with what closes then."""
        gaps = self._dynamics.gaps
        if gaps is None or t == np.inf:
            return Seen(False, stops)
        return Seen(
            True, stops, Crossing(t, tuple(np.flatnonzero(gaps.tabled)[watched.met].tolist()))
        )

    def settle(
        self, t: float, q: np.ndarray, v: np.ndarray, *, fresh: bool, lay: bool
    ) -> tuple[np.ndarray, np.ndarray, bool] | None:
        """What rests is looked at, as by ``course.settling``; q and v then, and whether it changed.

        None where that is still to be done.
        """
        dynamics = self._dynamics
        gaps, resting = dynamics.gaps, dynamics.resting
        if gaps is None or not gaps.are_rated(resting.contacts):
            return None
        settle_points.load()
        if not settle_points.is_compiled:
            return None
        system = self.now()
        if system is None:
            return None
        self.driven.write(t, self._driven)
        q, v = q.copy(), v.copy()
        state, changed = settle_points(system, self._driven, q, v, fresh, lay)
        self.count(2)
        if state != SOLVED:
            return None
        resting.slip_as(system.sliding.ways)
        self.note()
        return q, v, changed

    def rates(self, t: float, y: np.ndarray) -> np.ndarray | None:
        """(2 nv,) ẏ at a time [s]; None where that is not known here."""
        rates_at.load()
        system = self.now() if rates_at.is_compiled else None
        if system is None:
            return None
        self.driven.write(t, self._driven)
        rates = np.empty(len(y))
        if rates_at(system, self._driven, y, rates) != SOLVED:
            return None
        self.count(1)
        self.note()
        return rates

    def begin(
        self, work: Work, y: np.ndarray, span: float, tolerances: tuple[float, float]
    ) -> float | None:
        """Write the rates of y as the first slope; a first step [s]. None where it can't."""
        begin_steps.load()
        if not (begin_steps.is_compiled and self.driven.is_constant):
            return None
        system = self.now()
        if system is None:
            return None
        state, length = begin_steps(system, work, np.ascontiguousarray(y), span, *tolerances)
        self.count(2 if span > 0.0 else 1)
        if state != SOLVED:
            return None
        return length

    def until_closing(
        self, y: np.ndarray, rates: np.ndarray, length: float, base: np.ndarray
    ) -> float:
        """How long a step may be, as compiled code tells; infinite until it is compiled.

        Args:
            y, rates: (2 nv,) where it begins. length: that it would have [s].
            base: (m,) what counts as zero of each gap [m]; infinite for those that rest.
        """
        until_closing.load()
        if not until_closing.is_compiled:
            return np.inf
        work = self.room
        work.before[:], work.slopes[0] = y, rates
        system = self._system._replace(reference=self._chart.reference)
        return until_closing(system, work, self.asked(base), length)

    def note(self) -> None:
        """Let what rests know the forces of the last evaluation."""
        system = self._system
        if len(system.last):
            found = system.last.copy(), system.accelerations.copy(), system.slip.copy()
            self._dynamics.resting.note(*found)

    def count(self, evaluations: int) -> None:
        """So many evaluations were made."""
        self._dynamics.evaluations += evaluations


def mover_of(dynamics: Dynamics, chart: Chart, together: float) -> Mover | None:
    """What compiled code knows of a scene; None where it does not know all that acts.

    ``together``: gaps that close this soon after the first close with it [s].
    """
    forces = dynamics.forces
    if dynamics.needs_rows or not forces.is_known:
        return None
    tree = tree_of(dynamics.model)
    if tree is None:
        return None
    model, none = dynamics.model, np.zeros((3, 0))
    system = System(
        tree,
        room_of(model),
        forces.loads,
        NO_POINTS,
        NOTHING_SLIDES,
        chart.reference,
        np.zeros(model.nq),
        np.zeros(model.nv),
        *none,
    )
    return Mover(dynamics, system, forces.driven, chart, together)
