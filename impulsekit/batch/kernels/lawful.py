"""The law of several rows for a block of states, as a function that kernels are handed.

It takes as long to compile as all other kernels together. A scene without constraints that
has one contact at most does not need it; handed over by its address, it is compiled only
for scenes that do, and once.
"""

from __future__ import annotations

import functools
import math
from typing import Any

from numba import cfunc, types

from ..codes import RowStatus
from .law import room, solve_state
from .layout import CONTACT_INTS

__all__ = ["law_for"]

_SOLVED = int(RowStatus.SOLVED)


@functools.cache
def law_for(number: str, needed: bool) -> Any:
    """What ``solve_blocks`` is to call for its lanes.

    Args:
        number: of the work array, "float64" or "float32".
        needed: whether it will be called; else something of the same type that does nothing.
    """
    whole = types.int64
    numbers = types.float64[::1]
    strided = types.Tuple((numbers, whole))
    signature = types.none(
        whole, whole, numbers, types.boolean[::1], types.int64[::1], numbers,
        types.UniTuple(strided, 3), whole, getattr(types, number)[::1],
        whole, whole, whole, whole, whole, types.int8[::1],
    )  # fmt: skip
    return cfunc(signature, cache=True)(solve_lanes if needed else leave_lanes)


def solve_lanes(
    base, count, target, keeps, contact_ints, contact_floats, given, digits,
    work, w_at, before_at, free_at, p_at, w, code,
):  # fmt: skip
    """Write the impulses of all rows, and the codes, for the states of a block.

    Args:
        base: the first state.
        count: how many rows.
        given: (array, stride) of q, restitution and friction.
        w: how many states there are.
    """
    (q, q_step), (e, e_step), (mu, mu_step) = given
    space = room(count, len(contact_ints) // CONTACT_INTS)
    for lane in range(w):
        state = base + lane
        if code[lane] == _SOLVED:
            code[lane] = solve_state(
                count, len(target), target, keeps, contact_ints, contact_floats,
                q, state * q_step, e, state * e_step, mu, state * mu_step, digits,
                work, w_at, before_at, free_at, p_at, w, lane, space,
            )  # fmt: skip
        else:
            for r in range(count):
                work[(p_at + r) * w + lane] = math.nan


def leave_lanes(
    base, count, target, keeps, contact_ints, contact_floats, given, digits,
    work, w_at, before_at, free_at, p_at, w, code,
):  # fmt: skip
    """Nothing."""
