"""Checks of columns as they are read: gaps, times, units, axes, limits of joints.

Units and axes that recordings do not state, or state wrongly, are found by limits of joints, rates
of positions, free fall and steps of time: what only another unit explains is an error that says so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, NotFiniteError, RangeError
from ..robot import Robot

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
LENGTH_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
ANGLE_UNITS = {"rad": 1.0, "deg": math.pi / 180.0}
# Where x, y, z, w stand in what was read, if it was read in the wrong order.
OTHER_ORDERS = ((1, 2, 3, 0), (3, 0, 1, 2))
# A stretch that comes late takes its place between two samples: sorted, at most three joints of
# stretches for each time that runs back. Clocks that begin again give as many as there are samples.
INTERLEAVED = 3


# Times (T,), configurations (T, nq), and velocities (T, nv) where there are any.
Samples = tuple[np.ndarray, np.ndarray, np.ndarray | None]


def without_gaps(samples: Samples, where: str, repair: Any, notes: list[str]) -> Samples:
    """Return samples that are finite."""
    parts = [part.reshape(len(part), -1) for part in samples if part is not None]
    fine = np.isfinite(np.hstack(parts)).all(axis=1)
    bad = np.flatnonzero(~fine)
    if not len(bad):
        return samples
    if "gaps" not in repair:
        raise NotFiniteError(
            f"{where}: {len(bad)} of {len(fine)} samples hold a NaN or an infinity, the first is "
            f'sample {bad[0]}; repair="gaps" leaves them out',
            what=where, where=int(bad[0]),
        )  # fmt: skip
    if not fine.any():
        raise InputError(f"{where}: every sample holds a NaN or an infinity")
    notes.append(f"{len(bad)} of {len(fine)} samples with a NaN or an infinity are left out")
    return _chosen(samples, fine)


def in_order(samples: Samples, where: str, repair: Any, notes: list[str]) -> Samples:
    """Return samples whose times rise."""
    t = samples[0]
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if not len(back):
        return samples
    k = int(back[0])
    if "time" not in repair:
        raise RangeError(
            f"{where}: times must rise, got {t[k + 1]:.9g} s after {t[k]:.9g} s at sample {k + 1} "
            f'({len(back)} such); repair="time" sorts them and leaves out repeated ones',
            what=where, value=float(t[k + 1]), allowed="rising times",
        )  # fmt: skip
    order = np.argsort(t, kind="stable")
    parts = np.searchsorted(back, order)
    if np.count_nonzero(np.diff(parts)) > INTERLEAVED * len(back):
        raise RangeError(
            f"{where}: times begin again at {t[k + 1]:.9g} s at sample {k + 1}, and stretches of "
            "samples lie at the same times: two recordings in one; cut it there",
            what=where, value=float(t[k + 1]), allowed="one recording",
        )  # fmt: skip
    kept = order[np.concatenate([[True], np.diff(t[order]) > 0.0])]
    notes.append(f"times ran back {len(back)} times; sorted, {len(t) - len(kept)} samples left out")
    return _chosen(samples, kept)


def _chosen(samples: Samples, which: np.ndarray) -> Samples:
    t, q, v = samples
    return t[which], q[which], None if v is None else v[which]


def turns_of(quaternions: np.ndarray) -> np.ndarray:
    """Return (N, 3, 3) rotations of (N, 4) quaternions xyzw of any length."""
    length = np.linalg.norm(quaternions, axis=1, keepdims=True)
    x, y, z, w = (quaternions / np.where(length > 0.0, length, 1.0)).T
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


# Fewer samples that repeat the one before may do so by rounding in a file.
FEWEST_REPEATS = 3


def repeated_poses(q: np.ndarray) -> list[str]:
    """Return a note if samples between moving ones repeat the pose before them exactly.

    Repeats at the beginning and at the end are those of a body at rest, out of a simulator.

    Args:
        q: (T, nq) configurations.

    Example:
        >>> still = np.zeros((5, 7))
        >>> moved = np.arange(35.0).reshape(5, 7)
        >>> len(repeated_poses(np.vstack([moved, still, moved]))), repeated_poses(still)
        (1, [])
    """
    same = (np.diff(q, axis=0) == 0.0).all(axis=1)
    moving = np.flatnonzero(~same)
    if not len(moving):
        return []
    inside = np.flatnonzero(same[moving[0] : moving[-1]]) + moving[0] + 1
    if len(inside) < FEWEST_REPEATS:
        return []
    return [
        f"{len(inside)} of {len(q)} samples repeat the pose before them exactly, sample "
        f"{inside[0]} the first: the tracker lost the body, or is slower than the recording; "
        "leave these out"
    ]


# Past its limits by more than this share of the way between them a joint is noted to be outside:
# encoders are off by less.
OUTSIDE = 0.05
# So far past its limits is no joint in the unit that was stated: an angle by more than one turn, as
# encoders that count turns may be off [rad]; a slide by so many times the way between its limits.
TURN, WAYS = 1.05 * math.tau, 10.0
# An angle without limits that goes so far may be in degrees [rad].
TURNS = 2.0 * math.tau


def check_joint_limits(
    robot: Robot, q: np.ndarray, angles: Mapping[str, np.ndarray], where: str
) -> list[str]:
    """Return notes on joints that leave their limits.

    Args:
        q: (T, nq). angles: (T,) by joint, of those without limits, as read [rad].

    Raises:
        InputError: joints lie far outside their limits, and within them in another unit.
    """
    model, notes = robot.model, []
    for joint in list(model.joints)[1:]:
        if joint.nq != 1 or joint.nv != 1:
            continue
        low = float(model.lowerPositionLimit[joint.idx_q])
        high = float(model.upperPositionLimit[joint.idx_q])
        if not (np.isfinite([low, high]).all() and low < high):
            continue
        name, own = str(model.names[joint.id]), q[:, joint.idx_q]
        slides = joint.shortname().removeprefix("JointModel").startswith("P")
        limits = f"{low:.4g} to {high:.4g} {'m' if slides else 'rad'}"
        past, margin = np.maximum(low - own, own - high), OUTSIDE * (high - low)
        most, value = float(past.max()), float(own[past.argmax()])
        if most > (WAYS * (high - low) if slides else TURN):
            kind, known = ("length", LENGTH_UNITS) if slides else ("angle", ANGLE_UNITS)
            fits = [
                f'{kind}="{unit}"'
                for unit, factor in reversed(known.items())
                if (np.maximum(low - factor * own, factor * own - high) <= margin).all()
            ]
            if fits:
                raise InputError(
                    f'{where}: joint "{name}" is at {value:.4g}, and its limits are {limits}; it '
                    "lies within them in another unit: state "
                    f"{' or '.join(fits)} in the RecordingFormat"
                )
            notes.append(f"joint {name} is at {value:.4g}, far outside its limits of {limits}")
        elif most > margin:
            notes.append(
                f"joint {name} is outside its limits of {limits} in "
                f"{100.0 * np.mean(past > margin):.0f} % of the samples, by up to {most:.3g}"
            )
    for name, angle in angles.items():
        most = float(np.abs(angle).max())
        if most > TURNS:
            notes.append(
                f"joint {name} goes as far as {most / math.tau:.0f} turns; if these are degrees, "
                'state angle="deg" in the RecordingFormat'
            )
    return notes


# Relative difference between velocities and rates, in the median: below the first nothing is
# looked into; another reading is meant if it leaves less than the second, and less than this
# share of what the velocities as given leave. Above the last, velocities are noted as unlike.
FINE, ALIKE, SHARE, APART = 0.1, 0.35, 0.4, 0.6
# Rates below this [m/s, rad/s] are noise.
NOISE_OF_RATES = 0.05
# Fewer moving samples show nothing.
FEWEST = 8
FACTORS = {
    1000.0: "in mm/s or in milliseconds",
    0.001: "a thousand times too small (times in ms?)",
    180.0 / np.pi: "in deg/s",
    np.pi / 180.0: "57 times too small (angles in degrees?)",
    100.0: "in cm/s",
    -1.0: "of the wrong sign",
}


def checked_velocities(
    robot: Robot, t: np.ndarray, q: np.ndarray, v: np.ndarray | None, where: str, notes: list[str]
) -> np.ndarray | None:
    """Return the velocities, if they agree with the rate of the configurations.

    Raises:
        InputError: they agree only once units, axes or the order of a quaternion are changed;
            the error says which.
    """
    if v is None or len(t) < FEWEST:
        return v
    model = robot.model
    rates = np.array(
        [pin.difference(model, q[k], q[k + 1]) / (t[k + 1] - t[k]) for k in range(len(t) - 1)]
    )
    means = 0.5 * (v[1:] + v[:-1])
    for joint in list(model.joints)[1:]:
        parts = [("velocity", slice(joint.idx_v, joint.idx_v + joint.nv))]
        if joint.shortname() == "JointModelFreeFlyer":
            start = joint.idx_v
            parts = [("angular velocity", slice(start + 3, start + 6)),
                     ("velocity", slice(start, start + 3))]  # fmt: skip
        for what, own in parts:
            rate, mean = rates[:, own], means[:, own]
            moving = np.linalg.norm(rate, axis=1) > NOISE_OF_RATES
            if moving.sum() < FEWEST:
                continue
            share = _apart(rate[moving], mean[moving])
            if share < FINE:
                continue
            limit = min(ALIKE, SHARE * share)
            turns = q[:, joint.idx_q + 3 : joint.idx_q + 7] if what == "angular velocity" else None
            for reason, other_rate, other in _readings(t, rate, mean, turns):
                moving = np.linalg.norm(other_rate, axis=1) > NOISE_OF_RATES
                if moving.sum() >= FEWEST and _apart(other_rate[moving], other[moving]) < limit:
                    raise InputError(
                        f'{where}: the {what} of joint "{model.names[joint.id]}" does not match '
                        f"the rate of its positions: {reason}"
                    )
            if share < APART:
                continue
            notes.append(
                f"the {what} of joint {model.names[joint.id]} differs from the rate of its "
                f"positions by {100.0 * share:.0f} % in the median"
            )
    return v


def _apart(rate: np.ndarray, mean: np.ndarray) -> float:
    sizes = np.linalg.norm(rate, axis=1)
    return float(np.median(np.linalg.norm(mean - rate, axis=1) / sizes))


def _readings(
    t: np.ndarray, rate: np.ndarray, mean: np.ndarray, quaternions: np.ndarray | None
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Return other readings of velocities: what to say, and rates and velocities as they would be.

    Args:
        quaternions: (T, 4) of a body whose angular velocity it is; else None.
    """
    for factor, words in FACTORS.items():
        reason = f"it looks {words}; state the units in the RecordingFormat"
        yield reason, rate, mean / factor
    if quaternions is None:
        return
    axes = turns_of(quaternions[:-1])
    reason = "it looks as if given in {0} axes; call the column omega_{0}"
    yield reason.format("world"), rate, np.einsum("tji,tj->ti", axes, mean)
    yield reason.format("body"), rate, np.einsum("tij,tj->ti", axes, mean)
    reason = "the order of the quaternion looks as if it were the other one, xyzw or wxyz"
    for order in OTHER_ORDERS:
        turns = turns_of(quaternions[:, order])
        ways = [pin.log3(turns[k].T @ turns[k + 1]) for k in range(len(turns) - 1)]
        yield reason, np.array(ways) / np.diff(t)[:, None], mean


# Free fall in recordings over the scene's gravity, if lengths or times are in another unit.
LEAST_SCALE, MOST_SCALE = 0.5, 2.0
FALLS = {
    1e3: 'lengths look like millimetres; state length="mm" in the RecordingFormat',
    1e2: 'lengths look like centimetres; state length="cm" in the RecordingFormat',
    1e-6: 'times look like milliseconds; state time="ms" in the RecordingFormat',
    1e-12: 'times look like microseconds; state time="us" in the RecordingFormat',
    1e-18: 'times look like nanoseconds; state time="ns" in the RecordingFormat',
    1e-3: "lengths look like kilometres, or millimetres that were divided by 1000 twice",
}


def unit_of_falls(scale: float, gravity: float) -> tuple[float | None, str]:
    """Return the unit in which bodies fall, over what was stated, and the error's words.

    Args:
        scale: acceleration of free fall in the recordings over ``gravity`` [m/s²].
    """
    unit = next((each for each in FALLS if LEAST_SCALE < scale / each < MOST_SCALE), None)
    advice = FALLS[unit] if unit else "state the units in the RecordingFormat"
    words = f"bodies fall with {scale * gravity:.4g} instead of {gravity:.4g} m/s²: {advice}"
    return unit, words


# Samples that flights are followed through are so far apart [s]; others are of one instant, have
# times in another unit, or lie on either side of a pause that takes long to follow, for nothing.
STEPS = (1e-7, 100.0)
# A body falls 0.2 m in this time [s]: no flight shows in slower samples; their times are likely in
# another unit, if they are samples of 10 Hz to 100 kHz in it.
SLOWEST, LIKELY = 0.2, (1e-5, 0.1)


def check_steps(t: np.ndarray, name: str) -> None:
    """Refuse times between samples that are likely in another unit, or too far apart.

    Raises:
        RangeError.
    """
    least, most = STEPS
    steps = np.diff(t)
    middle = float(np.median(steps)) if len(steps) else 0.0
    if middle > SLOWEST:
        units = [
            unit for unit, size in TIME_UNITS.items() if LIKELY[0] <= size * middle <= LIKELY[1]
        ]
        advice = (
            f'times look like {" or ".join(units)}; state time="{units[0]}" in the RecordingFormat'
            if units
            else "state the unit of times in the RecordingFormat"
        )
        raise RangeError.of(
            f"find_impacts: recording {name}: median time between samples", middle,
            f"{SLOWEST:g} s or less ({advice})",
        )  # fmt: skip
    off = np.flatnonzero(~((steps >= least) & (steps <= most)))
    if len(off):
        k = int(off[0])
        raise RangeError.of(
            f"find_impacts: recording {name}: t[{k + 1}] - t[{k}]",
            float(steps[k]),
            f"{least:g} to {most:g} s (give one sample of each instant, cut the recording at "
            "pauses, and state its time unit in the RecordingFormat)",
        )
