"""DOP853 whose whole step is one compiled call, where all that acts is known to compiled code.

What is not (constraints, forces by functions of the state, joints of other kinds, points found
anew at each state), and all steps until the code is compiled, go the way of ``explicit``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from ..laws.compiled import Entry
from ..scene import Scene
from .chart import Chart
from .compiled_look import Watched, look
from .compiled_model import NO_POINTS, NOTHING_SLIDES, tableau, work_of
from .compiled_step import NOT_SOLVED, UNSAFE, System, Work, attempt
from .crossing import Crossing, Seen
from .dynamics import Dynamics
from .explicit import ExplicitStepper, Output, Rhs
from .load_tables import Driven, loads_of
from .rest_law import RestNotSolved
from .tree_of_model import room_of, tree_of

__all__ = ["CompiledStepper", "Mover", "mover_of"]

NOTHING_SEEN = Seen(False, False)


class Mover:
    """What compiled code knows of a scene: its tree, its forces, and the points that rest."""

    def __init__(
        self, dynamics: Dynamics, system: System, driven: Driven, chart: Chart, together: float
    ) -> None:
        self._dynamics, self._system, self._chart = dynamics, system, chart
        self._together = together
        self._no_ways, self._no_begins = np.zeros((0, 3)), np.zeros(0, dtype=bool)
        self.driven = driven

    def now(self) -> System | None:
        """For the points that rest now; None where some are found anew at each state."""
        dynamics, chart = self._dynamics, self._chart
        resting, gaps = dynamics.resting, dynamics.gaps
        table, sliding = NO_POINTS, NOTHING_SLIDES
        if resting.contacts:
            found = None if gaps is None else gaps.table(resting.contacts)
            if found is None:
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
        system, ways, begins = self._system, self._no_ways, self._no_begins
        if held:
            system = system._replace(table=NO_POINTS)
        elif resting:
            slides, begins = rests.slides(), np.array(rests.begins(), dtype=bool)
            ways = np.zeros((len(slides), 3))
            for way, start in zip(ways, slides, strict=True):
                if start is not None:
                    way[0], way[1], way[2] = start[0], start[1], 1.0
        table, met = gaps.rated_table, np.zeros(len(seen), dtype=bool)
        asked = Watched(
            NO_POINTS if table is None else table,
            seen,
            gaps.arms,
            self._together,
            met,
            gaps.turning.speeds,
            ways,
            begins,
            rests.grown,
        )
        t, stops = look(system, work, asked, span[0], span[1] - span[0])
        stops = stops or held
        if others:
            return Seen(True, stops)
        if t == np.inf:
            return Seen(False, stops)
        found = tuple(np.flatnonzero(gaps.tabled)[met].tolist())
        return Seen(True, stops, Crossing(t, found))

    def note(self) -> None:
        """Let what rests know the forces of the last evaluation."""
        system = self._system
        if len(system.last):
            found = system.last.copy(), system.accelerations.copy(), system.slip.copy()
            self._dynamics.resting.note(*found)

    def count(self, evaluations: int) -> None:
        """So many evaluations were made."""
        self._dynamics.evaluations += evaluations


def mover_of(scene: Scene, dynamics: Dynamics, chart: Chart, together: float) -> Mover | None:
    """What compiled code knows of a scene; None where it does not know all that acts.

    ``together``: gaps that close this soon after the first close with it [s].
    """
    if dynamics.needs_rows:
        return None
    found, tree = loads_of(scene), tree_of(dynamics.model)
    if found is None or tree is None:
        return None
    loads, driven = found
    model, none = dynamics.model, np.zeros((3, 0))
    system = System(
        tree,
        room_of(model),
        loads,
        NO_POINTS,
        NOTHING_SLIDES,
        chart.reference,
        np.zeros(model.nq),
        np.zeros(model.nv),
        *none,
    )
    return Mover(dynamics, system, driven, chart, together)


class CompiledStepper(ExplicitStepper):
    """Steps of DOP853, each in one compiled call where it can be.

    Args:
        rhs, rtol, atol: as for ``ExplicitStepper``.
        mover: what moves.
        within: the time at which forces are evaluated, for a time of the integrator.
    """

    code: Entry = attempt

    def __init__(
        self,
        rhs: Rhs,
        rtol: float,
        atol: float,
        mover: Mover,
        within: Callable[[float], float],
    ) -> None:
        super().__init__(rhs, rtol, atol)
        self._mover, self._within = mover, within
        self._work = work_of(0, 0)
        self._is_compiled = False
        self.code.load()
        look.load()

    def reset(self, t: float, y: np.ndarray, first: float | None, end: float) -> None:
        """Go on from elsewhere."""
        if self._work.slopes.shape[1] != len(y):
            driven = self._mover.driven
            self._work = work_of(len(y) // 2, driven.count)
            for row in self._work.driven if driven.is_constant else ():
                driven.write(0.0, row)
        super().reset(t, y, first, end)
        self._slopes = self._work.slopes

    def _try(self, t: float, h: float, y: np.ndarray) -> tuple[np.ndarray, float]:
        system = self._mover.now() if self.code.is_compiled else None
        self._is_compiled = system is not None
        if system is None:
            begin = time.perf_counter()
            found = super()._try(t, h, y)
            spent = time.perf_counter() - begin
            self.code.wait(spent)
            look.wait(spent)
            return found
        work, driven = self._work, self._mover.driven
        work.before[:] = y
        if not driven.is_constant:
            for s, c in enumerate(tableau().times.tolist()):
                driven.write(self._within(t + c * h), work.driven[s])
        state, error = self.code(system, tableau(), work, h, self._rtol, self._atol)
        self._mover.count(len(work.slopes) - 1 if error < 1.0 else self._count)
        if state == NOT_SOLVED:
            raise RestNotSolved("no forces at a stage of a step")
        if state == UNSAFE:
            self._is_compiled = False
            return super()._try(t, h, y)
        self._mover.note()
        return work.after.copy(), error

    def look(self, start: float, end: float, base: np.ndarray, resting: Sequence[int]) -> Seen:
        """What may happen in the last step, which goes from start to end [s]."""
        if not (self._is_compiled and look.is_compiled):
            return Seen(True, bool(resting))
        return self._mover.look(self._work, (start, end), base, resting)

    def _output(self, t: float, h: float, y: np.ndarray, after: np.ndarray) -> Output:
        if not self._is_compiled:
            return super()._output(t, h, y, after)
        return Output(t, h, y, self._work.powers.copy())
