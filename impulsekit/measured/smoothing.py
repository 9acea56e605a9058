"""Velocities of recorded configurations: local parabolas in tangent spaces, none over a break."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError

__all__ = ["smoothed_velocities"]


def smoothed_velocities(
    model: pin.Model, t: np.ndarray, q: np.ndarray, breaks: Sequence[float], reach: int
) -> np.ndarray:
    """See ``Recording.velocities``."""
    if reach < 1:
        raise RangeError.of("reach", reach, "1 or more")
    piece = np.searchsorted(np.sort(np.asarray(breaks, dtype=float)), t, side="right")
    found = np.empty((len(t), model.nv))
    for k in range(len(t)):
        low, high = max(0, k - reach), min(len(t), k + reach + 1)
        near = low + np.flatnonzero(piece[low:high] == piece[k])
        near = near[(near == k) | (t[near] != t[k])]
        if len(near) < 2:
            raise InputError(
                f"velocities: the sample at {t[k]:g} s has no other between two breaks; "
                "give fewer breaks"
            )
        offsets = np.array([pin.difference(model, q[k], q[i]) for i in near])
        found[k] = _slopes(t[near] - t[k], offsets)
    return found


def _slopes(times: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """(nv,) slopes at 0 of the parabolas, or lines through two samples, that fit best."""
    order = min(2, len(times) - 1)
    size = float(np.abs(times).max())
    powers = np.stack([(times / size) ** k for k in range(order + 1)], axis=1)
    return np.linalg.lstsq(powers, offsets, rcond=None)[0][1] / size
