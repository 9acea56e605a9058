"""One contact struck once in 3-D, in any numbers: every impulse that a law allows.

With slip at the end of the impact the contact sticks, or slips in a direction s with
ξ_t = λ s, λ ≥ 0, P_t = −µ P_n s. With P_n = −b_n / (W_nn − µ w·s) that is

    s⊥·(b_t (W_nn − µ w·s) − b_n (w − µ W_tt s)) = 0,

and on the floor of Poisson's release, P_n = f, s⊥·(b_t + f (w − µ W_tt s)) = 0. Both are of
second degree in cos θ and sin θ: a quartic in e^{iθ}, whose roots are found in doubles and
made exact by Newton. Slip along the path: see ``slip``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from impulsekit.reference import Arithmetic
from impulsekit.reference.arithmetic import Array
from impulsekit.scene import Law

from .elimination import solved_pair
from .slip import followed

# Angles of which a root in doubles may be one.
NEAR_CIRCLE = 1e-6
MOST_STEPS = 12


@dataclass(frozen=True, eq=False)
class Block:
    """The numbers of one contact, rows t₁, t₂, n.

    Attributes:
        numbers: what they are.
        W: (3, 3) Delassus matrix [1/kg].
        e, mu: restitution and friction.
    """

    numbers: Arithmetic
    W: Array
    e: Any
    mu: Any


def strikes(block: Block, u: Array, law: Law) -> list[Array]:
    """All impulses (3,) of a contact that approaches with u (3,).

    An empty list: none satisfies the law, or the impact has no end.
    """
    e, un = block.e, u[2]
    if not un < 0:
        return [u * 0]
    if law.slip == "path":
        found = followed(block.numbers, block.W, u, e, block.mu, law.restitution)
        return [] if found is None else [found]
    if law.restitution == "newton":
        b = u.copy()
        b[2] = (1 + e) * un
        return _coulomb(block, b, un * 0)
    pushes = _coulomb(block, u, un * 0)
    if not e:
        # Nothing is released: the rounding of what is at rest would be struck once more.
        return pushes
    both = []
    for pressed in pushes:
        middle = u + block.W @ pressed
        # It is where compression ends.
        middle[2] = un * 0
        both += [pressed + back for back in _coulomb(block, middle, e * pressed[2])]
    return both


def _coulomb(block: Block, b: Array, floor: Any) -> list[Array]:
    """All P with 0 ≤ P_n − floor ⊥ ξ_n ≥ 0 and Coulomb's law, ξ = b + W P."""
    W, mu, w, tt = block.W, block.mu, block.W[:2, 2], block.W[:2, :2]
    found: list[Array] = []

    def keep(pt: Array, pn: Any) -> None:
        found.append(np.array([pt[0], pt[1], pn], dtype=b.dtype))

    none = b[:2] * 0
    # Held up by the floor alone.
    at_floor = b[:2] + floor * w
    if not floor > 0 or not mu:
        slips = [none]
    else:
        pt = -solved_pair(tt, at_floor)
        held = block.numbers.norm(pt) <= mu * floor
        slips = [pt] if held else [-mu * floor * s for s in _on_floor(block, b, floor)]
    for pt in slips:
        if b[2] + w @ pt + W[2, 2] * floor >= 0:
            keep(pt, floor)
    if not mu:
        pn = -b[2] / W[2, 2]
        if pn > floor:
            keep(none, pn)
        return found
    # Sticking: the tangents solved for, then the normal.
    across = solved_pair(tt, w)
    pn = -(b[2] - across @ b[:2]) / (W[2, 2] - across @ w)
    pt = -solved_pair(tt, b[:2] + pn * w)
    if pn > floor and block.numbers.norm(pt) <= mu * pn:
        keep(pt, pn)

    def sideways(s: Array) -> Array:
        return b[:2] * (W[2, 2] - mu * (w @ s)) - b[2] * (w - mu * (tt @ s))

    for s in _directions(block.numbers, sideways):
        inertia = W[2, 2] - mu * (w @ s)
        if not inertia > 0 and not inertia < 0:
            continue
        pn = -b[2] / inertia
        if pn > floor and s @ (b[:2] + pn * (w - mu * (tt @ s))) >= 0:
            keep(-mu * pn * s, pn)
    return found


def _on_floor(block: Block, b: Array, floor: Any) -> list[Array]:
    """Directions of slip under P_n = floor."""
    w, tt, mu = block.W[:2, 2], block.W[:2, :2], block.mu

    def sideways(s: Array) -> Array:
        return b[:2] + floor * (w - mu * (tt @ s))

    return [s for s in _directions(block.numbers, sideways) if s @ sideways(s) >= 0]


def _directions(numbers: Arithmetic, sideways: Callable[[Array], Array]) -> list[Array]:
    """All unit s (2,) with s⊥·sideways(s) = 0."""

    def across(theta: Any) -> Any:
        c, s = numbers.cos(theta), numbers.sin(theta)
        x, y = sideways(np.array([c, s]))
        return c * y - s * x

    # Five values tell the five coefficients of e^{ikθ}, k = −2 … 2.
    count = 8
    angles = [2.0 * np.pi * k / count for k in range(count)]
    values = np.array([float(across(numbers.number(angle))) for angle in angles])
    waves = np.fft.fft(values) / count
    roots = np.roots([waves[2], waves[1], waves[0], waves[-1], waves[-2]])
    found: list[Any] = []
    step = numbers.sqrt(numbers.epsilon)
    for root in roots:
        if not abs(abs(root) - 1.0) < NEAR_CIRCLE:
            continue
        theta = numbers.number(float(np.angle(root)))
        for _ in range(MOST_STEPS):
            value = across(theta)
            slope = (across(theta + step) - across(theta - step)) / (2 * step)
            if slope == 0:
                break
            change = value / slope
            theta = theta - change
            if not abs(change) > numbers.epsilon * 100:
                break
        if all(abs(float(theta - other)) > NEAR_CIRCLE for other in found):
            found.append(theta)
    return [np.array([numbers.cos(theta), numbers.sin(theta)]) for theta in found]
