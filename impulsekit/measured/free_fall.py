"""Free fall: the scale of lengths, the vertical, the tracked point of a body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..robot import Robot
from ..tolerances import NONZERO
from .recording import Recording
from .recording_checks import LEAST_SCALE, MOST_SCALE, unit_of_falls

# Samples of windows to look for free fall in.
WINDOWS = (15, 25)
# A window's parabola leaves residuals below this share of what it falls [relative].
SMOOTH = 0.12
# A part bends by this share of its way at least, or its acceleration is not determined.
LEAST_FALL = 1e-3
# Cosine to the scene's gravity above which a window's acceleration is free fall; logarithms of
# accelerations this near are one.
DOWN, ALIKE_FALLS = 0.95, 0.1
# So many windows at least determine the size of free fall.
FEWEST_FALLS = 3
# Those of lengths: units of times show in the steps between samples too.
LENGTHS = (1e3, 1e2)
# Directions of the unknowns that flights determine worse, relative to the best, are left out.
UNDETERMINED = 1e-10
# Axes that turn by less than the root of this, summed over samples, do so by rounding [rad²].
UNTURNED = 1e-20
# [of the square of a direction] Unknowns with more than this in what no flight determines.
BLIND = 1e-6


@dataclass(frozen=True, eq=False)
class FreeFall:
    """Common to all flights of a set of recordings.

    Attributes:
        acceleration: (3,) of the mass centre, axes of the recording [m/s²].
        offset: (3,) of the recorded position against the body's frame, in its axes [m].
        covariance: (6, 6) of both; infinite for what no flight determines.
    """

    acceleration: np.ndarray
    offset: np.ndarray
    covariance: np.ndarray


def mass_centres(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return (T, 3) mass centres in the world and (T, 3, 3) axes of the free body.

    Axes of several are 0: the common mass centre does not determine where the points on each are.
    """
    model = recording.robot.model
    data = model.createData()
    root, alone = free_root(recording.robot), len(free_bodies(recording.robot)) == 1
    places, axes = [], []
    for q in recording.q:
        places.append(np.array(pin.centerOfMass(model, data, np.array(q))))
        axes.append(np.array(data.oMi[root].rotation) * alone)
    return np.array(places), np.array(axes)


def free_joints(model: pin.Model) -> list[pin.JointModel]:
    """Return the free-flyers of a model."""
    return [joint for joint in model.joints if joint.shortname() == "JointModelFreeFlyer"]


def free_bodies(robot: Robot) -> list[int]:
    """Return the indices of the free joints, that of the root first.

    Raises:
        InputError: the root is none.
    """
    free_root(robot)
    return [int(joint.id) for joint in free_joints(robot.model)]


def has_one_free_body(robot: Robot) -> bool:
    """Return whether the root is a free-flyer, and the only one."""
    free = free_joints(robot.model)
    return len(free) == 1 and free[0].idx_q == 0


def free_root(robot: Robot) -> int:
    """Return the index of the free joint at the root.

    Raises:
        InputError: there is none.
    """
    for joint in free_joints(robot.model):
        if joint.idx_q == 0:
            return int(joint.id)
    raise InputError(
        "calibrate: free fall determines lengths and the vertical, and this robot's root is no "
        'free-flyer; load it with root="freeflyer"'
    )


def coarse_scale(recordings: list[Recording], gravity: np.ndarray) -> float:
    """Return free fall in the recordings over the scene's ``gravity`` (3,), from windows.

    Raises:
        InputError: no free fall, or units that are mistaken.
    """
    scale = _scale_of_windows(recordings, gravity)
    if scale is None:
        raise InputError(
            "calibrate: no free fall in the recordings; give recordings of a body in flight"
            + _other_way(recordings, gravity)
        )
    size = float(np.linalg.norm(gravity))
    if not LEAST_SCALE < scale < MOST_SCALE:
        raise InputError(f"calibrate: {unit_of_falls(scale, size)[1]}")
    return scale


def length_unit(recordings: list[Recording], gravity: np.ndarray) -> str | None:
    """Return the error's words if free fall in the recordings is that of mm or cm, else None."""
    scale = _scale_of_windows(recordings, gravity)
    if scale is None:
        return None
    unit, words = unit_of_falls(scale, float(np.linalg.norm(gravity)))
    return words if unit in LENGTHS else None


def _scale_of_windows(recordings: list[Recording], gravity: np.ndarray) -> float | None:
    """Return the acceleration of free fall over ``gravity`` (3,); None: too few windows fall."""
    found = _falls(recordings, gravity)
    if len(found) < FEWEST_FALLS:
        return None
    # Impacts give windows of any acceleration; those of free fall are all alike.
    ratios = np.log(np.array(found) / float(np.linalg.norm(gravity)))
    near = [(np.abs(ratios - each) < ALIKE_FALLS).sum() for each in ratios]
    return float(np.exp(ratios[int(np.argmax(near))]))


def _other_way(recordings: list[Recording], gravity: np.ndarray) -> str:
    """Return the error's words if bodies fall along another axis than the scene's gravity, else
    None."""
    size = float(np.linalg.norm(gravity))
    for sign in (-1.0, 1.0):
        for axis, name in enumerate("xyz"):
            along = sign * np.eye(3)[axis]
            near = [
                LEAST_SCALE < fall / size < MOST_SCALE for fall in _falls(recordings, size * along)
            ]
            if sum(near) >= FEWEST_FALLS and abs(float(along @ gravity)) < DOWN * size:
                return (
                    f"; bodies fall along {'+' if sign > 0.0 else '-'}{name} of the recordings, "
                    f"and the scene's gravity is {np.round(gravity, 3).tolist()}: turn the "
                    "recordings into the scene's axes"
                )
    return ""


def _falls(recordings: list[Recording], gravity: np.ndarray) -> list[float]:
    """Return accelerations along gravity in the windows that are smooth and not at rest."""
    found = []
    windows = (
        (recording.t[k : k + window], centres[k : k + window])
        for recording in recordings
        for centres in (mass_centres(recording)[0],)
        for window in WINDOWS
        for k in range(0, len(centres) - window + 1, 3)
    )
    for times, centres in windows:
        t = times - times[len(times) // 2]
        span = float(np.abs(t).max())
        powers = np.stack([np.ones(len(t)), t / span, (t / span) ** 2], axis=1)
        fit, _, _, _ = np.linalg.lstsq(powers, centres, rcond=None)
        left = centres - powers @ fit
        way = float(np.linalg.norm(fit[1]))
        fall = float(np.linalg.norm(fit[2]))
        rough = float(np.sqrt(np.mean(left**2)))
        # What slides or rolls on a level floor is not accelerated down.
        down = float(fit[2] @ gravity) / float(np.linalg.norm(gravity))
        if fall > LEAST_FALL * way and rough < SMOOTH * fall and down > DOWN * fall:
            found.append(2.0 * fall / span**2)
    return found


def free_fall(
    flights: list[tuple[int, np.ndarray, np.ndarray, np.ndarray]],
) -> FreeFall:
    """Fit all flights: c(t) = c₀ + v₀ t + a t²/2 + R(t) d, a and d common to all.

    Args:
        flights: of each, the number of its recording, (N,) times, (N, 3) mass centres,
            (N, 3, 3) axes of the free body.

    The covariance is that of the jackknife over recordings: these are independent, samples of
    one are not.
    """
    blocks: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    for recording, t, centres, axes in flights:
        tau = t - t.mean()
        own = np.stack([np.ones(len(t)), tau], axis=1)
        # What each flight has to itself, c₀ and v₀, is projected out.
        basis, _ = np.linalg.qr(own)
        common = np.zeros((len(t), 3, 6))
        for i in range(3):
            common[:, i, i] = 0.5 * tau**2
        common[:, :, 3:] = axes
        flat = common.reshape(len(t), 18)
        flat = (flat - basis @ (basis.T @ flat)).reshape(-1, 6)
        seen = (centres - basis @ (basis.T @ centres)).reshape(-1)
        normal, right = blocks.get(recording, (np.zeros((6, 6)), np.zeros(6)))
        blocks[recording] = normal + flat.T @ flat, right + flat.T @ seen
    normals, rights = (np.array(each) for each in zip(*blocks.values(), strict=True))
    found, determined = _solution(normals.sum(axis=0), rights.sum(axis=0))
    count = len(blocks)
    if count < 2:
        return FreeFall(found[:3], found[3:], np.full((6, 6), np.inf))
    others = np.array(
        [
            _solution(normals.sum(axis=0) - normal, rights.sum(axis=0) - right)[0] - found
            for normal, right in zip(normals, rights, strict=True)
        ]
    )
    covariance = (count - 1) / count * others.T @ others
    covariance[~determined] = covariance[:, ~determined] = np.inf
    return FreeFall(found[:3], found[3:], covariance)


def _solution(normal: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the (6,) least-squares solution, and which unknowns the flights determine."""
    known = np.diagonal(normal)
    size = 1.0 / np.sqrt(np.maximum(known, NONZERO))
    size[3:][known[3:] < UNTURNED] = 0.0
    values, ways = np.linalg.eigh(normal * np.outer(size, size))
    determined = values > UNDETERMINED * values[-1]
    inverse = (
        (ways[:, determined] / values[determined]) @ ways[:, determined].T * np.outer(size, size)
    )
    blind = (ways[:, ~determined] ** 2).sum(axis=1) > BLIND
    return inverse @ right, ~blind
