"""The law of contacts for a block of states, as a function that kernels are handed.

It takes as long to compile as all other kernels together. A scene without constraints that
has one contact at most, under Newton's law with slip at the end, does not need it; handed
over by its address, it is compiled only for scenes that do, each law by itself, and once.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from numba import types

from ...laws.words import LZB, PATH, SEQUENTIAL
from .given import Lanes, Posed
from .handed import handed
from .problem import lanes_under

__all__ = ["law_for"]


@functools.cache
def law_for(number: str, words: tuple[int, int, int], is_held: bool) -> Any:
    """What ``solve_blocks`` is to call for its lanes.

    Args:
        number: of the work array, "float64" or "float32".
        words: of the law, see ``words``.
        is_held: whether there are bilateral rows.
    """
    whole, places, numbers = types.int64, types.int64[::1], types.float64[::1]
    strided = (numbers, whole)
    posed = types.NamedTuple(
        (whole, numbers, types.boolean[::1], numbers, places, places, places, numbers)
        + 3 * strided
        + (types.UniTuple(whole, 3),),
        Posed,
    )
    work, code = getattr(types, number)[::1], types.int8[::1]
    lanes = types.NamedTuple((whole, whole, whole, work, code) + 6 * (whole,), Lanes)
    return handed(types.none(posed, lanes), _law_of_lanes(words, is_held))


def _law_of_lanes(words: tuple[int, int, int], is_held: bool) -> Callable[..., None]:
    """The lanes of a block under one law."""
    restitution, slip, order = words
    if restitution == LZB:
        from .wave_law import memory, solved
    elif order == SEQUENTIAL:
        from .sequential import memory, solved
    elif slip == PATH:
        from .path_law import memory, solved
    else:
        from .law import memory, solved
    return lanes_under(memory, solved, is_held, order == SEQUENTIAL)
