"""One motion from start to end: steps, cut at the events within them.

begin ─► step ─► event? ─► impact (striking), or slip stops ─► what rests (settling) ─► step
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable

import numpy as np

from ..scene import Scene
from ..scene.functions import call
from ..scene.motion import MotionSettings
from .course.beginning import begin
from .course.hops import Hop, find_hops, low_hops
from .course.penetration import Penetration
from .course.present import Mark, Present, Stopped
from .course.settling import come_to_rest, heed_stop, keep_up, settle
from .course.striking import Striking
from .events.crossing import Seen, first_crossing
from .events.kinks import Kink
from .events.stops import first_stop
from .flight.flight import Flight, Step
from .flight.headway import Headway
from .interrupts import Interrupts
from .record.status import MotionStatus
from .record.trajectory import Trajectory
from .travel.advance import CHANGED, STUCK
from .warm import load_shared

__all__ = ["Run"]

# Most points that jam one after the other at one time.
MOST_JAMS = 8
# How a motion comes to a jam: no forces, or ever larger ones.
JAMS = (MotionStatus.REST_NOT_SOLVED, MotionStatus.STEP_TOO_SMALL)
# A point that comes down faster than this [m/s] beside others that rest is met, not laid down.
LANDS = 1e-5


class Run:
    """A motion while it is worked out."""

    def __init__(
        self,
        scene: Scene,
        q: np.ndarray,
        v: np.ndarray,
        settings: MotionSettings,
        progress: Callable[[float], None] | None,
    ) -> None:
        self._settings, self._progress = settings, progress
        self._interrupts = Interrupts()
        # Loading compiled code takes its time, and what is raised within it may be dropped.
        with self._interrupts:
            if scene.contacts:
                load_shared()
            self._now = Present(scene, q, v, settings)
            self._striking = Striking(self._now)
            self._flight = Flight(self._now)
        # Before the last step: the state, and of how many pieces the path was.
        self._last: tuple[Mark, int] = self._now.mark(), 0

    def trajectory(self, times: np.ndarray) -> Trajectory:
        """The motion, sampled at ``times``."""
        settings, now, flight = self._settings, self._now, self._flight
        status, detail = MotionStatus.FINISHED, ""
        penetration = Penetration(now)
        try:
            with self._interrupts:
                self._interrupts.heed()
                self._unless_jammed(lambda: begin(now, self._striking))
                self._follow(penetration)
        except Stopped as stop:
            status, detail = stop.status, stop.detail
        except KeyboardInterrupt:
            # Whatever it broke off in: back to where all was in order.
            self._go_back()
            status = MotionStatus.INTERRUPTED
        if not len(flight.path) or (now.impacts and now.impacts[-1][0] == now.t):
            # Just after the last impact: no step has begun there.
            flight.stand()
        if now.t < settings.duration:
            times = np.append(times[times < now.t], now.t)
        rests = [*now.rests, *(now.rest(c, math.inf) for c in now.resting.contacts)]
        return Trajectory(
            now.scene,
            times,
            flight.path,
            tuple(now.impacts),
            tuple(sorted(rests, key=lambda rest: rest.start)),
            status,
            settings,
            detail=detail,
            steps=flight.steps,
            evaluations=now.dynamics.evaluations,
        )

    def _follow(self, penetration: Penetration) -> None:
        """From the start to the end of the duration."""
        settings, now = self._settings, self._now
        if now.t >= settings.duration:
            return
        penetration.refuse()
        self._flight.restart()
        headway = Headway(now, self._flight)
        while now.t < settings.duration:
            self._last = now.mark(), len(self._flight.path)
            self._interrupts.heed()
            self._unless_jammed(lambda: self._go_on(penetration.deepest))
            try:
                penetration.refuse()
            except Stopped:
                # The step is not kept: what it led to cannot be true.
                self._go_back()
                raise
            self._unless_jammed(headway.check)
            if self._progress is not None:
                call(self._progress, "progress", now.t)
        self._last = now.mark(), len(self._flight.path)
        self._interrupts.heed()

    def _go_back(self) -> None:
        """Let the last step be undone."""
        mark, pieces = self._last
        self._now.go_back(mark)
        self._flight.path.shorten(pieces)

    def _unless_jammed(self, proceed: Callable[[], None]) -> None:
        """Proceed; where no forces hold what rests for friction jams it, it is struck instead.

        Forces that grow without bound, as steps get shorter without end, are on their way there.
        """
        now = self._now
        try:
            proceed()
        except Stopped as stop:
            if stop.status not in JAMS:
                raise
            for _ in range(MOST_JAMS):
                taking_part = [c.gap for c in now.resting.contacts]
                self._refuse_storm()
                if not self._striking.without_collision():
                    raise
                try:
                    come_to_rest(now, taking_part)
                    # What begins to slide by now may jam as well.
                    self._flight.restart()
                except Stopped as jammed:
                    # The one that has stopped may let another jam.
                    stop = jammed
                    if stop.status not in JAMS:
                        raise
                    continue
                return
            raise stop from None

    def _go_on(self, deepest: np.ndarray) -> None:
        """Make steps until something happens, many at once where that can be."""
        flight = self._flight
        found = flight.stride(deepest, math.inf if self._progress is None else 1)
        if found is None:
            begin = time.thread_time()
            self._step()
            if flight.strides is not None:
                flight.strides.wait(time.thread_time() - begin)
            return
        stride, step = found
        self._last = self._now.mark(), len(flight.path)
        if step is not None:
            if not self._happens(step, stride.seen):
                self._take(step)
        elif stride.why == STUCK:
            self._step()
        elif self._now.t < self._settings.duration and (flight.is_at_stop or stride.why == CHANGED):
            flight.restart(jumps=flight.is_at_stop)

    def _step(self) -> None:
        """Make a step, up to what happens first in it."""
        try:
            step = self._flight.step()
        except Stopped as stop:
            self._leap(stop)
            return
        if self._happens(step, self._flight.look(step, self._now.base, self._resting())):
            return
        try:
            self._take(step)
        except Stopped as stop:
            self._leap(stop)

    def _leap(self, stop: Stopped) -> None:
        """Go past a change point of what is held.

        Raises:
            Stopped: none is near; as ``stop``.
        """
        now, flight = self._now, self._flight
        stuck = stop.status in (MotionStatus.CONTRADICTION, MotionStatus.STEP_TOO_SMALL)
        if not stuck or now.held is None or now.resting.acts:
            raise stop
        step = flight.leap()
        if step is None:
            raise stop
        self._last = now.mark(), len(flight.path)
        if not self._happens(step, Seen(closes=True, stops=False)):
            flight.take_until(step, step.end)
            keep_up(now)
            flight.restart()

    def _resting(self) -> list[int]:
        return [c.gap for c in self._now.resting.contacts]

    def _take(self, step: Step) -> None:
        """Go to the end of a step in which nothing has happened."""
        now, flight = self._now, self._flight
        flight.take(step)
        if flight.is_at_stop:
            # What acts may jump here: nothing of the step before is of use.
            keep_up(now)
            flight.restart(jumps=True)
        elif now.resting.acts:
            landed = self._landed()
            if landed:
                self._meet(landed)
            elif keep_up(now):
                flight.restart()
            else:
                flight.drifted()
        elif now.held is not None:
            keep_up(now)
            flight.drifted()
        else:
            flight.recentre()

    def _happens(self, step: Step, seen: Seen) -> bool:
        """Cut the step at its first event, if it has one, and deal with that."""
        now, gaps = self._now, self._now.gaps
        resting, kinks = self._resting(), now.kinks
        closes, stops = seen.closes or bool(now.passing), seen.stops
        if gaps is None:
            return seen.bends and self._bends(step, kinks.first(step.states, step.start, step.end))
        if not (closes or stops or (kinks and seen.bends)):
            return False
        crossing = None if now.passing else seen.crossing
        passage = self._flight.passage(step)
        if closes and crossing is None:
            crossing = first_crossing(
                gaps,
                step.states,
                step.start,
                step.end,
                now.base,
                resting,
                self._settings.together,
                now.passing,
                passage,
            )
        until = step.end if crossing is None else crossing.t
        kink = kinks.first(step.states, step.start, until) if seen.bends else None
        if kink is not None and kink.t < until:
            until, crossing = kink.t, None
        stop = None
        if stops and resting and until > step.start:
            stop = first_stop(
                gaps,
                now.resting,
                step.states,
                step.start,
                until,
                lambda t: now.pushing(t, *step.states(t)),
                lambda t: now.left_to_tear(t, *step.states(t)),
                passage,
            )
        if stop is not None:
            when, elsewhere = stop
            self._flight.take_until(step, when)
            if elsewhere:
                gaps.hold([], now.q)
                if self._lies_down(resting):
                    come_to_rest(now, resting)
                    self._flight.restart()
                else:
                    self._meet(tuple(resting))
            else:
                heed_stop(now)
                settle(now)
                self._flight.restart()
        elif crossing is not None:
            self._flight.take_until(*self._flight.closing(step, crossing.t, crossing.gaps[0]))
            met = crossing.gaps
            if gaps.has_conditions:
                met = now.let_pass(met)
            if met:
                self._meet(met)
            else:
                self._flight.restart()
        else:
            return self._bends(step, kink)
        return True

    def _bends(self, step: Step, kink: Kink | None) -> bool:
        """End the step where a force changes its law; whether one does."""
        if kink is None:
            return False
        now, flight = self._now, self._flight
        flight.take_until(*flight.up_to(step, kink.t, kink.off))
        kink.switch()
        keep_up(now)
        flight.restart(jumps=True)
        return True

    def _meet(self, closing: tuple[int, ...]) -> None:
        """An impact of what closes, with all that rests taking part."""
        now, hops = self._now, list[Hop]()
        self._refuse_storm()
        if now.gaps is not None and self._only_wavers(closing):
            for i in closing:
                now.base[i] -= now.gaps.items[i].waver
        else:
            taking_part = sorted({*closing, *(c.gap for c in now.resting.contacts)})
            self._striking.on_the_way(closing, taking_part)
            come_to_rest(now, taking_part)
            hops = find_hops(now, taking_part)
            low = low_hops(now, hops)
            if low:
                come_to_rest(now, [*(c.gap for c in now.resting.contacts), *low], low)
                hops = find_hops(now, taking_part)
        self._flight.restart(min((hop.duration for hop in hops), default=None))

    def _refuse_storm(self) -> None:
        now, most = self._now, self._settings.max_impacts
        if len(now.impacts) < most:
            return
        detail, gaps, names = f"max_impacts is {most}", now.gaps, now.scene.entry_names("contacts")
        near = [] if gaps is None else [item for item in gaps.items if not item.exact]
        if gaps is not None and near:
            detail += (
                f"; the distance of {names[near[0].entry]} is found by iteration, to 1e-7 "
                "m only (ellipsoids on other than planes, rounded boxes, hulls of very many "
                "corners), so that low bounces may never end: use other shapes, or Contacts at "
                "points"
            )
        raise Stopped(MotionStatus.EVENT_STORM, detail)

    def _landed(self) -> tuple[int, ...]:
        """Resting gaps whose points are found anew, of which one more has just come down."""
        now, gaps = self._now, self._now.gaps
        if gaps is None:
            return ()
        return tuple(
            c.gap
            for c in now.resting.contacts
            if not gaps.rated[c.gap]
            and gaps.items[c.gap].held is None
            and now.closing(c.gap) < -LANDS
        )

    def _lies_down(self, resting: Iterable[int]) -> bool:
        """Whether bodies that touch elsewhere than before do so without a blow."""
        now, gaps = self._now, self._now.gaps
        if gaps is None:
            return True
        return all(now.closing(i) >= -now.slow for i in resting if not gaps.rated[i])

    def _only_wavers(self, closing: Iterable[int]) -> bool:
        """Whether nothing meets: distances waver where bodies have just parted."""
        gaps = self._now.gaps
        if gaps is None or any(gaps.rated[i] for i in closing):
            return False
        return all(self._now.closing(i) >= 0.0 for i in closing)
