"""Drift of what holds and rests is taken out, of positions first, then of velocities."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ..gaps.contacts import Gaps
from ..rest.settle import MOST_STEPS, NO_DRIFT
from .present import Present

__all__ = ["lay_down", "take_out_drift"]

# A resting contact's index, which of its points, and the row of that, 2 being the normal one.
Place = tuple[int, int, int]


def take_out_drift(now: Present, bound: list[tuple[int, int]]) -> None:
    """Bring constraints, and resting points where they are bound, back to where they belong.

    Args:
        now: the motion, whose q and v change, by as little as can be in the metric of M.
        bound: (point, row) of the resting points that keep still, the normal row being 2.
    """
    owners = [(c, k) for c, one in enumerate(now.resting.contacts) for k in range(one.count)]
    places = [(*owners[point], row) for point, row in bound]
    _of_positions(now, [place for place in places if place[2] == 2])
    _of_velocities(now, places, turning=True)


def lay_down(now: Present) -> None:
    """Bring points that have come to rest to where they touch, and let them neither part nor press.

    Faces that lie on each other are parallel then and stay so: points that nearly depend on
    each other would ask for forces that cannot be. What chatters and can stick does not slip
    either: friction of so little slip would tip it, and let it chatter on.
    """
    resting, gaps = now.resting.contacts, now.gaps
    if gaps is not None and resting:
        gaps.of_points(resting, now.q, now.v)
        places = [(c, k, 2) for c, one in enumerate(resting) for k in range(one.count)]
        _of_positions(now, places)
        # Whether they roll or spin is not known yet.
        _of_velocities(now, places + _stuck(now, gaps), turning=False)


def _stuck(now: Present, gaps: Gaps) -> list[Place]:
    """The tangents of points that chatter, and slip more slowly than they are captured."""
    slip = gaps.velocities(now.resting.contacts, now.q, now.v).reshape(-1, 3)[:, :2]
    places, i = [], 0
    for c, one in enumerate(now.resting.contacts):
        chatters = one.friction and now.chatters(one.gap)
        bound = gaps.items[one.gap].capture_speed if chatters else 0.0
        for k in range(one.count):
            if float(np.hypot(*slip[i])) < bound:
                places += [(c, k, 0), (c, k, 1)]
            i += 1
    return places


def _there(now: Present, places: list[Place]) -> tuple[list[int], list[int]]:
    """Points and rows of those places that are still there.

    Points that are found anew at each place of the bodies come and go: a cylinder that is
    turned by a hair touches in one point instead of two.
    """
    first, starts = 0, []
    for contact in now.resting.contacts:
        starts.append(first)
        first += contact.count
    kept = [place for place in places if place[1] < now.resting.contacts[place[0]].count]
    points = [starts[c] + k for c, k, _ in kept]
    return points, [3 * point + row for point, (_, _, row) in zip(points, kept, strict=True)]


def _of_positions(now: Present, pressed: list[Place]) -> None:
    held, gaps = now.held, now.gaps
    resting = now.resting.contacts
    for _ in range(MOST_STEPS):
        off, of_rows = np.empty(0), np.empty(0, dtype=int)
        rows = []
        if held is not None:
            off, of_rows = held.drift(now.q, now.t)
        if gaps is not None and pressed:
            matrix = gaps.rows(resting, now.q)
            points, normals = _there(now, pressed)
            rows.append(matrix[normals])
            off = np.concatenate([off, gaps.of_points(resting, now.q, now.v)[points]])
        if not np.abs(off).max(initial=0.0) > NO_DRIFT:
            return
        if held is not None:
            rows.insert(0, held.rows.matrix(held.data, now.q)[of_rows])
        change = now.dynamics.moved(now.q, np.vstack(rows), -off)
        now.q = pin.integrate(now.model, now.q, change)


def _of_velocities(now: Present, chosen: list[Place], *, turning: bool) -> None:
    held, gaps = now.held, now.gaps
    rows, wanted = [], []
    if held is not None:
        rows.append(held.rows.matrix(held.data, now.q))
        wanted.append(held.velocity_at(now.t))
    if gaps is not None and chosen:
        matrix = gaps.rows(now.resting.contacts, now.q)
        _, kept = _there(now, chosen)
        rows.append(matrix[kept])
        wanted.append(np.zeros(len(kept)))
    rolling = now.resting.rolling
    if turning and gaps is not None and chosen and rolling is not None:
        gaps.rows(now.resting.contacts, now.q)
        rows.append(rolling.still_rows(gaps, now.resting.contacts, gaps.data))
        wanted.append(np.zeros(len(rows[-1])))
    joints = now.resting.joints
    if joints is not None and len(joints.still):
        rows.append(np.eye(now.model.nv)[joints.rows[joints.still]])
        wanted.append(np.zeros(len(rows[-1])))
    if not rows:
        return
    matrix = np.vstack(rows)
    off = np.concatenate(wanted) - matrix.dot(now.v)
    if np.abs(off).max(initial=0.0) > NO_DRIFT:
        now.v = now.v + now.dynamics.moved(now.q, matrix, off)
