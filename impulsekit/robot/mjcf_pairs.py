"""Which geoms of a MuJoCo model may touch, and with what friction."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

__all__ = ["TouchingPair", "pairs_of"]

# Flags of MuJoCo: mjDSBL_FILTERPARENT, mjENBL_OVERRIDE.
_FILTER_PARENT, _OVERRIDE = 1 << 9, 1 << 0
# The least condim with which a contact resists sliding, spin about the normal, and rolling.
_SLIDES, _SPINS, _ROLLS = 3, 4, 6


class TouchingPair(NamedTuple):
    """Two geoms that may touch, and their friction.

    Attributes:
        first, second: names of the geoms.
        friction: µ of sliding; 0 for condim 1.
        torsion, rolling: moments over the normal force [m]; 0 below condim 4 and 6.
        fixed: whether the second one is fixed to the world.
        uneven: whether sliding or rolling friction differs between the two tangents.
    """

    first: str
    second: str
    friction: float
    torsion: float
    rolling: float
    fixed: bool
    uneven: bool = False

    def within(self, prefix: str) -> TouchingPair:
        """The same with a prefix before its names."""
        return self._replace(first=prefix + self.first, second=prefix + self.second)


# Indices of two geoms, condim, and µ twice, torsion, rolling twice.
_Found = tuple[int, int, int, np.ndarray]


def pairs_of(mj: Any, known: set[str]) -> tuple[TouchingPair, ...]:
    """The pairs that MuJoCo tests: by contype and conaffinity, <pair> and <exclude>.

    Args:
        mj: a ``mujoco.MjModel``.
        known: the names of the geoms that have a shape.
    """
    explicit = {_signature(mj, mj.pair_geom1[i], mj.pair_geom2[i]): i for i in range(mj.npair)}
    found = []
    for first, second, condim, numbers in (*_automatic(mj, set(explicit)), *_explicit(mj)):
        if mj.body_weldid[mj.geom_bodyid[first]] == 0:
            first, second = second, first
        names = tuple(mj.geom(int(i)).name or f"geom_{i}" for i in (first, second))
        if known.issuperset(names):
            fixed = bool(mj.body_weldid[mj.geom_bodyid[second]] == 0)
            found.append(_pair(mj, names, condim, numbers, fixed=fixed))
    return tuple(found)


def _signature(mj: Any, first: int, second: int) -> tuple[int, int]:
    bodies = int(mj.geom_bodyid[first]), int(mj.geom_bodyid[second])
    return min(bodies), max(bodies)


def _automatic(mj: Any, taken: set[tuple[int, int]]) -> Iterator[_Found]:
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
                yield i, int(j), *_friction(mj, i, int(j))


def _explicit(mj: Any) -> Iterator[_Found]:
    for i in range(mj.npair):
        yield int(mj.pair_geom1[i]), int(mj.pair_geom2[i]), int(mj.pair_dim[i]), mj.pair_friction[i]


def _friction(mj: Any, first: int, second: int) -> tuple[int, np.ndarray]:
    """condim, and µ twice, torsion, rolling twice.

    The geom of higher priority decides, otherwise the larger value of both.
    """
    ends = [first, second]
    priority = mj.geom_priority[ends]
    if priority[0] != priority[1]:
        ends = [ends[int(np.argmax(priority))]]
    slide, spin, roll = mj.geom_friction[ends].max(axis=0)
    return int(mj.geom_condim[ends].max()), np.array([slide, slide, spin, roll, roll])


def _pair(
    mj: Any, names: tuple[str, ...], condim: int, numbers: np.ndarray, *, fixed: bool
) -> TouchingPair:
    """A pair with the coefficients that its condim has; a global override replaces them."""
    if int(mj.opt.enableflags) & _OVERRIDE:
        numbers = mj.opt.o_friction
    slide, across, spin, roll, over = map(float, numbers)
    slides, spins, rolls = condim >= _SLIDES, condim >= _SPINS, condim >= _ROLLS
    return TouchingPair(
        names[0],
        names[1],
        slide if slides else 0.0,
        spin if spins else 0.0,
        roll if rolls else 0.0,
        fixed,
        (slides and slide != across) or (rolls and roll != over),
    )
