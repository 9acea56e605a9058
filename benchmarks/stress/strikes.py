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

from benchmarks.truths.contact_state import ContactState
from benchmarks.truths.equations import Coefficients
from benchmarks.truths.found import Exact, Found
from benchmarks.truths.mechanics import Mechanics, SceneMechanics
from benchmarks.truths.strike import Block, strikes
from impulsekit.reference import Arithmetic
from impulsekit.reference.arithmetic import Array
from impulsekit.scene import Scene

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


class _State(ContactState):
    """The contact problem of one state."""

    def __init__(self, owner: Strikes, mechanics: Mechanics, v: np.ndarray) -> None:
        super().__init__(owner.mechanics.numbers, mechanics, v)
        self._owner = owner
        self._ways: list[_Sequence] | None = None
        self._slack: Array | None = None

    def exact(self, found: Found | None = None) -> Exact | None:
        """The solution nearest to an answer; None where the law has none."""
        if self._ways is None:
            self._ways = list(self._sequences(self.numbers, self.W, self.u))
        if not self._ways:
            return None
        given = self.impulses_of(found)
        best = min(self._ways, key=lambda way: float(np.abs(way.impulses - given).sum()))
        dv = self.known + self.moved @ best.impulses.ravel()
        if self._slack is None or len(self._ways) > 1:
            self._slack = self._slack_of(best, dv)
        return Exact(dv, self._slack, self.m.spans, before=self.v, only=best.only)

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

    def _slack_of(self, way: _Sequence, dv: Array) -> Array:
        """By how much relative changes of the data move Δv, to first order."""
        P = way.impulses.ravel()
        slack, W_size = self.first_order(P, dv)
        # Each velocity of a sequence is formed anew from those before it.
        gone = np.abs(self.W) @ np.abs(P)
        u_size = self.J_size @ (np.abs(self.v) + np.abs(self.known)) + gone
        W, u = self.W.astype(float), self.u.astype(float)
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
        return slack + np.abs(self.moved) @ self.numbers.array(worst)

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
