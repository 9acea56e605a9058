"""The integrator at work: one step after another in a chart, kept as a path."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ...errors import ContradictionError
from ..course.present import Present, Stopped
from ..events.crossing import Seen
from ..record.path import Path
from ..record.status import MotionStatus
from ..rest.footing import Footing
from ..rest.law import RestNotSolved
from ..rest.slowing import until_stopping
from ..steps.explicit import GO_ON, ExplicitStepper, Output, inside
from ..steps.steppers import Dense, Stepper, stepper_of
from ..travel.advance import LONGEST_TURN
from ..travel.journey import NEAR, TRAVEL_EXACT
from ..travel.mover import mover_of
from ..travel.passage import Passage
from ..tree.chart import Chart
from ..zeros.roots import States
from .change_point import Step, find_leap, strays
from .stepper import CompiledStepper
from .strides import MOST, Stride, Strides
from .watching import ForceWatch

__all__ = ["Flight", "Step"]

# Steps that cannot be made are tried again with this part of their length, or of LONG [s].
SHORTER_STEP, LONG = 0.1, 1e-2
MOST_TRIES = 7
# So many of them, and one, by compiled code alone, which knows but one search for forces at rest.
QUICK_TRIES = 2
# Steps that leave the constraints within them are halved so often: to what is laid over by a leap.
MOST_HALVINGS = 10


class Flight:
    """Integrates y = (x, v), x in a chart around the present configuration.

    Attributes:
        path: what has been followed.
        steps: how many steps were made.
        strides: makes many steps at once, where that can be.
    """

    def __init__(self, present: Present) -> None:
        settings = present.settings
        self._present = present
        self._chart = Chart(present.model)
        self._watch = ForceWatch(present.dynamics.forces, settings)
        # The stretch from the last event to where a step has to end.
        self._since, self._until = 0.0, settings.duration
        self.path = Path(present.model)
        self.steps = 0
        self.strides: Strides | None = None
        self._stepper = self._made_stepper()

    def _made_stepper(self) -> Stepper:
        now, settings = self._present, self._present.settings
        if settings.method == "dop853":
            mover = mover_of(now.dynamics, self._chart, settings.together)
            now.mover = mover
            if mover is not None:
                tolerances = settings.rtol, settings.atol
                stepper = CompiledStepper(self._rates, *tolerances, mover, self._watch.within)
                self.strides = Strides(now, mover, self._chart, stepper, self.path)
                return stepper
        return stepper_of(settings.method, self._rates, settings.rtol, settings.atol, settings.step)

    def restart(self, first: float | None = None, *, jumps: bool = False) -> None:
        """Go on from the present state, as after an event.

        Steps that compiled code makes go on as long as they were about to be.

        Args:
            first: the length of the first step to try [s]; None to let the integrator choose.
            jumps: whether what acts has changed, so that nothing of the steps before is of use.
        """
        stepper = self._striding
        if stepper is not None and not jumps and stepper.before[0] > 0.0:
            first = GO_ON
        now = self._present
        self._since, self._until = now.t, self._watch.begin(now.t)
        y = self._centred()
        with now.told():
            try:
                self._stepper.reset(now.t, y, first, self._until)
            except (RestNotSolved, ContradictionError):
                if first is not None:
                    raise
                # It may be the state a first guess away that has no forces, past a stop of slip.
                self._stepper.reset(now.t, y, SHORTER_STEP * LONG, self._until)

    @property
    def _striding(self) -> CompiledStepper | None:
        """The stepper, where many steps may be made at once: those made singly are the same."""
        stepper, strides = self._stepper, self.strides
        known = strides is not None and strides.known
        return stepper if known and isinstance(stepper, CompiledStepper) else None

    def _bound(self) -> None:
        """Let the next step end where the next slip stops, or the next gap closes."""
        now, stepper = self._present, self._stepper
        if not isinstance(stepper, ExplicitStepper):
            return
        resting = now.resting
        ways = resting.sliding().ways
        stepper.soon = until_stopping(resting.slip, resting.accelerations, ways)
        striding = self._striding
        if striding is None or now.mover is None:
            return
        base = now.base.copy()
        base[[c.gap for c in resting.contacts]] = math.inf
        closing = now.mover.until_closing(stepper.y, stepper.f, stepper.length, base)
        stepper.soon = min(stepper.soon, closing)

    @property
    def is_at_stop(self) -> bool:
        """Whether the present time is one at which a step had to end."""
        return self._watch.is_stop(self._present.t)

    def drifted(self) -> None:
        """Go on from the present state, from which drift was taken out."""
        now, y = self._present, self._centred()
        with now.told():
            self._stepper.moved(y, self._rates(now.t, y))

    def _centred(self) -> np.ndarray:
        """(2 nv,) y of the present state, in a chart around it."""
        now = self._present
        return np.concatenate([self._chart.centred(now.q), now.v])

    def recentre(self) -> None:
        """Go on from the same state in a chart around it."""
        now, chart, stepper = self._present, self._chart, self._stepper
        if chart.is_flat:
            return
        rates, y, nv = stepper.f.copy(), self._centred(), len(now.v)
        rates[:nv] = chart.rate(y[:nv], now.q, now.v)
        stepper.moved(y, rates)

    def step(self) -> Step:
        """One step from the present state, which stays what it is.

        Raises:
            Stopped: there is none, or it ends at infinity.
        """
        now, chart, stepper = self._present, self._chart, self._stepper
        speed = chart.turning_speed(now.v)
        longest = math.inf if now.settings.max_step is None else now.settings.max_step
        if speed > 0.0:
            longest = min(longest, LONGEST_TURN / speed)
        self._bound()
        y, halvings = stepper.y.copy(), 0
        while True:
            with now.told():
                dense = self._tried(longest)
            if not np.isfinite(stepper.y).all():
                raise Stopped(MotionStatus.NOT_FINITE)

            states = self._states(dense)
            shorter = self._watch.shorter(now.t, stepper.t, states)
            if shorter is None and halvings < MOST_HALVINGS:
                if not strays(now, now.t, stepper.t, states):
                    break
                halvings, shorter = halvings + 1, 0.5 * (stepper.t - now.t)
            if shorter is None:
                break
            longest = shorter
            with now.told():
                stepper.reset(now.t, y, longest, self._until)
        self.steps += 1
        return Step(now.t, stepper.t, chart.reference, dense, states)

    def leap(self) -> Step | None:
        """The way past a change point at which no step is short enough; None where there is none.

        Steps that came too near to it are undone.
        """
        now, path = self._present, self.path
        leap = find_leap(now, path, self._since, self._until)
        if leap is None:
            return None
        kept, step = leap
        path.shorten(kept)
        now.t = step.start
        now.q, now.v = map(np.array, step.states(step.start))
        return step

    def stride(self, deepest: np.ndarray, most: float) -> tuple[Stride, Step | None] | None:
        """Many steps at once, and that in which something happens, which is not taken yet.

        None where they have to be made one by one.

        Args:
            deepest: (m,) how deep gaps may be.
            most: so many steps.
        """
        now, chart = self._present, self._chart
        if self.strides is None or not self.strides.can:
            return None
        count = int(min(most, now.settings.max_steps - self.steps, MOST))
        stride = self.strides.make(self._until, count, deepest)
        if stride is None:
            return None
        self.steps += stride.count
        if stride.last is None:
            return stride, None
        self.steps += 1
        dense, end = stride.last
        return stride, Step(now.t, end, chart.reference, dense, self._states(dense))

    def _tried(self, longest: float) -> Dense:
        """One step; a shorter one where a trial state within it has no forces.

        Such a state is one that the motion never comes to: there points slip that stick, or
        what is held is off, next to where its rows depend on each other.
        """
        stepper = self._stepper
        t, y = stepper.t, stepper.y.copy()
        if isinstance(stepper, CompiledStepper):
            stepper.is_patient = False
        with self._present.resting.unchanged():
            for tries in range(MOST_TRIES):
                try:
                    return stepper.step(longest)
                except (RestNotSolved, ContradictionError):
                    longest = SHORTER_STEP * min(longest, stepper.length, LONG)
                    stepper.reset(t, y, longest, self._until)
                    if tries == QUICK_TRIES and isinstance(stepper, CompiledStepper):
                        stepper.is_patient = True
            return stepper.step(longest)

    def look(self, step: Step, base: np.ndarray, resting: Sequence[int]) -> Seen:
        """What may happen in the last step.

        Args:
            step: the last one.
            base: (m,) what counts as zero of each gap [m].
            resting: the indices of gaps that are closed and stay so.
        """
        stepper = self._stepper
        if isinstance(stepper, CompiledStepper):
            return stepper.look(step.start, step.end, base, resting)
        return Seen(True, bool(resting))

    def passage(self, step: Step) -> Passage | None:
        """A step as compiled code sees it, where bodies with corners may collide; else None."""
        now, dense = self._present, step.dense
        if now.mover is None or now.gaps is None or not isinstance(dense, Output):
            return None
        pairs = now.gaps.pairs
        if not len(pairs.whole):
            return None
        return Passage(now.mover, now.gaps, pairs, step.reference, dense)

    def take(self, step: Step) -> None:
        """Go to the end of a step."""
        now, nv = self._present, self._present.model.nv
        self._keep(step, step.end)
        now.t = step.end
        now.q = np.array(self._chart.configuration(self._stepper.y[:nv]))
        now.v = self._stepper.y[nv:].copy()

    def closing(self, step: Step, time: float, gap: int) -> tuple[Step, float]:
        """A step up to where a gap closes, and when that is, to the accuracy of steps."""
        now, gaps = self._present, self._present.gaps
        if gaps is None or not gaps.rated[gap]:
            return step, time

        def off(t: float, states: States) -> tuple[float, float]:
            values, rates = gaps.measure(*states(t), (gap,))
            return float(values[gap] - now.base[gap]), float(rates[gap])

        return self.up_to(step, time, off)

    def up_to(
        self, step: Step, time: float, off: Callable[[float, States], tuple[float, float]]
    ) -> tuple[Step, float]:
        """A step up to where a function falls to zero, and when, to the accuracy of steps.

        Dense output, by which the time was found, is a hundred times less accurate. ``off``
        gives the function and its rate from a time and the states of a step.
        """
        now, stepper, dense = self._present, self._stepper, step.dense
        if not (isinstance(stepper, ExplicitStepper) and isinstance(dense, Output)):
            return step, time
        if not step.start < time < step.end:
            return step, time
        part = (time - dense.start) / dense.length
        if inside(stepper.before[1], part) < TRAVEL_EXACT:
            return step, time
        try:
            with now.resting.unchanged():
                dense = stepper.shortened(dense, time)
        except RestNotSolved:
            return step, time
        states = self._states(dense)
        left, rate = off(time, states)
        if not (rate < 0.0 and abs(left) <= NEAR * -rate * (time - step.start)):
            return step, time
        time -= left / rate
        return Step(step.start, time, step.reference, dense, states), time

    def _states(self, dense: Dense) -> States:
        chart, nv = self._chart, self._present.model.nv

        def states(t: float) -> tuple[np.ndarray, np.ndarray]:
            y = dense(t)
            return chart.configuration(y[:nv]), y[nv:]

        return states

    def take_until(self, step: Step, time: float) -> None:
        """Go to a time within a step; the integrator has to be told how to go on."""
        now = self._present
        if time > step.start:
            self._keep(step, time)
        now.t = time
        q, v = step.states(time)
        now.q, now.v = np.array(q), np.array(v)

    def _keep(self, step: Step, end: float) -> None:
        # What rested in the step still does, or only leaves off now.
        footing = Footing.of(self._present.resting, self._present.gaps)
        self.path.append(step.start, end, step.reference, step.dense, footing)

    def stand(self) -> None:
        """A piece of no length, for motions that end where they begin or in an impact."""
        now, y = self._present, self._centred()
        self.path.append(now.t, now.t, self._chart.reference, lambda _: y)

    def _rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """ẏ of y = (x, v)."""
        mover, within = self._present.mover, self._watch.within(t)
        found = None if mover is None else mover.rates(within, y)
        if found is not None:
            return found
        nv = self._present.model.nv
        x, v = y[:nv], y[nv:]
        q = self._chart.configuration(x)
        rates = np.empty(2 * nv)
        rates[:nv] = self._chart.rate(x, q, v)
        rates[nv:] = self._present.dynamics.acceleration(within, q, v)
        return rates
