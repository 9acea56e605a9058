"""One contact in a plane under every law, to 50 digits, by closed forms.

With slip at the end of the impact every mode is tried, so that all solutions are known: none,
one, or several (Painlevé). With slip along the path (Routh 1860) the velocities are linear in
the normal impulse p between events, and each event is the root of an equation of degree one
or two:

    du_t/dp = W_tn − µ s W_tt,   du_n/dp = W_nn − µ s W_tn,   s = ±1 the direction of slip,

or with dP_t/dp = −W_tn/W_tt while it sticks.

The condition is found by moving each number that the law is given, in the same 50 digits.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from impulsekit.reference.arithmetic import Array
from impulsekit.scene import Contact, Scene

from .contact_state import ContactState
from .found import Exact, Found
from .mechanics import Mechanics, SceneMechanics
from .numbers import truth_numbers
from .phases import MOST_EVENTS, Way

# The step of the differences that give the condition, and of solutions that are the same.
STEP = 30


class PlanarImpacts:
    """The truth of a scene that stays in a plane: one contact with the world, no blow."""

    def __init__(self, scene: Scene) -> None:
        (entry,) = scene.contacts
        if not isinstance(entry, Contact):
            raise TypeError(type(entry).__name__)
        self.scene, self.entry = scene, entry
        self.mechanics = SceneMechanics(scene)

    def at(self, q: np.ndarray, v: np.ndarray) -> _State:
        """The equations at a state."""
        return _State(self, self.mechanics.at(q, v), v)


class _State(ContactState):
    """The contact problem of one state."""

    def __init__(self, owner: PlanarImpacts, mechanics: Mechanics, v: np.ndarray) -> None:
        numbers, weights = owner.mechanics.numbers, mechanics.weights
        # Of the two tangents the one that lies in the plane.
        flat = [numbers.norm(row / weights) for row in mechanics.contacts[:2]]
        super().__init__(numbers, mechanics, v, [0 if flat[0] > flat[1] else 1, 2])
        self._owner = owner
        W, u = self.W, self.u
        self._data = np.array([W[0, 0], W[0, 1], W[1, 1], u[0], u[1]], dtype=object)

    def exact(self, found: Found | None = None) -> Exact | None:
        """The solution nearest to an answer; None where the law has none."""
        given = self.impulses_of(found).ravel()[self.rows]
        solutions = self._solutions(self._data)
        if not solutions:
            return None
        best = min(solutions, key=lambda P: abs(P[0] - given[0]) + abs(P[1] - given[1]))
        dv = self.moved @ best
        slack = self._slack(best, dv)
        return Exact(dv, slack, self.m.spans, before=self.v, only=len(solutions) == 1)

    def _solutions(self, data: Array) -> list[Array]:
        entry, number = self._owner.entry, self.numbers.number
        law = self._owner.scene.law
        e, mu = number(entry.restitution), number(entry.friction)
        return planar_impulses(data, e, mu, law.restitution, law.slip)

    def _slack(self, P: Array, dv: Array) -> Array:
        """By how much relative changes of the data move Δv, to first order."""
        slack, W_size = self.first_order(P, dv)
        u_size = self.J_size @ np.abs(self.v)
        data_size = (W_size[0, 0], W_size[0, 1], W_size[1, 1], u_size[0], u_size[1])
        step = self.numbers.number(10) ** -STEP
        for i, size in enumerate(data_size):
            worst = np.abs(P) * 0
            for sign in (1, -1):
                data = self._data.copy()
                data[i] += sign * step * size
                near = self._solutions(data)
                if not near:
                    return slack / step
                nearest = min(near, key=lambda Q: abs(Q[0] - P[0]) + abs(Q[1] - P[1]))
                worst = np.maximum(worst, np.abs(nearest - P) / step)
            slack = slack + np.abs(self.moved) @ worst
        return slack


def planar_impulses(data: Any, e: Any, mu: Any, restitution: str, slip: str) -> list[Array]:
    """All impulses (P_t, P_n) that the law allows.

    Args:
        data: W_tt, W_tn, W_nn, u_t, u_n before.
        e, mu: restitution and friction.
        restitution, slip: as in ``Law``.
    """
    tt, tn, nn, ut, un = data
    zero = un - un
    if not un < 0:
        return [np.array([zero, zero], dtype=object)]
    if slip == "path":
        found = _path(tt, tn, nn, ut, un, e, mu, restitution)
        return [] if found is None else [np.array(found, dtype=object)]
    if restitution == "newton":
        return _distinct(_at_end(tt, tn, nn, ut, (1 + e) * un, mu, zero))
    both = []
    for pt, pn in _at_end(tt, tn, nn, ut, un, mu, zero):
        ut_mid, un_mid = ut + tt * pt + tn * pn, un + tn * pt + nn * pn
        for qt, qn in _at_end(tt, tn, nn, ut_mid, un_mid, mu, e * pn):
            both.append((pt + qt, pn + qn))
    return _distinct(both)


def _at_end(
    tt: Any, tn: Any, nn: Any, bt: Any, bn: Any, mu: Any, floor: Any
) -> list[tuple[Any, Any]]:
    """All P with 0 ≤ P_n − floor ⊥ ξ_n ≥ 0 and Coulomb's law, ξ = b + W P."""
    found = []
    # Held up by the floor alone, with the friction that it allows.
    pt = -(bt + tn * floor) / tt
    bound = mu * floor
    pt = max(-bound, min(bound, pt))
    if bn + tn * pt + nn * floor >= 0:
        found.append((pt, floor))
    det = tt * nn - tn * tn
    pt, pn = (tn * bn - nn * bt) / det, (tn * bt - tt * bn) / det
    if pn > floor and abs(pt) <= mu * pn:
        found.append((pt, pn))
    for s in (1, -1) if mu else (0,):
        inertia = nn - mu * s * tn
        if inertia == 0:
            continue
        pn = -bn / inertia
        if not pn > floor:
            continue
        pt = -mu * s * pn
        if not mu or s * (bt + tt * pt + tn * pn) > 0:
            found.append((pt, pn))
    return found


def _distinct(found: list[tuple[Any, Any]]) -> list[Array]:
    """The solutions that differ by more than rounding."""
    tolerance = truth_numbers().number(10) ** (-STEP - 10)
    kept: list[Array] = []
    for one in found:
        size = abs(one[0]) + abs(one[1])
        if all(
            abs(one[0] - other[0]) + abs(one[1] - other[1]) > tolerance * size for other in kept
        ):
            kept.append(np.array(one, dtype=object))
    return kept


def _path(
    tt: Any, tn: Any, nn: Any, ut: Any, un: Any, e: Any, mu: Any, law: str
) -> tuple[Any, Any] | None:
    """(P_t, P_n) of an impact followed along its normal impulse; None if it never ends."""
    now = Way.begin(truth_numbers(), ut, un, e, law)
    for _ in range(MOST_EVENTS):
        if now.ut > 0 or now.ut < 0:
            k, slips = (-mu if now.ut > 0 else mu), True
        elif abs(tn) <= mu * tt:
            k, slips = -tn / tt, False
        else:
            k, slips = (-mu if tn > 0 else mu), True
        over = now.go_straight(tn + tt * k if slips else tt * 0, nn + tn * k, k, slips)
        if over is None:
            return None
        if over and now.ends():
            return now.pt, now.pn
    return None
