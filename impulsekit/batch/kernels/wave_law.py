"""Impulses by stored energy for the contacts of one state, for kernels: as ``solve`` finds them."""

from __future__ import annotations

import math

import numpy as np

from ...laws.lzb import APPROACH_ENDED, strike_by_energy
from ...laws.progress import P1, P2, P
from ...laws.status import Status
from ...laws.tolerances import RESIDUAL_LIMIT
from ...laws.words import STRONGE
from ..codes import AGAIN
from .jit import built_in
from .layout import CONTACT_FLOATS, EXPONENT, STIFFNESS
from .path_law import memory, strike_along
from .problem import problem_in

__all__ = ["memory", "solved"]

_REFUSED = int(Status.REFUSED)


@built_in
def solved(count, posed, digits, space, memory):
    """The code, with P of the contacts that touch in ``space``."""
    if count == 1:
        # One contact alone is Stronge's, whatever its stiffness.
        return _alone(space, memory)
    # A wave takes its steps by all digits: what single precision has is too few.
    return _together(count, posed.floats, space) if digits == 53 else AGAIN


@built_in
def _alone(space, memory):
    """The code, with P of the contact that touches in ``space``."""
    W, before, free, mus, es, ets, P_all = problem_in(space)
    code = strike_along(W, 0, before[2], free, es[0], mus[0], ets[0], STRONGE, memory)
    now = memory.now
    P_all[0], P_all[1], P_all[2] = now[P1], now[P2], now[P]
    return code


@built_in
def _together(count, contact_floats, space):
    """The code, with P of the contacts that touch in ``space``."""
    W, _, free, mus, es, ets, P_all = problem_in(space)
    stiffness = np.empty(count)
    mobility, speed, rigid = 0.0, 0.0, 0.0
    for k in range(count):
        if mus[k] > 0.0 and ets[k] != 0.0:
            return _REFUSED
        stiffness[k] = contact_floats[space.row_of[k] * CONTACT_FLOATS + STIFFNESS]
        normal = 3 * k + 2
        mobility = max(mobility, W[normal, normal])
        speed = max(speed, abs(free[normal]))
        if stiffness[k] == math.inf:
            rigid = max(rigid, -free[normal])
    if mobility == 0.0 or rigid > APPROACH_ENDED * speed:
        # Contacts that nothing moves, or supports that are struck: ``solve`` says what is wrong.
        return AGAIN
    size = 3 * count
    code, residual, impulse, _, _, _, _ = strike_by_energy(
        W[:size, :size].copy(), free[:size].copy(), es[:count].copy(), mus[:count].copy(),
        stiffness, contact_floats[space.row_of[0] * CONTACT_FLOATS + EXPONENT],
    )  # fmt: skip
    if residual > RESIDUAL_LIMIT:
        return AGAIN
    for k in range(size):
        P_all[k] = impulse[k]
    return code
