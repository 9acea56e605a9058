"""Which contact of a sequence is hit next.

Plain functions of floats, each by itself: ``solve`` calls them as Python, and the batch kernels
compile them in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = ["NOISE", "fastest", "pace_of"]

Numbers = Sequence[float]

# A contact whose approach is this small against its own slip has none: the closed form of one
# contact takes it for zero, too. A few units in the last place.
AT_REST = 1e-15
# The same against the terms of u_free + W P, whose rounding it is.
ROUNDING = 4.5e-16
# Paces that differ by less than the first share of themselves, or the second of their terms, are
# one: contacts of a pair with one relative motion all have the same, and rounding is not to say
# which is hit. The entry that stands first is.
TIE, TIE_ROUNDING = 1e-12, 1e-14
# Where W_nn is this small against W of the contact's own tangents, or against the largest W,
# it is the square of a rounding error: no normal impulse moves that contact.
IMMOVABLE, IMMOVABLE_BESIDE = 1e-26, 1e-24
# What such a contact may approach against all velocities, by rounding alone.
NOISE = 1e-12


def pace_of(normal_velocity: float, nn: float) -> float:
    """|u_n|/√W_nn [√J]: the approach in one unit for contacts [m/s] and joint stops [rad/s].

    Half its square is the energy that the contact loses when it is stopped.
    """
    return abs(normal_velocity) / math.sqrt(nn)


def fastest(
    W: Numbers,
    stride: int,
    velocity: Numbers,
    free: Numbers,
    impulse: Numbers,
    mu: Numbers,
    count: int,
) -> int:
    """The contact that approaches fastest by |u_n|/√W_nn; −1 where none approaches.

    Of several that are equally fast it is the first. A contact that no impulse moves comes
    before all others where it approaches by more than rounding.

    Args:
        W: Delassus matrix [1/kg], flat; its rows are ``stride`` apart.
        velocity: (3 count,) of the contacts now [m/s].
        free: (3 count,) u_free [m/s].
        impulse: (3 count,) P so far [N s].
        mu: (count,) friction.
        count: how many contacts.
    """
    found, most = -1, 0.0
    for i in range(count):
        n = 3 * i + 2
        approach = -velocity[n]
        if not approach > 0.0:
            continue
        nn = W[n * stride + n]
        tangents = max(W[(n - 2) * (stride + 1)], W[(n - 1) * (stride + 1)])
        largest = 0.0
        for k in range(3 * count):
            largest = max(largest, W[k * stride + k])
        if nn <= IMMOVABLE * tangents or nn <= IMMOVABLE_BESIDE * largest:
            size = 0.0
            for k in range(3 * count):
                size = max(size, abs(velocity[k]), abs(free[k]))
            if approach > NOISE * size:
                return i
            continue
        if mu[i] > 0.0 and approach <= AT_REST * max(abs(velocity[n - 2]), abs(velocity[n - 1])):
            continue
        terms = abs(free[n])
        for k in range(3 * count):
            terms += abs(W[n * stride + k] * impulse[k])
        # |u_n|/√W_nn, see pace_of.
        pace = approach / math.sqrt(nn)
        tied = TIE * most + TIE_ROUNDING * terms / math.sqrt(nn)
        if approach > ROUNDING * terms and (found < 0 or pace > most + tied):
            found, most = i, pace
    return found
