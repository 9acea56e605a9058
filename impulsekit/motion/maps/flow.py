"""The motion of a robot between impacts as a smooth map, and its derivative."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ..._core import DynamicsFailure, ForcesOfMotion, RestingState
from ...errors import InputError
from ...scene import Scene
from ...scene.motion import MotionSettings
from ..flat import flat_motion
from ..start import core_of

__all__ = ["Flow", "slopes"]

# Relative and absolute tolerance of the motions that are differentiated.
RTOL, ATOL = 1e-12, 1e-13
# Of central differences, of which two are extrapolated: their error is of its fourth order,
# and forces at rest, which are found to some 1e-11, do not shake them.
STEP = 4e-4
LONGEST_FLOW = 0.5
# Slip below this has no direction [m/s].
NO_WAY = 1e-5
NO_MOTION = (
    "no acceleration is found: it is not finite, or contacts at rest have no solution; use finite "
    "differences of simulate"
)


class Flow:
    """The motion of a scene's robot while the same contacts rest.

    Args:
        scene: the scene; its impulses do not act.
        resting: names of contacts that rest. A point that sticks goes on sticking, one that
            slides goes on sliding.

    Attributes:
        controls: (nv,) torques from outside [N m, N], or none.
    """

    controls = np.zeros(0)

    def __init__(self, scene: Scene, resting: Iterable[str] = ()) -> None:
        names = frozenset(resting)
        contacts = scene.contacts if names else ()
        self._scene = replace(scene, impulses=(), contacts=contacts)
        self._core = ForcesOfMotion(flat_motion(self._scene).core, NO_WAY)
        self._model = scene.robot.model
        of_scene = scene.entry_names("contacts")
        self._entries = {i for i, name in enumerate(of_scene) if name in names}
        self._resting_state = RestingState()

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) v̇ at a state of the motion itself.

        Raises:
            InputError: there is none.
        """
        self._begin(q, v)
        found = self._core.at(t, q, v, self._resting_state)
        if found.failure is not DynamicsFailure.none:
            raise InputError(f"sensitivity: at {t:g} s {NO_MOTION}")
        return found.acceleration

    def jacobian(
        self,
        start: float,
        end: float,
        q: np.ndarray,
        v: np.ndarray,
        *,
        by_controls: bool = False,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(2 nv, 2 nv) how the state at ``end`` [s] changes with that at ``start``, and it.

        ``by_controls``: (2 nv, 3 nv), behind them how it changes with the torques from outside.

        Raises:
            InputError: a motion beside it cannot be followed so far.
        """
        self._begin(q, v)
        size = 2 * len(v)
        total = np.eye(size, size + by_controls * len(v))
        pieces = max(1, int(np.ceil((end - start) * np.abs(v).max(initial=0.0) / LONGEST_FLOW)))
        times = np.linspace(start, end, pieces + 1)
        for t, until in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            part, q, v = self._piece(t, until, q, v, by_controls)
            total = part[:, :size] @ total
            total[:, size:] += part[:, size:]
        return total, q, v

    def _begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Find out which points of the resting contacts slide from here on."""
        core = core_of(self._scene, q, v, MotionSettings())
        nearest: dict[int, tuple[float, int]] = {}
        for at in self._core.gaps(q, v):
            # Of a joint's two stops the nearer one.
            if at.entry in self._entries:
                own = abs(at.value), at.gap
                nearest[at.entry] = min(nearest.get(at.entry, (np.inf, -1)), own)
        core.begin(v, sorted(gap for _, gap in nearest.values()))
        self._resting_state = core.resting_state(0.0)
        self._resting_state.controls = self.controls

    def _piece(
        self, start: float, end: float, q: np.ndarray, v: np.ndarray, by_controls: bool
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nv, model = len(v), self._model
        still = np.zeros((3 if by_controls else 2) * nv)
        q_end, v_end = self._moved(start, end, q, v, still)

        def away(by: np.ndarray) -> np.ndarray:
            ends = [self._moved(start, end, q, v, sign * by) for sign in (1.0, -1.0)]
            ways = [pin.difference(model, q_end, place) for place, _ in ends]
            return np.concatenate([ways[0] - ways[1], ends[0][1] - ends[1][1]])

        return slopes(away, np.full(len(still), STEP)), q_end, v_end

    def _moved(
        self, start: float, end: float, q: np.ndarray, v: np.ndarray, by: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        nv = len(v)
        q, torques = pin.integrate(self._model, q, by[:nv]), self.controls
        if len(by) > 2 * nv:
            torques = (torques if len(torques) else np.zeros(nv)) + by[2 * nv :]
        resting_state = self._resting_state
        resting_state.controls = torques
        found = self._core.flow(start, end, q, v + by[nv : 2 * nv], resting_state, RTOL, ATOL)
        if found is None:
            raise InputError(
                f"sensitivity: from {start:g} to {end:g} s, a little beside the motion, {NO_MOTION}"
            )
        return found[: len(q)], found[len(q) :]


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
