"""The motion of a robot between impacts as a smooth map, and its derivative."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...scene import Scene
from ..dynamics.accelerations import Dynamics
from ..gaps.resting import RestingContact

__all__ = ["Flow", "slopes"]

# Relative and absolute tolerance of the motions that are differentiated.
RTOL, ATOL = 1e-12, 1e-13
# Of central differences, of which two are extrapolated: their error is of its fourth order,
# and forces at rest, which are found to some 1e-11, do not shake them.
STEP = 4e-4
LONGEST_FLOW = 0.5


class Flow:
    """The motion of a scene's robot while the same contacts rest.

    Args:
        scene: the scene; its impulses do not act.
        resting: names of contacts that rest. A point that sticks goes on sticking, one that
            slides goes on sliding.
    """

    def __init__(self, scene: Scene, resting: Iterable[str] = ()) -> None:
        names = frozenset(resting)
        contacts = scene.contacts if names else ()
        self._dynamics = Dynamics(replace(scene, impulses=(), contacts=contacts))
        self._model = self._dynamics.model
        of_scene = scene.entry_names("contacts")
        self._entries = [i for i, name in enumerate(of_scene) if name in names]

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) v̇ at a state of the motion itself."""
        self._begin(t, q, v)
        return np.array(self._dynamics.acceleration(t, q, v))

    def jacobian(
        self, start: float, end: float, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(2 nv, 2 nv) how the state at ``end`` [s] changes with that at ``start``, and it."""
        self._begin(start, q, v)
        total = np.eye(2 * len(v))
        pieces = max(1, int(np.ceil((end - start) * np.abs(v).max(initial=0.0) / LONGEST_FLOW)))
        times = np.linspace(start, end, pieces + 1)
        for t, until in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            part, q, v = self._piece(t, until, q, v)
            total = part @ total
        return total, q, v

    def _begin(self, t: float, q: np.ndarray, v: np.ndarray) -> None:
        """Find out which points of the resting contacts slide from here on."""
        dynamics = self._dynamics
        gaps, resting = dynamics.gaps, dynamics.resting
        if gaps is None or not self._entries:
            return
        distances, _ = gaps.everything(q, v)
        resting.contacts = []
        for entry in self._entries:
            # Of a joint's two stops the nearer one.
            own = np.flatnonzero(gaps.entries == entry)
            gap = int(own[np.abs(distances[own]).argmin()])
            friction = getattr(gaps.items[gap], "friction", 0.0)
            resting.contacts.append(RestingContact(gap, entry, friction, t))
        gaps.hold(resting.contacts, q)
        # Slip first: forces that held points which slip would contradict each other.
        resting.begin(gaps.velocities(resting.contacts, q, v))
        for _ in range(4):
            dynamics.acceleration(t, q, v)
            if not resting.update_slides(fresh=True):
                break

    def _piece(
        self, start: float, end: float, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nv, model = len(v), self._model
        still = np.zeros(2 * nv)
        q_end, v_end = self._moved(start, end, q, v, still)

        def away(by: np.ndarray) -> np.ndarray:
            ends = [self._moved(start, end, q, v, sign * by) for sign in (1.0, -1.0)]
            ways = [pin.difference(model, q_end, place) for place, _ in ends]
            return np.concatenate([ways[0] - ways[1], ends[0][1] - ends[1][1]])

        return slopes(away, np.full(2 * nv, STEP)), q_end, v_end

    def _moved(
        self, start: float, end: float, q: np.ndarray, v: np.ndarray, by: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        from scipy.integrate import solve_ivp

        nv, model = len(v), self._model
        # The chart around the start: q = q₀ ⊕ x with ẋ = ∂(q ⊖ q₀)/∂q v.
        reference = pin.integrate(model, q, by[:nv])

        def rates(t: float, y: np.ndarray) -> np.ndarray:
            place = pin.integrate(model, reference, y[:nv])
            turn = pin.dDifference(model, reference, place, pin.ArgumentPosition.ARG1)
            rate = self._dynamics.acceleration(t, place, y[nv:])
            return np.concatenate([turn @ y[nv:], rate])

        y = np.concatenate([np.zeros(nv), v + by[nv:]])
        found = solve_ivp(rates, (start, end), y, "DOP853", [end], rtol=RTOL, atol=ATOL)
        y = found.y[:, -1]
        return pin.integrate(model, reference, y[:nv]), y[nv:]


def slopes(away: Callable[[np.ndarray], np.ndarray], steps: np.ndarray) -> np.ndarray:
    """Central differences, of which two are extrapolated: their error is of fourth order.

    Args:
        away: how far the values a step (n,) before and after are apart.
        steps: (n,) by direction.
    """
    columns = []
    for step, unit in zip(steps.tolist(), np.diag(steps), strict=True):
        columns.append((8.0 * away(unit) - away(2.0 * unit)) / (12.0 * step))
    return np.array(columns).T
