"""How a whole motion with its impacts changes with its start: the chain of flows and impacts.

Φ = Φ_k Ξ_k … Φ_1 Ξ_1 Φ_0 on the tangent of (q, v), with the saltation matrices Ξ of the
impacts and the flows Φ between them. Over a period it is the monodromy matrix.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..errors import InputError, a_thing
from ..impact.saltation import Saltation, saltation
from ..scene import Scene
from .dynamics import Dynamics

if TYPE_CHECKING:
    from .trajectory import Trajectory

__all__ = ["Sensitivity", "sensitivity"]

# Central differences of flows; their error is of the order of its square.
STEP = 1e-5
LONGEST_TURN = 0.5


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """The linear map from deviations (δq, δv) at the start of a motion to those at its end.

    Attributes:
        matrix: (2 nv, 2 nv) Φ, read-only.
        saltations: (time [s], ``Saltation``) of its impacts.
    """

    matrix: np.ndarray
    saltations: tuple[tuple[float, Saltation], ...] = field(repr=False)

    @property
    def exists(self) -> bool:
        """Whether every impact on the way has derivatives."""
        return all(item.derivatives.status.exists for _, item in self.saltations)

    @property
    def multipliers(self) -> np.ndarray:
        """(2 nv,) eigenvalues of Φ, the largest first; Floquet's where the motion is periodic."""
        values = np.linalg.eigvals(self.matrix)
        return values[np.argsort(-np.abs(values))]


def sensitivity(motion: Trajectory) -> Sensitivity:
    """The sensitivity of a motion to its start, impacts on the way included.

    Impacts pass by their saltation matrices; flows between them by central differences of
    motions nearby (about 1e-8 of the largest entry). Impulses at t = 0 strike at a fixed
    time; later impacts happen when their contact closes.

    Raises:
        InputError: a motion in which a contact rests, in which several contacts close at
            one instant, or that was not followed to its end; or as for ``derivatives``.
        RangeError: a contact is grazed.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, simulate
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.9)])
        >>> drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
        >>> motion = simulate(scene, drop, ball.velocity(), duration=0.8)
        >>> float(round(sensitivity(motion).matrix[0, 0], 6))
        1.0
    """
    from .trajectory import Trajectory as AMotion

    if not isinstance(motion, AMotion):
        raise InputError(f"sensitivity takes a Trajectory, not {a_thing(motion)}")
    if motion.rests:
        raise InputError(
            f"sensitivity: {motion.rests[0].contact} rests from {motion.rests[0].start:g} s on; "
            "motions are taken whose contacts part again at once"
        )
    if not motion.status.finished:
        raise InputError(
            f"sensitivity: the motion was not followed to its end. {motion.status.value}"
        )
    flow = _Flow(motion.scene)
    total = np.eye(2 * motion.scene.robot.nv)
    saltations = []
    t = 0.0
    q, v = motion.at(0.0) if not motion.impacts or motion.impacts[0][0] > 0.0 else (None, None)
    for time, impact in motion.impacts:
        if q is not None and v is not None and time > t:
            total = flow.jacobian(t, time, q, v) @ total
        names = motion.scene.entry_names("contacts")
        outcome = impact.outcome
        touched = [] if outcome is None else [names[touch.entry] for touch in outcome.touches]
        if len(touched) > 1:
            raise InputError(
                f"sensitivity: {' and '.join(touched)} meet at one instant, {time:g} s"
            )
        found = saltation(
            impact,
            touched[0] if touched and time > 0.0 else None,
            acceleration_before=flow.acceleration(time, impact.q, impact.v_before),
            acceleration_after=flow.acceleration(time, impact.q, impact.v_after),
        )
        saltations.append((time, found))
        total = found.matrix @ total
        t, q, v = time, impact.q, impact.v_after
    if q is not None and v is not None and motion.duration > t:
        total = flow.jacobian(t, motion.duration, q, v) @ total
    total.setflags(write=False)
    return Sensitivity(total, tuple(saltations))


class _Flow:
    """The motion of a scene's robot between impacts."""

    def __init__(self, scene: Scene) -> None:
        self._dynamics = Dynamics(replace(scene, impulses=(), contacts=()))
        self._model = self._dynamics.model

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) v̇."""
        return np.array(self._dynamics.acceleration(t, q, v))

    def jacobian(self, start: float, end: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(2 nv, 2 nv) how the state at ``end`` [s] changes with that at ``start``."""
        total = np.eye(2 * len(v))
        pieces = max(1, int(np.ceil((end - start) * np.abs(v).max(initial=0.0) / LONGEST_TURN)))
        times = np.linspace(start, end, pieces + 1)
        for t, until in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            part, q, v = self._piece(t, until, q, v)
            total = part @ total
        return total

    def _piece(
        self, start: float, end: float, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nv, model = len(v), self._model
        still = np.zeros(2 * nv)
        q_end, v_end = self._moved(start, end, q, v, still)
        columns = []
        for unit in STEP * np.eye(2 * nv):
            ends = [self._moved(start, end, q, v, sign * unit) for sign in (1.0, -1.0)]
            by_q = pin.difference(model, q_end, ends[0][0]) - pin.difference(
                model, q_end, ends[1][0]
            )
            columns.append(np.concatenate([by_q, ends[0][1] - ends[1][1]]) / (2.0 * STEP))
        return np.array(columns).T, q_end, v_end

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
        found = solve_ivp(rates, (start, end), y, "DOP853", [end], rtol=1e-12, atol=1e-13)
        y = found.y[:, -1]
        return pin.integrate(model, reference, y[:nv]), y[nv:]
