"""Samples that can be used: finite ones, in the order of their times."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InputError, NotFiniteError, RangeError

__all__ = ["in_order", "turns_of", "without_gaps"]

# A stretch that comes late takes its place between two samples: sorted, at most three joints of
# stretches for each time that runs back. Clocks that begin again give as many as there are samples.
INTERLEAVED = 3


def without_gaps(
    t: np.ndarray, q: np.ndarray, v: np.ndarray | None, where: str, repair: Any, notes: list[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Samples that are finite."""
    fine = np.isfinite(t) & np.isfinite(q).all(axis=1)
    if v is not None:
        fine &= np.isfinite(v).all(axis=1)
    bad = np.flatnonzero(~fine)
    if not len(bad):
        return t, q, v
    if "gaps" not in repair:
        raise NotFiniteError(
            f"{where}: {len(bad)} of {len(t)} samples hold a NaN or an infinity, the first is "
            f'sample {bad[0]}; repair="gaps" leaves them out',
            what=where, where=int(bad[0]),
        )  # fmt: skip
    if not fine.any():
        raise InputError(f"{where}: every sample holds a NaN or an infinity")
    notes.append(f"{len(bad)} of {len(t)} samples with a NaN or an infinity are left out")
    return t[fine], q[fine], None if v is None else v[fine]


def in_order(
    t: np.ndarray, q: np.ndarray, v: np.ndarray | None, where: str, repair: Any, notes: list[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Samples whose times rise."""
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if not len(back):
        return t, q, v
    if "time" not in repair:
        k = int(back[0])
        raise RangeError(
            f"{where}: times must rise, got {t[k + 1]:.9g} s after {t[k]:.9g} s at sample {k + 1} "
            f'({len(back)} such); repair="time" sorts them and leaves out repeated ones',
            what=where, value=float(t[k + 1]), allowed="rising times",
        )  # fmt: skip
    order = np.argsort(t, kind="stable")
    parts = np.searchsorted(back, order)
    if np.count_nonzero(np.diff(parts)) > INTERLEAVED * len(back):
        k = int(back[0])
        raise RangeError(
            f"{where}: times begin again at {t[k + 1]:.9g} s at sample {k + 1}, and stretches of "
            "samples lie at the same times: two recordings in one; cut it there",
            what=where, value=float(t[k + 1]), allowed="one recording",
        )  # fmt: skip
    kept = order[np.concatenate([[True], np.diff(t[order]) > 0.0])]
    notes.append(f"times ran back {len(back)} times; sorted, {len(t) - len(kept)} samples left out")
    return t[kept], q[kept], None if v is None else v[kept]


def turns_of(quaternions: np.ndarray) -> np.ndarray:
    """(N, 3, 3) rotations of (N, 4) unit quaternions xyzw."""
    x, y, z, w = quaternions.T
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
