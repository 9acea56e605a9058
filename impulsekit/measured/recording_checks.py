"""Checks of columns as they are read: gaps, times, units, axes, limits of joints."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InputError, NotFiniteError, RangeError

# A stretch that comes late takes its place between two samples: sorted, at most three joints of
# stretches for each time that runs back. Clocks that begin again give as many as there are samples.
INTERLEAVED = 3


# Times (T,), configurations (T, nq), and velocities (T, nv) where there are any.
Samples = tuple[np.ndarray, np.ndarray, np.ndarray | None]


def without_gaps(samples: Samples, where: str, repair: Any, notes: list[str]) -> Samples:
    """Samples that are finite."""
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
    """Samples whose times rise."""
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
    """(N, 3, 3) rotations of (N, 4) quaternions xyzw of any length."""
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
    if len(inside) < FEWEST_REPEATS:
        return []
    return [
        f"{len(inside)} of {len(q)} samples repeat the pose before them exactly, sample "
        f"{inside[0]} the first: the tracker lost the body, or is slower than the recording; "
        "leave these out"
    ]
