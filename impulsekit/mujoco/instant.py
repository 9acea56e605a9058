"""The instant within a step at which geoms come to touch or a limit is reached."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .listing import DEEPER, Listing, StepModels

__all__ = ["TOUCHING", "Events", "find_instant"]

# A contact this far apart at the instant of an impact is a row of it [m].
TOUCHING = 1e-6
# A gap is closed where it is smaller than this [m, rad], and not below zero: there MuJoCo's soft
# contact would brake what parts.
CLOSED = 1e-11
# Newton's method closes a gap in three or four; bisection to the last bit needs fifty.
MOST_ROUNDS = 60


class Events(NamedTuple):
    """Contacts and limits whose gap closes during a step.

    Attributes:
        keys: (k,) of their pairs. positions: (k, 3) by which those of one pair are told apart.
        gaps, speeds: (k,) when last looked at [m, m/s; rad, rad/s]; a gap is infinite where
            it was out of reach.
        numbers: (k,) in the listing of that look.
    """

    keys: np.ndarray
    positions: np.ndarray
    gaps: np.ndarray
    speeds: np.ndarray
    numbers: np.ndarray

    def only(self, which: np.ndarray) -> Events:
        """Return some of them."""
        return Events(*(own[which] for own in self))

    def again(self, listing: Listing) -> Events:
        """Return them as they are in another listing: of each pair the nearest."""
        if not len(listing.keys):
            return self._replace(gaps=np.full(len(self.keys), np.inf))
        apart = self.positions[:, None] - listing.positions
        cost = (apart * apart).sum(axis=2)
        cost[self.keys[:, None] != listing.keys] = np.inf
        index = cost.argmin(axis=1)
        gaps, positions, speeds = (
            own[index] for own in (listing.gaps, listing.positions, listing.speeds)
        )
        absent = cost.min(axis=1) == np.inf
        if absent.any():
            gaps[absent] = np.inf
            positions[absent], speeds[absent] = self.positions[absent], self.speeds[absent]
        return Events(self.keys, positions, gaps, speeds, index)


def find_instant(
    models: StepModels, data: Any, start: np.ndarray,
    duration: float, events: Events, threshold: float, is_exact: bool,
) -> tuple[float, Listing, Events]:  # fmt: skip
    """Bring ``data`` to the instant of the first impact among events, and look at it.

    Args:
        start: the state at the start of the step, of the kinds ``KEPT``.
        duration: of the step. events: as they are at its end.
        threshold: approach speed above which what closes is an impact [m/s].
        is_exact: False for the start of the step in place of the instant.

    Returns:
        The time passed, what is listed then, and the events that hit then; none where all that
        closes does so slowly.
    """
    reach = DEEPER + 2.0 * duration * float(np.abs(events.speeds).max())
    models.restore(data, start)
    listing = models.look(data, reach)
    events = events.again(listing)
    if not is_exact:
        return 0.0, listing, events.only((events.gaps < np.inf) & (events.speeds < -threshold))
    # What touched from the start and approaches faster is hit at once.
    closed = events.gaps <= CLOSED
    passed = 0.0
    while (fast := events.only(closed & (events.speeds < -threshold))).keys.size == 0:
        events = events.only(~closed)
        if not len(events.keys):
            break
        passed, listing, events = _first_closing(
            models, data, start, passed, duration, events, reach, threshold
        )
        closed = events.gaps <= max(TOUCHING, float(events.gaps.min()))
    return passed, listing, fast


def _first_closing(
    models: StepModels, data: Any, start: np.ndarray,
    low: float, high: float, events: Events, reach: float, threshold: float,
) -> tuple[float, Listing, Events]:  # fmt: skip
    """The time at which the first of some open gaps closes, what is listed then, and the gaps."""
    passed, before, curve = low, low, np.zeros(len(events.keys))
    for _ in range(MOST_ROUNDS):
        passed = _closing_time(events, curve, passed, low, high)
        models.restore(data, start)
        models.fly(data, passed)
        listing = models.look(data, reach)
        speeds, events = events.speeds, events.again(listing)
        least = events.gaps.min()
        if 0.0 <= least <= CLOSED or high - low <= np.spacing(high):
            break
        # What touches slowly is no impact: its instant need not be known better.
        fast = (events.gaps <= TOUCHING) & (events.speeds < -threshold)
        if abs(least) <= TOUCHING and not fast.any():
            break
        low, high = (passed, high) if least > CLOSED else (low, passed)
        curve, before = (events.speeds - speeds) / (passed - before), passed
    return passed, listing, events


def _closing_time(events: Events, curve: np.ndarray, now: float, low: float, high: float) -> float:
    """When the first gap g + u t + a t²/2 closes, the middle where that leads out of bounds."""
    gaps, speeds = events.gaps - 0.5 * CLOSED, events.speeds
    closing = (speeds < 0.0) & np.isfinite(gaps)
    if closing.any():
        gaps, speeds, curve = gaps[closing], speeds[closing], curve[closing]
        root = np.sqrt(np.maximum(speeds * speeds - 2.0 * curve * gaps, 0.0))
        found = now + float((2.0 * gaps / (root - speeds)).min())
        if low < found < high:
            return found
    return 0.5 * (low + high)
