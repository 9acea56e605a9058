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
from .handed import handed

__all__ = ["law_for"]


@functools.cache
def law_for(number: str, words: tuple[int, int, int]) -> Any:
    """What ``solve_blocks`` is to call for its lanes.

    Args:
        number: of the work array, "float64" or "float32".
        words: of the law, see ``words``.
    """
    whole = types.int64
    numbers = types.float64[::1]
    strided = types.Tuple((numbers, whole))
    places = types.int64[::1]
    held = types.Tuple((types.boolean[::1], numbers, places, places, whole, whole))
    signature = types.none(
        whole, whole, numbers, held, places, numbers,
        types.UniTuple(strided, 3), types.UniTuple(whole, 3), whole, getattr(types, number)[::1],
        whole, whole, whole, whole, whole, types.int8[::1],
    )  # fmt: skip
    return handed(signature, _lanes(words))


def _lanes(words: tuple[int, int, int]) -> Callable[..., None]:
    """The lanes of a block under one law."""
    restitution, slip, order = words
    if restitution == LZB:
        from .wave_law import wave_lanes

        return wave_lanes
    if order == SEQUENTIAL:
        from .sequential import sequential_lanes

        return sequential_lanes
    if slip == PATH:
        from .path_law import path_lanes

        return path_lanes
    from .law import contact_lanes

    return contact_lanes
