"""How the impulse of one contact changes where slip is followed along the path.

The path of ``impulsekit.laws.path`` once more, with what twelve parameters do to
it: on every stretch by the equation of variations, and at what ends a stretch by that the
end itself moves, δτ = −δg/ġ for an event g = 0.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...laws.path import STOPPED, outgoing
from ...laws.progress import Block
from ...laws.tolerances import SINGULAR
from .modes import EDGE

__all__ = ["PARAMETERS", "PathDerivative", "path_derivative"]

# The path ends long before [N s]; relative and absolute error along it; least scale of velocities.
LONGEST, RTOL, ATOL, LEAST = 1e12, 1e-12, 1e-14, 1e-3
# W: t1t1, t1t2, t2t2, t1n, t2n, nn; the velocity at the start; u_n⁻, e and µ.
PARAMETERS = 12
_N1, _N2, _NN = 3, 4, 5
_U1, _U2, _UN, _BEFORE, _E, _MU = 6, 7, 8, 9, 10, 11
# Entries of a state: u, then P, then the work of the normal impulse.
U1, U2, UN, P1, P2, P, WORK = range(7)
FAINT = math.log(1e-14)
MOST_STRETCHES = 200
# A stretch of slip takes some thousand evaluations; one that goes on has no end.
MOST_EVALUATIONS = 100_000
# Where (θ, ln r, p, u_n, P_1, P_2, work) have entries of a state as they are.
_CARRIED = ((2, P), (3, UN), (4, P1), (5, P2), (6, WORK))
# By the first five parameters: ∂W_tt (5, 2, 2) and ∂W_tn (5, 2).
_TANGENTS, _COUPLED = np.zeros((5, 2, 2)), np.zeros((5, 2))
_TANGENTS[0, 0, 0] = _TANGENTS[1, 0, 1] = _TANGENTS[1, 1, 0] = _TANGENTS[2, 1, 1] = 1.0
_COUPLED[_N1, 0] = _COUPLED[_N2, 1] = 1.0


@dataclass(frozen=True, eq=False)
class PathDerivative:
    """P (3,), its derivatives (3, 12), and why a small change may lead another way."""

    impulse: np.ndarray
    table: np.ndarray
    edges: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Event:
    """g(y, θ): its value and its derivatives by the state (7,) and the parameters (12,)."""

    value: Callable[[np.ndarray], float]
    by_state: np.ndarray
    by_parameter: np.ndarray

    def shift(self, table: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """(12,) how the event moves."""
        return -(self.by_state @ table + self.by_parameter) / (self.by_state @ rates)


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
    return _Path(block, free, before, e, mu, law).follow()


class _Path:
    """One path; ``y`` (7,) is the state, ``table`` (7, 12) what the parameters do to it."""

    def __init__(
        self, block: Block, free: Sequence[float], before: float, e: float, mu: float, law: str
    ) -> None:
        t11, t12, t22, n1, n2, nn = block
        self.tangents = np.array(((t11, t12), (t12, t22)))
        self.coupling, self.nn = np.array((n1, n2)), nn
        self.mu, self.e, self.law, self.before = mu, e, law, before
        self.y = np.array([*free, 0.0, 0.0, 0.0, 0.0])
        self.table = np.zeros((7, PARAMETERS))
        self.table[:3, _U1 : _UN + 1] = np.eye(3)
        self.scale = max(abs(before), *map(abs, free))
        self.compressing = True
        self.pressed, self.spent = 0.0, 0.0
        self.by_pressed, self.by_spent = np.zeros(PARAMETERS), np.zeros(PARAMETERS)
        self.edges: list[str] = []

    def follow(self) -> PathDerivative:
        """To the end."""
        if self.mu and 0.0 < self._speed() <= EDGE * self.scale:
            self.edges.append("it hardly slips when it meets")
        for _ in range(MOST_STRETCHES):
            if self.y[UN] >= 0.0 and self.compressing:
                break
            sliding = self.mu > 0.0 and self._speed() > STOPPED * self.scale
            ended = self._slide() if sliding else self._straight()
            if ended and self._phase_over():
                return PathDerivative(
                    self.y[P1 : P + 1].copy(), self.table[P1 : P + 1], tuple(self.edges)
                )
        raise InputError("derivatives: the path of this impact does not come to an end")

    # -- phases -----------------------------------------------------------------------

    def _event(self) -> _Event:
        """What ends the phase at hand."""
        by_state, by_parameter = np.zeros(7), np.zeros(PARAMETERS)
        if self.compressing:
            by_state[UN] = 1.0
            return _Event(lambda y: float(y[UN]), by_state, by_parameter)
        if self.law == "newton":
            target = max(0.0, -self.e * self.before)
            by_state[UN] = 1.0
            if self.before < 0.0:
                by_parameter[_BEFORE], by_parameter[_E] = self.e, self.before
            return _Event(lambda y: float(y[UN]) - target, by_state, by_parameter)
        if self.law == "poisson":
            goal = (1.0 + self.e) * self.pressed
            by_state[P] = 1.0
            by_parameter -= (1.0 + self.e) * self.by_pressed
            by_parameter[_E] -= self.pressed
            return _Event(lambda y: float(y[P]) - goal, by_state, by_parameter)
        share = 1.0 - self.e**2
        done = share * self.spent
        by_state[WORK] = 1.0
        by_parameter -= share * self.by_spent
        by_parameter[_E] += 2.0 * self.e * self.spent
        return _Event(lambda y: float(y[WORK]) - done, by_state, by_parameter)

    def _phase_over(self) -> bool:
        """Go over to restitution; whether the impact is over."""
        if self.mu and STOPPED * self.scale < self._speed() <= EDGE * self.scale:
            self.edges.append("slip ends just as the compression or the impact does")
        if not self.compressing:
            return True
        self.compressing = False
        self.y[UN], self.table[UN] = 0.0, 0.0
        self.pressed, self.by_pressed = float(self.y[P]), self.table[P].copy()
        self.spent, self.by_spent = float(self.y[WORK]), self.table[WORK].copy()
        if self.law == "newton" and self.before >= 0.0:
            return True
        if self.e > 0.0:
            return False
        # Nothing comes back, but a little e would bring a little.
        rates = self._rates_now()
        if self.law == "stronge":
            by_e = np.zeros(PARAMETERS)
            if rates[UN] > 0.0:
                by_e[_E] = math.sqrt(-2.0 * self.spent / rates[UN])
            self.table = self.table + np.outer(rates, by_e)
        else:
            self.table = self.table + np.outer(rates, self._event().shift(self.table, rates))
        return True

    # -- stretches ---------------------------------------------------------------------

    def _speed(self) -> float:
        return math.hypot(self.y[U1], self.y[U2])

    def _rates_now(self) -> np.ndarray:
        """(7,) dy/dp."""
        if self.mu and self._speed() > STOPPED * self.scale:
            return self._rates_of(self.y[:2] / self._speed())
        return self._held_or_outgoing()[0]

    def _rates_of(self, s: np.ndarray) -> np.ndarray:
        across = self.coupling - self.mu * (self.tangents @ s)
        lift = self.nn - self.mu * float(self.coupling @ s)
        return np.array([*across, lift, *(-self.mu * s), 1.0, self.y[UN]])

    def _held_or_outgoing(self) -> tuple[np.ndarray, np.ndarray]:
        """(7,) dy/dp where slip has ended or friction is none, and (7, 12) its derivatives."""
        table = np.zeros((7, PARAMETERS))
        if not self.mu:
            rates = np.array([*self.coupling, self.nn, 0.0, 0.0, 1.0, self.y[UN]])
            table[:3, _N1 : _NN + 1] = np.eye(3)
            return rates, table
        inverse = np.linalg.pinv(self.tangents, rcond=SINGULAR, hermitian=True)
        k = -inverse @ self.coupling
        length = float(np.hypot(*k))
        if abs(length - self.mu) <= EDGE * self.mu:
            self.edges.append("what has stuck is at the edge of its cone")
        if length <= self.mu:
            rise = self.nn + float(self.coupling @ k)
            rates = np.array(
                [0.0, 0.0, rise if rise > SINGULAR * self.nn else 0.0, *k, 1.0, self.y[UN]]
            )
            by_k = -inverse @ (_COUPLED + _TANGENTS @ k).T
            table[P1 : P2 + 1, :5] = by_k
            table[UN, :5] = _COUPLED @ k + self.coupling @ by_k
            table[UN, _NN] += 1.0
            return rates, table
        (t11, t12), (_, t22) = self.tangents.tolist()
        n1, n2 = self.coupling.tolist()
        s = np.array(outgoing((t11, t12, t22, n1, n2, self.nn), self.mu))
        along = float(s @ (self.coupling - self.mu * self.tangents @ s))
        # (λ + µ W_tt) s = w and |s| = 1 say how s turns.
        system = np.zeros((3, 3))
        system[:2, :2] = along * np.eye(2) + self.mu * self.tangents
        system[:2, 2], system[2, :2] = s, s
        given = np.vstack([self._by_parameter(s)[0], np.zeros(PARAMETERS)])
        return self._rates_of(s), self._change_of_rates(s, np.linalg.solve(system, given)[:2])

    def _by_parameter(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(2, 12) of w − µ W_tt s and (12,) of W_nn − µ w·s, in a direction s (2,) that keeps."""
        across, lift = np.zeros((2, PARAMETERS)), np.zeros(PARAMETERS)
        across[:, :5] = (_COUPLED - self.mu * _TANGENTS @ s).T
        across[:, _MU] = -self.tangents @ s
        lift[:5] = -self.mu * (_COUPLED @ s)
        lift[_NN], lift[_MU] = 1.0, -self.coupling @ s
        return across, lift

    def _change_of_rates(self, s: np.ndarray, turning: np.ndarray) -> np.ndarray:
        """(7, 12) of dy/dp in direction s (2,), which itself changes by ``turning`` (2, 12)."""
        table = np.zeros((7, PARAMETERS))
        across, lift = self._by_parameter(s)
        table[:2] = across - self.mu * self.tangents @ turning
        table[UN] = lift - self.mu * self.coupling @ turning
        table[P1 : P2 + 1] = -self.mu * turning
        table[P1 : P2 + 1, _MU] -= s
        return table

    def _straight(self) -> bool:
        """A stretch of rates that keep, to the end of the phase."""
        if self.mu:
            self.y[:2], self.table[:2] = 0.0, 0.0
        rates, by_parameter = self._held_or_outgoing()
        lift, un = float(rates[UN]), float(self.y[UN])
        event = self._event()
        left = -event.value(self.y)
        if event.by_state[UN]:
            step = left / lift if lift > 0.0 else math.inf
        elif event.by_state[P]:
            step = left
        else:
            root = un * un + 2.0 * lift * left
            below = un + math.sqrt(max(root, 0.0))
            step = 2.0 * left / below if root >= 0.0 and below > 0.0 else math.inf
        falls_back = not self.compressing and lift < 0.0 and step > -un / lift
        if step == math.inf or falls_back:
            raise InputError(
                "derivatives: friction holds all that moves, or draws the contact in again "
                "(Painlevé); there the impulse has no derivative of this kind"
            )
        step = max(step, 0.0)
        table = self.table + step * by_parameter
        table[WORK] = self.table[WORK] + step * self.table[UN] + 0.5 * step**2 * by_parameter[UN]
        self.y = self.y + step * rates
        self.y[WORK] += 0.5 * step**2 * lift
        rates = rates.copy()
        rates[WORK] = self.y[UN]
        self.table = table + np.outer(rates, event.shift(table, rates))
        return True

    def _slide(self) -> bool:
        """A stretch of slip; whether it went to the end of the phase, else slip has ended.

        In τ with dp = r dτ all is smooth down to r = |u_t| = 0, which lies at τ → ∞.
        """
        from scipy.integrate import solve_ivp

        first, event = self._speed(), self._event()
        inertia = float(np.abs(self.coupling).sum() + self.mu * np.trace(self.tangents) + self.nn)

        evaluations = itertools.count()

        def both(_: float, z: np.ndarray) -> np.ndarray:
            if next(evaluations) > MOST_EVALUATIONS:
                raise InputError("derivatives: the slip of this impact does not come to an end")
            return self._variations(z, first, inertia)

        def ends(_: float, z: np.ndarray) -> float:
            return event.value(_state_of(z, first))

        def stops(_: float, z: np.ndarray) -> float:
            return float(z[1]) - FAINT

        def back(_: float, z: np.ndarray) -> float:
            return float(z[3]) if not self.compressing else -1.0

        ends.terminal, ends.direction = True, 1.0  # type: ignore[attr-defined]
        stops.terminal, stops.direction = True, -1.0  # type: ignore[attr-defined]
        back.terminal, back.direction = True, -1.0  # type: ignore[attr-defined]
        # States lie together, then each parameter's.
        found = solve_ivp(
            both,
            (0.0, LONGEST),
            self._begin_to_slide(first).T.ravel(),
            "DOP853",
            rtol=RTOL,
            atol=ATOL * max(self.scale, self.scale / inertia, LEAST),
            events=(ends, stops, back),
        )
        if not found.success or len(found.t_events[2]):
            raise InputError(
                "derivatives: friction draws the contact in again (Painlevé); there the impulse "
                "has no derivative of this kind"
            )
        z = found.y[:, -1]
        reached = len(found.t_events[0]) > 0
        rates = both(0.0, z)[:7]
        table = z[7:].reshape(PARAMETERS, 7).T
        if reached:
            # What is left to the event is of the size of an integration error.
            whole = self._as_state(rates, z, first * math.exp(z[1]))
            step = -event.value(_state_of(z, first)) / float(event.by_state @ whole)
            z = z.copy()
            z[:7] += step * rates
        self.y = _state_of(z, first)
        self.table = np.zeros((7, PARAMETERS))
        for place, entry in _CARRIED:
            self.table[entry] = table[place]
        if not reached:
            self.y[:2] = 0.0
            return False
        r = first * math.exp(z[1])
        s, across = _directions(z[0])
        self.table[:2] = r * (np.outer(s, table[1]) + np.outer(across, table[0]))
        whole = self._as_state(rates, z, r)
        self.table = self.table + np.outer(whole, event.shift(self.table, whole))
        return True

    def _begin_to_slide(self, first: float) -> np.ndarray:
        """(7, 13) of (θ, ln r, p, u_n, P_1, P_2, work): the state, and by each parameter."""
        s = self.y[:2] / first
        across = np.array((-s[1], s[0]))
        start = np.zeros((7, 1 + PARAMETERS))
        start[0, 0] = math.atan2(s[1], s[0])
        start[0, 1:] = across @ self.table[:2] / first
        start[1, 1:] = s @ self.table[:2] / first
        for place, entry in _CARRIED:
            start[place, 0], start[place, 1:] = self.y[entry], self.table[entry]
        return start

    def _as_state(self, rates: np.ndarray, z: np.ndarray, r: float) -> np.ndarray:
        """(7,) rates of a state, out of those of (θ, ln r, p, u_n, P_1, P_2, work)."""
        s, across = _directions(z[0])
        moving = r * (s * rates[1] + across * rates[0])
        return np.array([*moving, rates[3], rates[4], rates[5], rates[2], rates[6]])

    def _variations(self, z: np.ndarray, first: float, inertia: float) -> np.ndarray:
        """Rates in τ of the state and, behind it, of what each parameter does to it."""
        angle, log, _, un = z[:4].tolist()
        mu, tangents, w = self.mu, self.tangents, self.coupling
        s, across = _directions(angle)
        r = first * math.exp(log)
        g = w - mu * (tangents @ s)
        g_turn = -mu * (tangents @ across)
        lift, lift_turn = self.nn - mu * float(w @ s), -mu * float(w @ across)
        turn, grow = float(across @ g), float(s @ g)
        rates = np.array([turn, grow, r, r * lift, -mu * r * s[0], -mu * r * s[1], r * un])
        # By the state: only θ, ln r and u_n matter.
        slope = np.zeros((7, 7))
        slope[0, 0] = -grow + float(across @ g_turn)
        slope[1, 0] = turn + float(s @ g_turn)
        slope[3, 0] = r * lift_turn
        slope[4:6, 0] = -mu * r * across
        slope[2:, 1] = rates[2:]
        slope[6, 3] = r
        by_parameter = np.zeros((7, PARAMETERS))
        by_g, by_lift = self._by_parameter(s)
        by_parameter[0], by_parameter[1], by_parameter[3] = across @ by_g, s @ by_g, r * by_lift
        by_parameter[4:6, _MU] = -r * s
        change_of_table = slope @ z[7:].reshape(PARAMETERS, 7).T + by_parameter
        return np.concatenate([rates, change_of_table.T.ravel()]) / inertia


def _state_of(z: np.ndarray, first: float) -> np.ndarray:
    """(7,) the state at (θ, ln r, p, u_n, P_1, P_2, work), r over the first speed of slip."""
    r = first * math.exp(z[1])
    turn = (r * math.cos(z[0]), r * math.sin(z[0]))
    return np.array([*turn, z[3], z[4], z[5], z[2], z[6]])


def _directions(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """(2,) along the slip, and (2,) across it."""
    s = np.array((math.cos(angle), math.sin(angle)))
    return s, np.array((-s[1], s[0]))
