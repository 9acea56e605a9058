"""Which way points slip, roll or spin, and when that begins, stops or has got going.

Of each point ``ways`` (n, 3) has the direction of its slip, and whether it STICKS, SLIDES, or
BEGINS to: then friction opposes its acceleration. Rolling has its direction across the normal,
spin its sign alone. Numbers of points stand as [t₁, t₂, n, t₁, …].
"""

from __future__ import annotations

import math

import numpy as np

from ...geometry.vectors import Vector
from ...laws.borrowed import borrowing
from ...tolerances import NONZERO
from ..tree.pressed import BEGINS, SLIDES, STICKS, direction_of

__all__ = [
    "LIFTED_OFF_STOP", "begin_slides", "couple_friction", "next_slide", "stop_slides",
    "update_slides", "write_signs",
]  # fmt: skip

# A tangential rate below this share of the largest acceleration has no direction.
NO_DIRECTION = 1e-7
# Tangential forces this near the cone are on it.
ON_CONE = 1.0 - 1e-7
# Slip above this share of the speed at which it has grown counts as grown.
ALL_BUT = 0.999
# Normal speed at which a resting contact has lifted [m/s].
LIFTED_OFF_STOP = 1e-8


@borrowing
def begin_slides(slip: np.ndarray, friction: np.ndarray, slow: float, ways: np.ndarray) -> None:
    """After an impact what slips slides: write ``ways``.

    Args:
        slip: (3n,) [m/s]. friction: (n,) µ. slow: slower slip has no direction [m/s].
    """
    for i in range(len(ways)):
        one, two, own = slip[3 * i], slip[3 * i + 1], ways[i]
        speed = math.hypot(one, two)
        own[0], own[1], own[2] = 0.0, 0.0, STICKS
        if friction[i] > 0.0 and speed > slow:
            own[0], own[1], own[2] = one / speed, two / speed, SLIDES


@borrowing
def update_slides(
    slip: np.ndarray,
    rates: np.ndarray,
    forces: np.ndarray,
    friction: np.ndarray,
    numbers: tuple[float, float, float],
    fresh: bool,
    ways: np.ndarray,
) -> bool:
    """Write which points slide from now on; whether that has changed.

    Args:
        slip: (3n,) [m/s]. rates: (3n,) of that [m/s²]. forces: (3n,) [N]. friction: (n,) µ.
        numbers: the largest acceleration of a point [m/s²]; ``slow`` and ``grown`` [m/s].
        fresh: after an impact slip decides alone.
    """
    changed, (largest, slow, grown) = False, numbers
    for i in range(len(ways)):
        at, own = 3 * i, ways[i]
        before = own[2]
        own[0], own[1], own[2] = next_slide(
            (own[0], own[1], before),
            (slip[at], slip[at + 1]),
            (rates[at], rates[at + 1]),
            (forces[at], forces[at + 1], forces[at + 2]),
            (friction[i], largest, slow, grown),
            fresh,
        )
        changed |= before != own[2]
    return changed


@borrowing
def next_slide(
    before: Vector,
    slip: tuple[float, float],
    rate: tuple[float, float],
    force: Vector,
    numbers: tuple[float, float, float, float],
    fresh: bool,
) -> Vector:
    """What a point does from now on, as ``ways`` has it.

    Args:
        before: the same of before. slip: [m/s]. rate: of that [m/s²].
        force: two tangents and the normal [N].
        numbers: µ, the largest acceleration of a point [m/s²], and ``slow`` and ``grown`` of
            ``Resting`` [m/s].
        fresh: after an impact slip decides alone.
    """
    mu, largest, slow, grown = numbers
    stays = 0.0, 0.0, STICKS
    if mu == 0.0:
        return stays
    speed = math.hypot(slip[0], slip[1])
    slides = before[0], before[1], SLIDES
    if speed > slow:
        slides = slip[0] / speed, slip[1] / speed, SLIDES
    if before[2] == SLIDES or (fresh and speed > slow):
        return slides
    on_cone = force[2] > 0.0 and math.hypot(force[0], force[1]) >= mu * force[2] * ON_CONE
    if before[2] == BEGINS:
        # Slip that has only begun is rounding: its direction is that in which it begins.
        turning = slides[0] * rate[0] + slides[1] * rate[1]
        if on_cone and speed < ALL_BUT * grown and turning >= 0.0:
            return slides[0], slides[1], BEGINS
        return slides if speed > slow else stays
    if not on_cone:
        return stays
    if speed > slow:
        return slides
    size = math.hypot(rate[0], rate[1])
    if not size > NO_DIRECTION * max(largest + force[2], NONZERO):
        return stays
    return rate[0] / size, rate[1] / size, BEGINS if grown > 0.0 else SLIDES


@borrowing
def stop_slides(slip: np.ndarray, ended: float, still: float, ways: np.ndarray) -> None:
    """Slip (3n,) has stopped, or turned, which it may only have in three dimensions.

    Args:
        ended: slower slip has stopped [m/s], unless it goes on along its way faster than ``still``.
    """
    for i in range(len(ways)):
        one, two, own = slip[3 * i], slip[3 * i + 1], ways[i]
        if own[2] == STICKS:
            continue
        speed = math.hypot(one, two)
        if speed > ended:
            own[0], own[1] = one / speed, two / speed
        elif one * own[0] + two * own[1] <= still:
            own[0], own[1], own[2] = 0.0, 0.0, STICKS


@borrowing
def write_signs(slip: np.ndarray, ways: np.ndarray, grown: float, signs: np.ndarray) -> None:
    """Write (n, 3) what falls below zero where slip stops, a point lifts, or slip has got going.

    Slip (3n,) along its first direction, −lift, and how far slip is from ``grown`` [m/s]; infinite
    where that is not looked for.
    """
    for i in range(len(ways)):
        one, two, own = slip[3 * i], slip[3 * i + 1], ways[i]
        signs[i, 0] = one * own[0] + two * own[1] if own[2] != STICKS else math.inf
        signs[i, 1] = LIFTED_OFF_STOP - slip[3 * i + 2]
        left = grown - math.sqrt(one * one + two * two)
        signs[i, 2] = left if own[2] == BEGINS else math.inf


def couple_friction(
    ways: np.ndarray,
    slip: np.ndarray,
    friction: np.ndarray,
    slow: float,
    rows: np.ndarray,
    normals: np.ndarray,
    forces: np.ndarray,
) -> np.ndarray:
    """Let friction of what slides go with the normal force: P = P_n (−µ s, 1).

    Args:
        slip: (3n,) [m/s]. friction: (n,) µ, or how far a moment reaches [m].
        slow: slower slip keeps the direction in which it began [m/s].
        rows: (n, k) of the friction of each point. normals: (n,) rows of the normal forces.
        forces: (m, m) forces from the unknowns; written.

    Returns:
        (n,) which points slide so.
    """
    sliding = ways[:, 2] == SLIDES
    for i in np.flatnonzero(sliding).tolist():
        s = direction_of(float(slip[3 * i]), float(slip[3 * i + 1]), ways[i], slow)
        own = rows[i]
        forces[own, own] = 0.0
        forces[own, normals[i]] = -friction[i] * np.array(s[: len(own)])
    return sliding
