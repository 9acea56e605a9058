"""DOP853 whose whole step is one compiled call, where all that acts is known to compiled code.

What is not (constraints, forces by functions of the state, joints of other kinds, points found
anew at each state), and all steps until the code is compiled, go the way of ``steps.explicit``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from ...laws.compiled import Entry
from ..events.crossing import Seen
from ..events.look import look
from ..rest.law import RestNotSolved
from ..steps.compiled import NOT_SOLVED, UNSAFE, attempt
from ..steps.explicit import GO_ON, ExplicitStepper, Output, Rhs, tableau
from ..steps.tables import work_of
from ..travel.mover import Mover

__all__ = ["CompiledStepper"]


class CompiledStepper(ExplicitStepper):
    """Steps of DOP853, each in one compiled call where it can be.

    Args:
        rhs, rtol, atol: as for ``ExplicitStepper``.
        mover: what moves.
        within: the time at which forces are evaluated, for a time of the integrator.

    Attributes:
        work: the last step. tolerances: relative and absolute.
        is_patient: whether a step whose forces at rest compiled code does not find is made stage
            by stage, where another search is at hand.
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
        self.tolerances = rtol, atol
        self._mover, self._within = mover, within
        self.work = work_of(0, 0)
        self._is_compiled = False
        self.is_patient = False

    def go_on(self, t: float, y: np.ndarray, f: np.ndarray, clock: np.ndarray) -> None:
        """Go on after steps that were made elsewhere; ``clock`` of ``Track``."""
        self.t, self.y, self.f, self.length = t, y, f, float(clock[1])
        self.before = float(clock[5]), float(clock[6])

    def reset(self, t: float, y: np.ndarray, first: float | None, end: float) -> None:
        """Go on from elsewhere."""
        if self.work.slopes.shape[1] != len(y):
            driven = self._mover.driven
            self.work = work_of(len(y) // 2, driven.count)
            for row in self.work.driven if driven.is_constant else ():
                driven.write(0.0, row)
        span, goes_on = end - t, first == GO_ON
        length = None
        if span > 0.0:
            asked = 0.0 if goes_on else span
            length = self._mover.begin(self.work, y, asked, self.tolerances)
        if length is None:
            super().reset(t, y, first, end)
        else:
            self.t, self.y, self._end = t, y, end
            self.before = 0.0, 0.0
            self.f = self.work.slopes[0].copy()
            if not goes_on:
                given = 0.0 if first is None else min(first, span)
                self.length = given if given > 0.0 else length
        self._slopes = self.work.slopes

    def _try(self, t: float, h: float, y: np.ndarray) -> tuple[np.ndarray, float]:
        self.code.load()
        look.load()
        system = self._mover.now() if self.code.is_compiled else None
        self._is_compiled = system is not None
        if system is None:
            begin = time.thread_time()
            found = super()._try(t, h, y)
            spent = time.thread_time() - begin
            self.code.wait(spent)
            look.wait(spent)
            return found
        work, driven = self.work, self._mover.driven
        work.before[:] = y
        if not driven.is_constant:
            times = tableau().times.tolist()
            # The first stage's rates are there; two stages look at the end of the step.
            for s in range(1, len(times)):
                if times[s] == times[s - 1]:
                    work.driven[s] = work.driven[s - 1]
                else:
                    driven.write(self._within(t + times[s] * h), work.driven[s])
        state, error = self.code(system, tableau(), work, h, *self.tolerances)
        self._mover.count(len(work.slopes) - 1 if error < 1.0 else self._count)
        if state == NOT_SOLVED and not self.is_patient:
            raise RestNotSolved("no forces at a stage of a step")
        if state in (NOT_SOLVED, UNSAFE):
            self._is_compiled = False
            return super()._try(t, h, y)
        self._mover.note()
        return work.after.copy(), error

    def look(self, start: float, end: float, base: np.ndarray, resting: Sequence[int]) -> Seen:
        """What may happen in the last step, which goes from start to end [s]."""
        if not (self._is_compiled and look.is_compiled):
            return Seen(True, bool(resting))
        return self._mover.look(self.work, (start, end), base, resting)

    def _output(self, t: float, h: float, y: np.ndarray, after: np.ndarray) -> Output:
        if not self._is_compiled:
            return super()._output(t, h, y, after)
        return Output(t, h, y, self.work.powers.copy())
