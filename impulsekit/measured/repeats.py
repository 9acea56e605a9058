"""Poses that a recording repeats: a tracker that lost the body, or is slower than the samples."""

from __future__ import annotations

import numpy as np

__all__ = ["repeated_poses"]

# Fewer samples that repeat the one before may do so by rounding in a file.
FEWEST = 3


def repeated_poses(q: np.ndarray) -> list[str]:
    """A note if samples between moving ones repeat the pose before them exactly.

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
    if len(inside) < FEWEST:
        return []
    return [
        f"{len(inside)} of {len(q)} samples repeat the pose before them exactly, sample "
        f"{inside[0]} the first: the tracker lost the body, or is slower than the recording; "
        "leave these out"
    ]
