"""The instant within a step at which geoms come to touch or a limit is reached."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from .listing import DEEPER, Listing, StepModels

__all__ = ["Event", "at_start", "find_instant"]

# A gap is closed where it is smaller than this [m, rad], and not below zero: there MuJoCo's soft
# contact would brake what parts.
CLOSED = 1e-11
# Newton's method closes a gap in three or four; bisection to the last bit needs fifty.
MOST_ROUNDS = 60


@dataclass(frozen=True)
class Event:
    """A contact or limit whose gap closes during a step.

    Attributes:
        pair: as ``Listing`` has it. position: (3,) by which it is told from others of its pair.
        gap, speed: when last looked at [m, m/s; rad, rad/s].
        index: in the listing of that look.
    """

    pair: tuple[int, int]
    position: np.ndarray
    gap: float
    speed: float
    index: int

    @classmethod
    def of(cls, listing: Listing, index: int) -> Event:
        """Return an entry of a listing."""
        first, second = listing.pairs[index].tolist()
        return cls(
            (first, second), listing.positions[index], float(listing.gaps[index]),
            float(listing.speeds[index]), int(index),
        )  # fmt: skip

    def again(self, listing: Listing) -> Event | None:
        """Return it as it is in another listing, None where it is not listed."""
        pairs = listing.pairs
        same = np.flatnonzero((pairs[:, 0] == self.pair[0]) & (pairs[:, 1] == self.pair[1]))
        if not len(same):
            return None
        apart = listing.positions[same] - self.position
        return Event.of(listing, same[int(np.argmin((apart * apart).sum(axis=1)))])


def _all_again(events: list[Event], listing: Listing) -> list[Event]:
    now = (event.again(listing) for event in events)
    return [event for event in now if event is not None]


def _reach(events: list[Event], duration: float) -> float:
    return DEEPER + 2.0 * duration * max(abs(event.speed) for event in events)


def find_instant(
    models: StepModels, data: Any, start: np.ndarray, kept: int,
    duration: float, events: list[Event],
) -> tuple[float, Listing, list[Event]]:  # fmt: skip
    """Bring ``data`` to the instant at which the first event closes, and look at it.

    Args:
        start: the state at the start of the step, of MuJoCo's kinds ``kept``.
        duration: of the step. events: as they are at its end.

    Returns:
        The time passed, what is listed then, and the events as they are then.
    """
    reach = _reach(events, duration)
    first = min(events, key=lambda event: _closing_time(event, duration, 0.0, duration))
    passed = _closing_time(first, duration, 0.0, duration)
    low, high = 0.0, duration
    for _ in range(MOST_ROUNDS):
        mujoco.mj_setState(models.plain, data, start, kept)
        models.fly(data, passed)
        listing = models.look(data, reach)
        now = first.again(listing)
        if now is None:  # farther away than the reach
            low, passed = passed, 0.5 * (passed + high)
            continue
        first = now
        if 0.0 <= first.gap <= CLOSED or high - low <= np.spacing(duration):
            deep = [event for event in _all_again(events, listing) if event.gap < -DEEPER]
            if not deep or passed == 0.0:
                break
            first, low, high = min(deep, key=lambda event: event.gap), 0.0, passed
        elif first.gap > CLOSED:
            low = passed
        else:
            high = passed
        passed = _closing_time(first, passed, low, high)
    return passed, listing, _all_again(events, listing)


def at_start(
    models: StepModels, data: Any, start: np.ndarray, kept: int,
    duration: float, events: list[Event],
) -> tuple[float, Listing, list[Event]]:  # fmt: skip
    """Do as ``find_instant``, with the start of the step in place of the instant."""
    mujoco.mj_setState(models.plain, data, start, kept)
    listing = models.look(data, _reach(events, duration))
    return 0.0, listing, _all_again(events, listing)


def _closing_time(event: Event, now: float, low: float, high: float) -> float:
    """When a gap closes by Newton's method, the middle of the bounds where that leads out."""
    if event.speed < 0.0:
        found = now - (event.gap - 0.5 * CLOSED) / event.speed
        if low <= found <= high:
            return found
    return 0.5 * (low + high)
