"""Which contact of a sequence is hit next."""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .tolerances import AT_REST

__all__ = ["NOISE", "Traits", "fastest", "foremost", "pace_of"]

# The same against the terms of u_free + W P, whose rounding it is.
PACE_ROUNDING = 4.5e-16
# Paces that differ by less than the first share of themselves, or the second of their terms, are
# one: contacts of a pair with one relative motion all have the same, and rounding is not to say
# which is hit. The entry that stands first is.
TIE, TIE_ROUNDING = 1e-12, 1e-14
# Paces that differ by less than this share were the same before rounding, and so were numbers of
# two contacts that differ by less than the second.
EVEN, ALIKE = 1e-11, 1e-9
# Paces that differ by more than this share are two, whatever their rounding: small hits that
# others hand on would not be told from each other, and the largest would wait.
PACES_APART = 0.1
# Where W_nn is this small against W of the contact's own tangents, or against the largest W,
# it is the square of a rounding error: no normal impulse moves that contact.
IMMOVABLE, IMMOVABLE_BESIDE = 1e-26, 1e-24
# What such a contact may approach against all velocities, by rounding alone.
NOISE = 1e-12

# µ, e, |W_nt|/W_nn, (W_11 + W_22)/W_nn and |u_t|/|u_n| of a contact.
Traits = tuple[float, float, float, float, float]


@borrowing
def pace_of(normal_velocity: float, nn: float) -> float:
    """|u_n|/√W_nn [√J]: the approach in one unit for contacts [m/s] and joint stops [rad/s].

    Half its square is the energy that the contact loses when it is stopped.
    """
    return abs(normal_velocity) / math.sqrt(nn)


@borrowing
def fastest(
    W: np.ndarray,
    velocity: np.ndarray,
    free: np.ndarray,
    impulse: np.ndarray,
    mu: np.ndarray,
    scale: float,
    count: int,
) -> int:
    """The contact that approaches fastest by |u_n|/√W_nn; −1 where none approaches.

    Of several that are equally fast it is the first; ``foremost`` knows better. A contact that
    no impulse moves comes before all others where it approaches by more than rounding.

    Args:
        W: Delassus matrix [1/kg].
        velocity: (3 count,) of the contacts now [m/s].
        free: (3 count,) u_free [m/s].
        impulse: (3 count,) P so far [N s].
        mu: (count,) friction.
        scale: the size of the velocities where they were larger before [m/s].
        count: how many contacts.
    """
    found, most = -1, 0.0
    largest = 0.0
    for k in range(3 * count):
        largest = max(largest, W[k, k])
    for i in range(count):
        n = 3 * i + 2
        approach = -velocity[n]
        if not approach > 0.0:
            continue
        nn = W[n, n]
        tangents = max(W[n - 2, n - 2], W[n - 1, n - 1])
        if nn <= IMMOVABLE * tangents or nn <= IMMOVABLE_BESIDE * largest:
            size = scale
            for k in range(3 * count):
                size = max(size, abs(velocity[k]), abs(free[k]))
            if approach > NOISE * size:
                return i
            continue
        if mu[i] > 0.0 and approach <= AT_REST * max(abs(velocity[n - 2]), abs(velocity[n - 1])):
            continue
        terms = _terms(W, free, impulse, n, count)
        pace = pace_of(approach, nn)
        tied = TIE * most + TIE_ROUNDING * terms / math.sqrt(nn)
        if approach > PACE_ROUNDING * terms and (found < 0 or pace > most + tied):
            found, most = i, pace
    return found


@borrowing
def _terms(W: np.ndarray, free: np.ndarray, impulse: np.ndarray, n: int, count: int) -> float:
    """The terms that row n of u_free + W P is the sum of, added up as if nothing cancelled."""
    terms: float = abs(free[n])
    for k in range(3 * count):
        terms += abs(W[n, k] * impulse[k])
    return terms


@borrowing
def foremost(
    found: int,
    W: np.ndarray,
    velocity: np.ndarray,
    free: np.ndarray,
    impulse: np.ndarray,
    e: np.ndarray,
    mu: np.ndarray,
) -> tuple[int, bool]:
    """Of the contacts as fast as ``found``, the one that is hit first; whether others are alike.

    It is the one of most friction, then of most restitution, then the one that a normal impulse
    moves most sideways, then the one that moves most easily sideways, then the one that slips
    most: what no unit, axis or order of entries changes. Where they are alike in all of it, as
    corners of a box that falls flat, it is the first entry. Arguments as of ``fastest``.
    """
    nn, count = W[3 * found + 2, 3 * found + 2], len(mu)
    if not nn > 0.0:
        return found, False
    pace = pace_of(velocity[3 * found + 2], nn)
    at, root = 3 * found + 2, math.sqrt(nn)
    best, tied, known = found, False, False
    traits = (0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(count):
        n = 3 * i + 2
        nn = W[n, n]
        if i == found or not (velocity[n] < 0.0 and nn > 0.0):
            continue
        apart = abs(pace_of(velocity[n], nn) - pace)
        if apart > PACES_APART * pace:
            continue
        # After many hits what is left is small, and its rounding is that of what it was.
        terms = _terms(W, free, impulse, at, count) / root
        terms += _terms(W, free, impulse, n, count) / math.sqrt(nn)
        if apart > EVEN * pace + TIE_ROUNDING * terms:
            continue
        if not known:
            known, traits = True, _traits(found, W, velocity, e, mu)
        others = _traits(i, W, velocity, e, mu)
        apart = 0.0
        for k in range(5):
            if apart == 0.0 and abs(others[k] - traits[k]) > ALIKE * (others[k] + traits[k]):
                apart = others[k] - traits[k]
        if apart == 0.0:
            tied = True
        elif apart > 0.0:
            best, tied, traits = i, False, others
    return best, tied


@borrowing
def _traits(i: int, W: np.ndarray, velocity: np.ndarray, e: np.ndarray, mu: np.ndarray) -> Traits:
    n = 3 * i + 2
    nn = W[n, n]
    return (
        mu[i],
        e[i],
        math.hypot(W[n, n - 2], W[n, n - 1]) / nn,
        (W[n - 2, n - 2] + W[n - 1, n - 1]) / nn,
        math.hypot(velocity[n - 2], velocity[n - 1]) / abs(velocity[n]),
    )
