"""Whether a motion gets on: steps and events that lead nowhere end it, with a reason."""

from __future__ import annotations

import numpy as np

from ..course.present import Present, Stopped
from ..record.status import MotionStatus
from .flight import Flight

__all__ = ["Headway"]

# So many events without any time between them never end.
MOST_STILL = 1000
# So many steps that together take less than this part of the time before them get nowhere.
MANY, NOWHERE = 200, 1e-10
# Steps that go further than this [m, rad] are short because speeds are high, which only falling
# speeds change: where the rest of the motion would take this many times ``max_steps``, they would
# have to fall to a hundredth.
FAR_AHEAD, HOPELESS = 1e-2, 100.0
# Slip [m/s] whose direction friction turns within some 1e-4 s.
SLOW_HEADWAY = 1e-3


class Headway:
    """Looks after each step of a motion whether it gets on."""

    def __init__(self, now: Present, flight: Flight) -> None:
        self._now, self._flight = now, flight
        self._still, self._steps = 0, 0
        # When events, and steps, were last looked at [s].
        self._t, self._since = now.t, 0.0

    def check(self) -> None:
        """Look at what the last step has led to.

        Raises:
            Stopped: there were too many steps, they get shorter and shorter, or events follow each
                other at one time.
        """
        now, steps = self._now, self._flight.steps
        self._still = self._still + 1 if now.t == self._t else 0
        self._t = now.t
        if self._still == MOST_STILL:
            self._still = 0
            raise Stopped(MotionStatus.STEP_TOO_SMALL, "events follow each other at one time")
        if now.t >= now.settings.duration:
            return
        if steps >= now.settings.max_steps:
            raise Stopped(MotionStatus.TOO_MANY_STEPS, self._why_many())
        made = steps - self._steps
        if made < MANY:
            return
        took, since = now.t - self._since, self._since
        self._steps, self._since = steps, now.t
        speed = float(np.abs(now.v).max(initial=0.0))
        if took <= NOWHERE * since:
            raise Stopped(
                MotionStatus.STEP_TOO_SMALL,
                f"{made} steps took {took:.1e} s, and speeds are up to {speed:.1e}: "
                "a linkage that is driven into a dead centre, or a force without bound",
            )
        self._refuse_hopeless(speed, took / made)

    def _refuse_hopeless(self, speed: float, step: float) -> None:
        """Stop where speeds [m/s, rad/s] need steps [s] too short to reach the end."""
        settings, left = self._now.settings, self._now.settings.duration - self._now.t
        if speed * step < FAR_AHEAD or left < HOPELESS * settings.max_steps * step:
            return
        raise Stopped(
            MotionStatus.TOO_MANY_STEPS,
            f"at speeds of up to {speed:.1e} (m/s, rad/s) a step takes {step:.1e} s: the "
            f"{left:.3g} s left would take {left / step:.1e} steps, max_steps is "
            f"{settings.max_steps}. Look at the units of the velocities, or shorten the duration",
        )

    def _why_many(self) -> str:
        """What to say of a motion that needs too many steps."""
        settings, slip = self._now.settings, self._now.resting.slowest_slide()
        told = f"max_steps is {settings.max_steps}"
        if slip < SLOW_HEADWAY and settings.method == "dop853":
            told += (
                f"; a point slides at {slip:.1e} m/s: friction turns so slow a slip too fast for "
                'long steps, but for those of method="radau"'
            )
        return told
