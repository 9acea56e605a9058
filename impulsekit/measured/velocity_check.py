"""Recorded velocities held against the rate of the recorded configurations."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..robot import Robot
from .samples import turns_of

__all__ = ["checked_velocities"]

# Relative difference between velocities and rates, in the median: below the first nothing is
# looked into; another reading is meant if it leaves less than the second, and less than this
# share of what the velocities as given leave. Above the last, velocities are noted as unlike.
FINE, ALIKE, SHARE, APART = 0.1, 0.35, 0.4, 0.6
# Rates below this [m/s, rad/s] are noise and tell nothing.
NOISE_OF_RATES = 0.05
# Fewer moving samples tell nothing.
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
    """The velocities, if they agree with the rate of the configurations.

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
            name = f'{where}: the {what} of joint "{model.names[joint.id]}"'
            reason = _reason(rate[moving], mean[moving], limit)
            if reason is None and what == "angular velocity":
                turns = q[:-1, joint.idx_q + 3 :][moving, :4]
                reason = _turned(turns, rate[moving], mean[moving], limit)
                if reason is None:
                    turns = q[:, joint.idx_q + 3 : joint.idx_q + 7]
                    reason = _reordered(t, turns, mean, limit)
            if reason is not None:
                raise InputError(f"{name} does not match the rate of its positions: {reason}")
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


def _reason(rate: np.ndarray, mean: np.ndarray, limit: float) -> str | None:
    for factor, words in FACTORS.items():
        if _apart(rate, mean / factor) < limit:
            return f"it looks {words}; state the units in the RecordingFormat"
    return None


def _turned(
    quaternions: np.ndarray, rate: np.ndarray, mean: np.ndarray, limit: float
) -> str | None:
    """Whether the axes are taken for others, or the order of the quaternion."""
    axes = turns_of(quaternions)
    in_world = np.einsum("tij,tj->ti", axes, mean)
    to_body = np.einsum("tji,tj->ti", axes, mean)
    if _apart(rate, to_body) < limit:
        return "it looks as if given in world axes; call the column omega_world"
    if _apart(rate, in_world) < limit:
        return "it looks as if given in body axes; call the column omega_body"
    return None


def _reordered(
    t: np.ndarray, quaternions: np.ndarray, mean: np.ndarray, limit: float
) -> str | None:
    """Whether the rate of the quaternions is that of ``mean`` once they are read otherwise."""
    for order in ([1, 2, 3, 0], [3, 0, 1, 2]):
        turns = turns_of(quaternions[:, order])
        rates = np.array(
            [pin.log3(turns[k].T @ turns[k + 1]) / (t[k + 1] - t[k]) for k in range(len(turns) - 1)]
        )
        moving = np.linalg.norm(rates, axis=1) > NOISE_OF_RATES
        if moving.sum() >= FEWEST and _apart(rates[moving], mean[moving]) < limit:
            return "the order of the quaternion looks as if it were the other one, xyzw or wxyz"
    return None
