"""Sweeps of flights: thin, fast and turning bodies meet when they do, and none is missed.

Every flight is held against the exact motion (``flown``). Its error is one of time [s].
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.truths.flown import first_meeting
from impulsekit.motion import simulate

from .flight_scenes import (
    NEAR,
    Flight,
    blade,
    buffer,
    bullet,
    graze,
    meeting,
    stop,
    tip,
    turning_plane,
)  # fmt: skip
from .sweep import Point, Sweep, decades, seen

# Times of meeting are right to this [s], and gaps to this [m].
RIGHT, GAP = 1e-9, 2e-12
# Of a motion: its own error, over thousands of radians, is to stay below that of the search.
RTOL, ATOL = 1e-12, 1e-14
# Speeds that divide are at least these [m/s].
SLOWEST, GRAZING = 1e-6, 1e-12


def judged(flight: Flight, stretch: float) -> tuple[str, str, float, float] | None:
    """Status, verdict, error in time [s] and seconds taken; None where grazing leaves it open.

    Args:
        stretch: the motion is followed so many times longer than until bodies meet.
    """
    meets = flight.meets
    if meets is None:
        meets = first_meeting(flight.gap, flight.fastest, flight.duration)
        if meets is None:
            return None
    duration = flight.duration if math.isinf(meets) else stretch * meets
    start = time.perf_counter()
    motion = simulate(
        flight.scene,
        flight.q,
        flight.v,
        duration=duration,
        samples=2,
        max_impacts=1,
        rtol=RTOL,
        atol=ATOL,
    )
    seconds = time.perf_counter() - start
    found = motion.impacts[0][0] if motion.impacts else math.inf
    if found == meets:
        return motion.status.name, "right", 0.0, seconds
    if math.isinf(found) and not motion.status.finished:
        return motion.status.name, "said so", math.nan, seconds
    error = abs(found - meets)
    allowed = RIGHT
    if math.isfinite(meets):
        # The speed at which the gap closes is taken over this way.
        step = NEAR / max(flight.fastest, SLOWEST)
        closing = (flight.gap(meets - step) - flight.gap(meets)) / step
        allowed += GAP / max(closing, GRAZING)
    return motion.status.name, "right" if error <= allowed else "wrong", error, seconds


def _points(kind: Callable[[float, np.random.Generator], Flight]) -> Any:
    def points(value: float, rng: np.random.Generator) -> list[Point]:
        for _ in range(20):
            judgement = judged(kind(value, rng), float(rng.uniform(1.05, 2.0)))
            if judgement is not None:
                break
        else:
            return []
        status, verdict, error, seconds = judgement
        return [seen(0, "simulate", status, verdict, seconds, error=error)]

    points.__doc__ = kind.__doc__
    return points


THICK = decades(-4, -1)
SWEEPS = (
    Sweep("buffers", "distance [m]", decades(-1, 3), _points(buffer), 200),
    Sweep("bullets", "thickness [m]", THICK, _points(bullet), 400),
    Sweep("blades", "thickness [m]", THICK, _points(blade), 400),
    Sweep("tips", "rate [1/s]", decades(0, 3), _points(tip), 450),
    Sweep("joint-stops", "speed", decades(-1, 3), _points(stop), 200),
    Sweep("meetings", "thickness [m]", THICK, _points(meeting), 400),
    Sweep("turning-planes", "rate [1/s]", decades(-1, 2), _points(turning_plane), 200),
    Sweep(
        "grazes",
        "clearance [m]",
        (-1e-3, -1e-6, -1e-9, 1e-9, 1e-6, 1e-3),
        _points(graze),
        100,
        logarithmic=False,
    ),
)
