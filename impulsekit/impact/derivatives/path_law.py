"""How the impulse of one contact changes where slip is followed along the path.

The path of ``impulsekit.laws.path`` on numbers that carry their derivatives by twelve parameters:
what ends a stretch moves with them, and so does all that follows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...errors import InputError
from ...laws import path, progress, taylor
from ...laws.path import STOPPED
from ...laws.progress import (
    COMPRESSING,
    ORDER,
    P1,
    P2,
    PRESSED,
    REGAINED,
    SPENT,
    U1,
    U2,
    UN,
    Block,
    P,
    PathMemory,
    path_memory,
)
from ...laws.taylor import FAINT_SLIP
from ...laws.tolerances import SINGULAR
from ...laws.words import NEWTON, POISSON
from ...scene.law import RESTITUTIONS
from .duals import Dual, on_duals, value_of
from .modes import EDGE

__all__ = ["PARAMETERS", "PathDerivative", "path_derivative"]

# W: t1t1, t1t2, t2t2, t1n, t2n, nn; the velocity at the start; u_n⁻, e and µ.
PARAMETERS = 12
_E = 10
# Of slip that turns, however slowly, the direction may change: below any rate.
ALWAYS_TURNS = -1.0


@dataclass(frozen=True, eq=False)
class PathDerivative:
    """P (3,), its derivatives (3, 12), and why a small change may lead another way."""

    impulse: np.ndarray
    table: np.ndarray
    edges: tuple[str, ...]


def path_derivative(
    block: Block, free: Sequence[float], before: float, e: float, mu: float, law: str
) -> PathDerivative:
    """The impulse of one contact and its derivatives.

    Args:
        block: W [1/kg].
        free: (3,) the velocity at the start [m/s], which approaches.
        before: u_n⁻ [m/s], of which Newton's law wants −e back.
        e, mu: restitution and friction.
        law: "newton", "poisson" or "stronge".

    Raises:
        InputError: friction presses the contact in again, or holds all that moves.
    """
    if not any(block):
        # Of what is held fast the approach is rounding, and no impulse changes it.
        return PathDerivative(np.zeros(3), np.zeros((3, PARAMETERS)), ())
    numbers, units = (*block, *free, before, e, mu), np.eye(PARAMETERS)
    x = [Dual(float(number), unit) for number, unit in zip(numbers, units, strict=True)]
    watch = _Watch(mu, max(abs(before), *map(abs, free)))
    if mu and 0.0 < math.hypot(free[0], free[1]) <= EDGE * watch.scale:
        watch.edges.append("it hardly slips when it meets")
    plain = path_memory()
    memory = PathMemory(plain.now.astype(object), plain.series.astype(object))
    now = memory.now
    now[U1], now[U2], now[UN], now[COMPRESSING] = *x[6:9], 1.0 if free[2] < 0.0 else 0.0
    restitution = RESTITUTIONS.index(law)
    target = -x[10] * x[9] if restitution == NEWTON and before < 0.0 else 0.0
    way = tuple(x[:6]), memory, x[11], restitution, x[10], target, watch.scale
    over, _ = on_duals(path._run, watch.instead)(*way)
    if not over:
        raise InputError("derivatives: the path of this impact does not come to an end")
    found = [now[k] if isinstance(now[k], Dual) else 0.0 * x[0] + now[k] for k in (P1, P2, P)]
    table = np.array([number.by for number in found])
    if e == 0.0 and not (restitution == NEWTON and before >= 0.0):
        table[:, _E] += _first_restitution(block, before, mu, restitution, now, watch.scale)
    impulse = np.array([number.value for number in found])
    return PathDerivative(impulse, table, tuple(dict.fromkeys(watch.edges)))


def _first_restitution(
    block: Block, before: float, mu: float, restitution: int, now: np.ndarray, scale: float
) -> np.ndarray:
    """(3,) ∂P/∂e at e = 0: nothing comes back, but a little e would bring a little."""
    end = np.array([value_of(number) for number in now])
    speed = math.hypot(end[U1], end[U2])
    if mu and speed > STOPPED * scale:
        s1, s2 = end[U1] / speed, end[U2] / speed
        lift, rates = block[5] - mu * (block[3] * s1 + block[4] * s2), (-mu * s1, -mu * s2, 1.0)
    else:
        _, (_, _, lift, k1, k2) = path._heading(block, end, mu, scale)
        rates = k1, k2, 1.0
    if restitution == NEWTON:
        more = -before / lift
    elif restitution == POISSON:
        more = end[PRESSED]
    else:
        more = math.sqrt(-2.0 * end[SPENT] / lift) if lift > 0.0 else 0.0
    return more * np.array(rates)


@dataclass(eq=False)
class _Watch:
    """What is looked at while a path is followed, and what of it has its own derivative.

    Attributes:
        mu: friction. scale: the size of the velocities [m/s].
        edges: why a small change may lead another way.
        compressed: whether a compression has ended.
    """

    mu: float
    scale: float
    edges: list[str] = field(default_factory=list)
    compressed: bool = False

    @property
    def instead(self) -> dict[str, Any]:
        """What stands in place of functions and thresholds of the law."""
        return {
            "STRAIGHT": ALWAYS_TURNS,
            "_holding": self.holding,
            "_root": root,
            "_straight": self.straight,
            "is_over": self.is_over,
            "outgoing": outgoing,
            "turn": self.turn,
        }

    def is_over(self, now: np.ndarray, *law: Any) -> bool:
        """As ``progress.is_over``."""
        if self.mu and STOPPED * self.scale < _slip(now) <= EDGE * self.scale:
            self.edges.append("slip ends just as the compression or the impact does")
        if now[COMPRESSING] > 0.0:
            if self.compressed:
                raise _painleve()
            self.compressed = True
        return progress.is_over(now, *law)

    def turn(self, block: Any, memory: PathMemory, *given: Any) -> bool:
        """As ``taylor.turn``."""
        now = memory.now
        first = FAINT_SLIP * _slip(now)

        def step(*parts: Any) -> bool:
            reached = on_duals(taylor._step, {"_root": root})(*parts)
            if not reached and _slip(now) <= first:
                _stop(block, now, self.mu)
            return bool(reached)

        turn = on_duals(taylor.turn, {**self.instead, "_step": step})
        return bool(turn(block, memory, *given))

    def straight(self, *given: Any) -> tuple[bool, bool]:
        """As ``path._straight``."""
        over, wedged = on_duals(path._straight, {"is_over": self.is_over})(*given)
        if wedged:
            raise _painleve()
        return over, wedged

    def holding(self, block: Any) -> tuple[Any, Any]:
        """As ``path._holding``."""
        k1, k2 = on_duals(path._holding, {})(block)
        if abs(math.hypot(value_of(k1), value_of(k2)) - self.mu) <= EDGE * self.mu:
            self.edges.append("what has stuck is at the edge of its cone")
        return k1, k2


def _slip(now: np.ndarray) -> float:
    return math.hypot(value_of(now[U1]), value_of(now[U2]))


def _stop(block: Any, now: np.ndarray, mu: float) -> None:
    """Bring all that the parameters make of u_t to rest, where slip is about to end.

    Across the slip it may shrink more slowly than the slip itself: W_tt ∂P_t + w ∂p = −∂u_t, with
    s·∂P_t = −µ ∂p, brings the rest.
    """
    t11, t12, t22, n1, n2, nn = map(value_of, block)
    left = np.array([now[U1].by, now[U2].by, 0.0 * now[U1].by])
    slip = _slip(now)
    if slip == 0.0:
        return
    s1, s2 = now[U1].value / slip, now[U2].value / slip
    system = np.array(((t11, t12, n1), (t12, t22, n2), (s1, s2, mu)))
    p1, p2, p = np.linalg.lstsq(system, -left, rcond=SINGULAR)[0]
    un = value_of(now[UN])
    now[P1], now[P2], now[P] = (
        now[P1] + Dual(0.0, p1),
        now[P2] + Dual(0.0, p2),
        now[P] + Dual(0.0, p),
    )
    now[UN] += Dual(0.0, n1 * p1 + n2 * p2 + nn * p)
    now[SPENT if now[COMPRESSING] > 0.0 else REGAINED] += Dual(0.0, un * p)
    if now[COMPRESSING] > 0.0:
        now[PRESSED] += Dual(0.0, p)


def _painleve() -> InputError:
    return InputError(
        "derivatives: friction holds all that moves, or draws the contact in again (Painlevé); "
        "there the impulse has no derivative of this kind"
    )


def root(series: np.ndarray, row: int, goal: Any, high: Any) -> Dual:
    """As ``taylor._root``: x with p(x) = g moves by (∂g − ∂p)/p'."""
    plain = np.array([[value_of(number) for number in series[row]]])
    x = taylor._root(plain, 0, value_of(goal), value_of(high))
    slope = sum(k * plain[0, k] * x ** (k - 1) for k in range(1, ORDER + 1))
    missing = goal - on_duals(taylor._at, {})(series, row, x)
    return Dual(x, missing.by / slope if slope else 0.0 * missing.by)


def outgoing(block: Any, mu: Dual) -> tuple[Dual, Dual]:
    """As ``path.outgoing``: (λ + µ W_tt) s = w and |s| = 1 say how s turns."""
    t11, t12, t22, n1, n2, nn = block
    plain = t11.value, t12.value, t22.value, n1.value, n2.value, nn.value
    s1, s2 = path.outgoing(plain, mu.value)
    given = n1 - mu * (t11 * s1 + t12 * s2), n2 - mu * (t12 * s1 + t22 * s2)
    along = s1 * given[0].value + s2 * given[1].value
    tangents = mu.value * np.array(((t11.value, t12.value), (t12.value, t22.value)))
    system = np.zeros((3, 3))
    system[:2, :2] = along * np.eye(2) + tangents
    system[:2, 2], system[2, :2] = (s1, s2), (s1, s2)
    turning = np.linalg.solve(system, np.array([given[0].by, given[1].by, 0.0 * mu.by]))
    return Dual(s1, turning[0]), Dual(s2, turning[1])
