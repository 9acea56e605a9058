"""Recorded joints held against their limits: angles in degrees, slides in millimetres."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..errors import InputError
from ..robot import Robot

__all__ = ["check_joint_limits"]

# Past its limits by more than this share of the way between them a joint is told to be outside:
# encoders are off by less.
OUTSIDE = 0.05
# So far past its limits is no joint in the unit that was stated: an angle by more than one turn, as
# encoders that count turns may be off [rad]; a slide by so many times the way between its limits.
TURN, WAYS = 1.05 * math.tau, 10.0
# An angle without limits that goes so far may be in degrees [rad].
TURNS = 2.0 * math.tau
# What readings are in, if they then lie within the limits: over the unit, and the repair.
ANGLES = {math.pi / 180.0: 'angle="deg"'}
LENGTHS = {1e-3: 'length="mm"', 1e-2: 'length="cm"'}


def check_joint_limits(
    robot: Robot, q: np.ndarray, angles: Mapping[str, np.ndarray], where: str
) -> list[str]:
    """What to note of joints that leave their limits.

    Args:
        q: (T, nq). angles: (T,) by joint, of those without limits, as read [rad].

    Raises:
        InputError: joints lie far outside their limits, and within them in another unit.
    """
    model, notes = robot.model, []
    far: list[tuple[str, float, str, list[str]]] = []
    for joint in list(model.joints)[1:]:
        if joint.nq != 1 or joint.nv != 1:
            continue
        low = float(model.lowerPositionLimit[joint.idx_q])
        high = float(model.upperPositionLimit[joint.idx_q])
        if not (np.isfinite([low, high]).all() and low < high):
            continue
        name, own = str(model.names[joint.id]), q[:, joint.idx_q]
        margin = OUTSIDE * (high - low)
        past = np.maximum(low - own, own - high)
        slides = joint.shortname().removeprefix("JointModel").startswith("P")
        units = LENGTHS if slides else ANGLES
        limits = f"{low:.4g} to {high:.4g} {'m' if slides else 'rad'}"
        if past.max() > (WAYS * (high - low) if slides else TURN):
            fits = [
                words
                for factor, words in units.items()
                if (np.maximum(low - factor * own, factor * own - high) <= margin).all()
            ]
            far.append((name, float(own[past.argmax()]), limits, fits))
        elif past.max() > margin:
            notes.append(
                f"joint {name} is outside its limits of {limits} in "
                f"{100.0 * np.mean(past > margin):.0f} % of the samples, by up to {past.max():.3g}"
            )
    for name, value, limits, words in far:
        if words:
            raise InputError(
                f'{where}: joint "{name}" is at {value:.4g}, and its limits are {limits}; it lies '
                f"within them in another unit: state {' or '.join(words)} in the RecordingFormat"
            )
        notes.append(f"joint {name} is at {value:.4g}, far outside its limits of {limits}")
    for name, angle in angles.items():
        most = float(np.abs(angle).max())
        if most > TURNS:
            notes.append(
                f"joint {name} goes as far as {most / math.tau:.0f} turns; if these are degrees, "
                'state angle="deg" in the RecordingFormat'
            )
    return notes
