"""Which geoms of a MuJoCo model may touch, and with what friction."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

__all__ = ["TouchingPair", "pairs_of"]

TouchingPair = tuple[str, str, float, bool]
"""Two geoms by name, their friction, and whether the second one is fixed to the world."""

_FILTER_PARENT = 1 << 9  # mjDSBL_FILTERPARENT


def pairs_of(mj: Any, known: set[str]) -> tuple[TouchingPair, ...]:
    """The pairs that MuJoCo tests: by contype and conaffinity, <pair> and <exclude>.

    Args:
        mj: a ``mujoco.MjModel``.
        known: the names of the geoms that have a shape.
    """
    explicit = {_signature(mj, mj.pair_geom1[i], mj.pair_geom2[i]): i for i in range(mj.npair)}
    found = []
    for first, second, friction in (*_automatic(mj, set(explicit)), *_explicit(mj)):
        if mj.body_weldid[mj.geom_bodyid[first]] == 0:
            first, second = second, first
        names = tuple(mj.geom(int(i)).name or f"geom_{i}" for i in (first, second))
        if known.issuperset(names):
            fixed = bool(mj.body_weldid[mj.geom_bodyid[second]] == 0)
            found.append((names[0], names[1], friction, fixed))
    return tuple(found)


def _signature(mj: Any, first: int, second: int) -> tuple[int, int]:
    bodies = int(mj.geom_bodyid[first]), int(mj.geom_bodyid[second])
    return min(bodies), max(bodies)


def _automatic(mj: Any, taken: set[tuple[int, int]]) -> Iterator[tuple[int, int, float]]:
    weld = mj.body_weldid[mj.geom_bodyid]
    parent = mj.body_weldid[mj.body_parentid[weld]]
    excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in mj.exclude_signature}
    excluded |= {(b, a) for a, b in excluded}
    with_parents = bool(mj.opt.disableflags & _FILTER_PARENT)
    for i in range(mj.ngeom):
        touches = (mj.geom_contype[i] & mj.geom_conaffinity[i + 1 :]) | (
            mj.geom_contype[i + 1 :] & mj.geom_conaffinity[i]
        )
        apart = weld[i] != weld[i + 1 :]
        kin = (parent[i + 1 :] == weld[i]) & (weld[i] != 0)
        kin |= (parent[i] == weld[i + 1 :]) & (weld[i + 1 :] != 0)
        for j in np.flatnonzero((touches != 0) & apart & (with_parents | ~kin)) + i + 1:
            bodies = _signature(mj, i, int(j))
            if bodies not in excluded and bodies not in taken:
                yield i, int(j), _friction(mj, i, int(j))


def _explicit(mj: Any) -> Iterator[tuple[int, int, float]]:
    for i in range(mj.npair):
        friction = float(mj.pair_friction[i][0]) if mj.pair_dim[i] > 1 else 0.0
        yield int(mj.pair_geom1[i]), int(mj.pair_geom2[i]), friction


def _friction(mj: Any, first: int, second: int) -> float:
    """The geom of higher priority decides, otherwise the larger value of both."""
    ends = [first, second]
    priority = mj.geom_priority[ends]
    if priority[0] != priority[1]:
        ends = [ends[int(np.argmax(priority))]]
    return 0.0 if mj.geom_condim[ends].max() <= 1 else float(mj.geom_friction[ends, 0].max())
