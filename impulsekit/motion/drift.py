"""Drift of what holds and rests is taken out, of positions first, then of velocities."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from .present import Present

__all__ = ["lay_down", "take_out_drift"]

# Drift below this [m, rad] or [m/s] is left alone.
NO_DRIFT = 1e-14
# Newton on positions: the second step ends at rounding, the third makes sure.
MOST_STEPS = 3


def take_out_drift(now: Present, bound: list[tuple[int, int]]) -> None:
    """Bring constraints, and resting points where they are bound, back to where they belong.

    Args:
        now: the motion, whose q and v change, by as little as can be in the metric of M.
        bound: (point, row) of the resting points that keep still, the normal row being 2.
    """
    _of_positions(now, [i for i, row in bound if row == 2])
    _of_velocities(now, [3 * i + row for i, row in bound])


def lay_down(now: Present) -> None:
    """Bring points that have come to rest to where they touch, and let them neither part nor press.

    Faces that lie on each other are parallel then and stay so: points that all but depend on
    each other would ask for forces that cannot be.
    """
    resting = now.resting.contacts
    if now.gaps is not None and resting:
        count = len(now.gaps.of_points(resting, now.q, now.v))
        _of_positions(now, list(range(count)))
        _of_velocities(now, [3 * i + 2 for i in range(count)])


def _of_positions(now: Present, pressed: list[int]) -> None:
    held, gaps = now.held, now.gaps
    resting = now.resting.contacts
    for _ in range(MOST_STEPS):
        off, of_rows = np.empty(0), np.empty(0, dtype=int)
        if held is not None:
            off, of_rows = held.drift(now.q, now.t)
        if gaps is not None and pressed:
            off = np.concatenate([off, gaps.of_points(resting, now.q, now.v)[pressed]])
        if not np.abs(off).max(initial=0.0) > NO_DRIFT:
            return
        rows = []
        if held is not None:
            rows.append(held.matrix(held.data, now.q)[of_rows])
        if gaps is not None and pressed:
            normals = [3 * i + 2 for i in pressed]
            rows.append(gaps.rows(resting, now.q)[normals])
        change = now.dynamics.moved(now.q, np.vstack(rows), -off)
        now.q = pin.integrate(now.model, now.q, change)


def _of_velocities(now: Present, chosen: list[int]) -> None:
    held, gaps = now.held, now.gaps
    rows, wanted = [], []
    if held is not None:
        rows.append(held.matrix(held.data, now.q))
        wanted.append(held.velocity)
    if gaps is not None and chosen:
        rows.append(gaps.rows(now.resting.contacts, now.q)[chosen])
        wanted.append(np.zeros(len(chosen)))
    if not rows:
        return
    matrix = np.vstack(rows)
    off = np.concatenate(wanted) - matrix.dot(now.v)
    if np.abs(off).max(initial=0.0) > NO_DRIFT:
        now.v = now.v + now.dynamics.moved(now.q, matrix, off)
