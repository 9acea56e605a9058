"""Motion without impacts: followed from a state, and fitted to samples on the manifold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np
import pinocchio as pin

from ..motion.dynamics import Dynamics
from ..scene import Scene

__all__ = ["Flight", "FlightFit", "bracket", "left_by_parabolas"]

# No step of Runge and Kutta's rule turns or moves a joint by more [rad, m]: its error is then
# below 1e-6 of the step, far below the noise of any recording.
LONGEST_TURN = 0.1
# A fit ends when an update is below this share of its standard deviation.
SETTLED = 1e-2
MOST_UPDATES = 6
# Residuals above so many standard deviations count with less weight (Huber 1964).
HUBER = 2.5


@dataclass(frozen=True, eq=False)
class FlightFit:
    """A flight through samples.

    Attributes:
        time: t₀ of the state [s].
        q, v: (nq,), (nv,) the state there.
        share: (2, 2) covariance of (δq, δs) of each coordinate, in units of its noise variance;
            the slope of what samples are off is δs = δv − [v, δq], with ``bracket``.
        residuals: (N, nv) measured less fitted, on the tangent.
        weights: (N,) of the samples, 1 but for outliers.
    """

    time: float
    q: np.ndarray
    v: np.ndarray
    share: np.ndarray
    residuals: np.ndarray
    weights: np.ndarray


class Flight:
    """The motion of a scene's robot while nothing touches.

    Args:
        scene: its forces, constraints and gravity act; impulses and contacts do not.
    """

    def __init__(self, scene: Scene) -> None:
        self.model = scene.robot.model
        self._dynamics = Dynamics(replace(scene, impulses=(), contacts=()))

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) v̇."""
        return np.array(self._dynamics.acceleration(t, q, v))

    def step(
        self, t: float, q: np.ndarray, v: np.ndarray, dt: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """The state ``dt`` [s] later (or earlier), by a rule of fourth order on the manifold."""
        pieces = max(1, ceil(abs(dt) * float(np.abs(v).max(initial=0.0)) / LONGEST_TURN))
        for _ in range(pieces):
            q, v = self._piece(t, q, v, dt / pieces)
            t += dt / pieces
        return q, v

    def _piece(
        self, t: float, q: np.ndarray, v: np.ndarray, h: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Fourth order without commutators (Celledoni, Marthinsen & Owren 2003, "CF4")."""
        model, rate = self.model, self.acceleration
        a1 = rate(t, q, v)
        v2 = v + 0.5 * h * a1
        q2 = pin.integrate(model, q, 0.5 * h * v)
        a2 = rate(t + 0.5 * h, q2, v2)
        v3 = v + 0.5 * h * a2
        q3 = pin.integrate(model, q, 0.5 * h * v2)
        a3 = rate(t + 0.5 * h, q3, v3)
        v4 = v + h * a3
        q4 = pin.integrate(model, pin.integrate(model, q, 0.5 * h * v), h * (v3 - 0.5 * v))
        a4 = rate(t + h, q4, v4)
        first = h / 12.0 * (3.0 * v + 2.0 * v2 + 2.0 * v3 - v4)
        second = h / 12.0 * (-v + 2.0 * v2 + 2.0 * v3 + 3.0 * v4)
        q_end = pin.integrate(model, pin.integrate(model, q, first), second)
        return q_end, v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)

    def path(
        self, time: float, q: np.ndarray, v: np.ndarray, times: np.ndarray
    ) -> list[np.ndarray]:
        """Configurations at times before and after that of the state."""
        found: list[np.ndarray] = [q] * len(times)
        order = np.argsort(times, kind="stable").tolist()
        split = int(np.searchsorted(times[order], time)) if len(times) else 0
        for part in (order[split:], order[:split][::-1]):
            at, here, speed = time, q, v
            for k in part:
                here, speed = self.step(at, here, speed, float(times[k]) - at)
                at = float(times[k])
                found[k] = here
        return found

    def fit(
        self,
        times: np.ndarray,
        samples: np.ndarray,
        time: float,
        q: np.ndarray,
        v: np.ndarray,
        sigma: np.ndarray,
    ) -> FlightFit:
        """The flight whose configurations are nearest to samples, from a first guess.

        Args:
            times: (N,) [s]. samples: (N, nq).
            time: t₀ where the state is asked for.
            q, v: the first guess there.
            sigma: (nv,) noise of the samples on their tangents.

        Gauss-Newton with the first order of the Jacobian in the axes at t₀, δq + (δv − [v, δq]) τ:
        it settles in some three updates. Weights by Huber's rule.
        """
        tau = times - time
        weights = np.ones(len(times))
        for _ in range(MOST_UPDATES):
            residuals = np.array(
                [
                    in_axes_of(self.model, q, here, pin.difference(self.model, here, seen))
                    for here, seen in zip(self.path(time, q, v, times), samples, strict=True)
                ]
            )
            sizes = np.sqrt(np.mean((residuals / sigma) ** 2, axis=1))
            typical = max(1.0, float(np.median(sizes)))
            weights = np.minimum(1.0, HUBER * typical / np.maximum(sizes, 1e-300))
            design = np.stack([np.ones(len(tau)), tau], axis=1)
            share = np.linalg.pinv(design.T @ (weights[:, None] * design), hermitian=True)
            update = share @ design.T @ (weights[:, None] * residuals)
            v = v + update[1] + bracket(self.model, v) @ update[0]
            q = pin.integrate(self.model, q, update[0])
            scale = np.sqrt(np.diagonal(share))[:, None] * sigma
            if (np.abs(update) <= SETTLED * scale).all():
                break
        return FlightFit(time, q, v, share, residuals, weights)


def in_axes_of(model: pin.Model, base: np.ndarray, q: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """(nv,) an offset on the tangent at q, its free bodies' parts in their axes at ``base``."""
    for joint in list(model.joints)[1:]:
        if joint.shortname() != "JointModelFreeFlyer":
            continue
        at = slice(joint.idx_q + 3, joint.idx_q + 7)
        turn = pin.Quaternion(base[at]).conjugate() * pin.Quaternion(q[at])
        own = slice(joint.idx_v, joint.idx_v + 6)
        offset = offset.copy()
        offset[own] = (turn.matrix() @ offset[own].reshape(2, 3).T).T.reshape(-1)
    return offset


def left_by_parabolas(
    model: pin.Model, t: np.ndarray, q: np.ndarray, own: np.ndarray
) -> np.ndarray:
    """(N, nv) what constant accelerations, of any size, leave of samples, on the tangent."""
    middle = int(own[len(own) // 2])
    tau = t[own] - t[middle]
    offsets = np.array([pin.difference(model, q[middle], q[k]) for k in own])
    powers = np.stack([np.ones(len(tau)), tau, tau**2], axis=1)
    return np.asarray(offsets - powers @ np.linalg.lstsq(powers, offsets, rcond=None)[0])


def bracket(model: pin.Model, v: np.ndarray) -> np.ndarray:
    """(nv, nv) [v, ·]: what an offset of q changes of v in the axes of a body.

    A free body that is seen turned by δθ has the velocities v × δθ and ω × δθ besides; 0 for
    joints of one degree of freedom.
    """
    found = np.zeros((model.nv, model.nv))
    for joint in list(model.joints)[1:]:
        start = joint.idx_v
        if joint.shortname() == "JointModelFreeFlyer":
            angular = slice(start + 3, start + 6)
            found[start : start + 3, angular] = pin.skew(v[start : start + 3])
            found[angular, angular] = pin.skew(v[angular])
    return found
