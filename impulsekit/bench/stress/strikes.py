"""Contacts struck one after the other under any law, each exactly; a single one among them.

The fastest approach is struck first, until none approaches. Where two are as fast but for
rounding, both orders are followed, and an answer is held against the nearest.

The condition is found by moving each number that the law is given, in doubles: it need not be
known to many digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...reference import Arithmetic
from ...reference.arithmetic import Array
from ...scene import Scene
from ..truths.elimination import generalized_inverse
from ..truths.equations import Coefficients
from ..truths.found import Exact, Found
from ..truths.mechanics import Mechanics, SceneMechanics
from ..truths.residuals import Residuals, share_of
from ..truths.strike import Block, strikes

__all__ = ["Strikes"]

# More than any sequence that ends in doubles takes down to ``AT_REST``.
MOST_HITS = 15_000
# Approaches this near to each other are struck in either order: relative, and how often.
ALIKE, MOST_ORDERS = 1e-13, 6
# Approaches this slow against the first are over.
AT_REST = 1e-22
# Of the differences that give the condition.
STEP = 1e-6


@dataclass(frozen=True, eq=False)
class _Sequence:
    """One way through: total impulses (c, 3), the contacts in order, whether it is the only one."""

    impulses: Array
    order: tuple[int, ...]
    only: bool


class Strikes:
    """The truth of a scene in sequence, or with one contact; known impulses act first."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.mechanics = SceneMechanics(scene)
        self.coefficients = Coefficients(scene, self.mechanics.numbers)

    def at(self, q: np.ndarray, v: np.ndarray) -> _State:
        """The equations at a state."""
        return _State(self, self.mechanics.at(q, v), v)


class _State:
    """The contact problem of one state."""

    def __init__(self, owner: Strikes, mechanics: Mechanics, v: np.ndarray) -> None:
        self._owner, self._m = owner, mechanics
        numbers = self._numbers = owner.mechanics.numbers
        weights = mechanics.weights
        scaled, _ = generalized_inverse(
            numbers, mechanics.masses / weights[:, None] / weights[None, :]
        )
        self._inverse = scaled / weights[:, None] / weights[None, :]
        self._moved = self._inverse @ mechanics.contacts.T
        self._v = numbers.array(v)
        self._known = self._inverse @ mechanics.known
        self._W = mechanics.contacts @ self._moved
        self._u = mechanics.contacts @ (self._v + self._known)
        self._ways: list[_Sequence] | None = None
        self._slack: Array | None = None

    def exact(self, found: Found | None = None) -> Exact | None:
        """The solution nearest to an answer; None where the law has none."""
        if self._ways is None:
            self._ways = list(self._sequences(self._numbers, self._W, self._u))
        if not self._ways:
            return None
        given = self._impulses_of(found)
        best = min(self._ways, key=lambda way: float(np.abs(way.impulses - given).sum()))
        dv = self._known + self._moved @ best.impulses.ravel()
        if self._slack is None or len(self._ways) > 1:
            self._slack = self._slack_of(best, dv)
        return Exact(dv, self._slack, self._m.spans, before=self._v, only=best.only)

    def _sequences(
        self, numbers: Arithmetic, W: Array, u: Array, order: tuple[int, ...] | None = None
    ) -> Iterator[_Sequence]:
        """All ways through, or the one in a given order."""
        scale = np.max(np.abs(u[2::3]))
        rest = scale * max(AT_REST, float(numbers.epsilon))
        # The next is the fastest by |u_n|/√W_nn, whose square is the energy that stopping it takes.
        roots = np.array(
            [numbers.sqrt(W[k, k]) or numbers.number(1.0) for k in range(2, len(u), 3)]
        )
        most = np.max(np.abs(u[2::3] / roots))
        none = np.zeros((len(u) // 3, 3), dtype=u.dtype) + u[0] * 0
        pending: list[tuple[Array, Array, tuple[int, ...], bool]] = [(u, none, (), True)]
        orders = 1
        while pending:
            velocity, impulses, hits, only = pending.pop()
            while True:
                if order is not None and len(hits) == len(order):
                    yield _Sequence(impulses, hits, only)
                    break
                normal = velocity[2::3]
                pace = np.where(normal < -rest, normal / roots, 0)
                first = int(np.argmin(pace)) if order is None else order[len(hits)]
                if order is None and not normal[first] < -rest:
                    yield _Sequence(impulses, hits, only)
                    break
                if len(hits) == MOST_HITS:
                    break
                if order is None:
                    for other in np.flatnonzero(normal < -rest).tolist():
                        alike = pace[other] <= pace[first] + most * ALIKE
                        if other != first and alike and orders < MOST_ORDERS:
                            orders += 1
                            state = self._struck(numbers, W, velocity, impulses, other)
                            if state is not None:
                                after, taken, alone = state
                                pending.append((after, taken, (*hits, other), only and alone))
                state = self._struck(numbers, W, velocity, impulses, first)
                if state is None:
                    break
                velocity, impulses, alone = state
                hits, only = (*hits, first), only and alone

    def _struck(
        self, numbers: Arithmetic, W: Array, velocity: Array, impulses: Array, i: int
    ) -> tuple[Array, Array, bool] | None:
        """Velocities and impulses after one strike, and whether the law allows no other."""
        own, coefficients = slice(3 * i, 3 * i + 3), self._owner.coefficients
        taken = impulses.copy()
        if not coefficients.mu[i]:
            # All laws are the same then, and have one answer.
            pushed = self._pushed(numbers, W, velocity, i)
            taken[i, 2] = taken[i, 2] + pushed
            return velocity + W[:, 3 * i + 2] * pushed, taken, True
        e, mu = (numbers.number(float(x)) for x in (coefficients.e[i], coefficients.mu[i]))
        found = strikes(Block(numbers, W[own, own], e, mu), velocity[own], self._owner.scene.law)
        if not found:
            return None
        taken[i] = taken[i] + found[0]
        return velocity + W[:, own] @ found[0], taken, len(found) == 1

    def _pushed(self, numbers: Arithmetic, W: Array, velocity: Array, i: int) -> Any:
        """P_n without friction."""
        k = 3 * i + 2
        if not velocity[k] < 0:
            return velocity[k] * 0
        return -(1 + numbers.number(float(self._owner.coefficients.e[i]))) * velocity[k] / W[k, k]

    def _impulses_of(self, found: Found | None) -> Array:
        impulses = self._numbers.zeros(len(self._m.axes), 3)
        if found is None or found.contacts is None:
            return impulses
        for i, given in enumerate(found.contacts):
            axes = self._m.axes[i]
            if axes is not None and np.isfinite(given).all():
                impulses[i] = axes @ self._numbers.array(given)
        return impulses

    def _slack_of(self, way: _Sequence, dv: Array) -> Array:
        """By how much relative changes of the data move Δv, to first order."""
        m = self._m
        P = way.impulses.ravel()
        sizes = m.weights * (m.weights @ np.abs(dv)) + np.abs(P) @ m.contacts_size + m.known_size
        slack = np.abs(self._inverse) @ sizes
        heavy = m.weights @ np.abs(self._moved)
        across = m.contacts_size @ np.abs(self._moved)
        W_size = np.outer(heavy, heavy) + across + across.T
        # Each velocity of a sequence is formed anew from those before it.
        gone = np.abs(self._W) @ np.abs(P)
        u_size = m.contacts_size @ (np.abs(self._v) + np.abs(self._known)) + gone
        W, u = self._W.astype(float), self._u.astype(float)
        Ws, us = [W], [u]
        struck = set(way.order)
        rows = [i for i in range(len(u)) if i % 3 == 2 or self._mu[i // 3] > 0]
        for i in rows:
            for j in [j for j in rows if j <= i] + [-1]:
                size = float(u_size[i] if j < 0 else W_size[i, j])
                # Contacts that are not struck have no part in the order.
                if not size > 0 or not {i // 3, (i if j < 0 else j) // 3} <= struck:
                    continue
                W_near, u_near = W.copy(), u.copy()
                if j < 0:
                    u_near[i] += size * STEP
                else:
                    W_near[i, j] += size * STEP
                    W_near[j, i] = W_near[i, j]
                Ws.append(W_near)
                us.append(u_near)
        totals = self._totals(np.array(Ws), np.array(us), way.order)
        if totals is None:
            return slack / STEP
        worst = np.abs(totals[1:] - totals[0]).sum(axis=0) / STEP
        return slack + np.abs(self._moved) @ self._numbers.array(worst)

    @property
    def _mu(self) -> list[Any]:
        return self._owner.coefficients.mu

    def _totals(self, W: np.ndarray, u: np.ndarray, order: tuple[int, ...]) -> np.ndarray | None:
        """(m, 3c) the impulses of m sequences in a given order, in doubles."""
        numbers = Arithmetic.double()
        if any(mu > 0 for mu in self._mu):
            ways = (self._sequences(numbers, *each, order) for each in zip(W, u, strict=True))
            totals = [next(way, None) for way in ways]
            if any(way is None for way in totals):
                return None
            return np.array([way.impulses.ravel() for way in totals if way is not None])
        # All at once.
        velocity, impulses = u.copy(), np.zeros_like(u)
        shares = [1.0 + float(e) for e in self._owner.coefficients.e]
        for i in order:
            k = 3 * i + 2
            pushed = np.maximum(-shares[i] * velocity[:, k] / W[:, k, k], 0.0)
            impulses[:, k] += pushed
            velocity += W[:, :, k] * pushed[:, None]
        return impulses

    def residuals(self, found: Found) -> Residuals:
        """What an answer leaves of M Δv = I + JᵀP; the law is judged by its solutions."""
        if found.dv is None or found.contacts is None:
            return Residuals(np.nan, np.nan)
        m = self._m
        if not np.isfinite(found.dv).all():
            return Residuals(np.inf, np.nan)
        P = self._impulses_of(found).ravel()
        dv = self._numbers.array(found.dv)
        left = np.abs(m.masses @ dv - m.known - P @ m.contacts)
        sizes = m.weights * (m.weights @ np.abs(dv)) + np.abs(P) @ m.contacts_size + m.known_size
        return Residuals(share_of(left, sizes), np.nan)
