"""Motion without impacts: followed from a state, and fitted to samples on the manifold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np
import pinocchio as pin

from .._core import ForcesOfMotion, RestingState
from ..motion.flat import flat_motion
from ..scene import JointFriction, Scene
from ..tolerances import NONZERO
from .free_fall import free_joints
from .recording_checks import turns_of

# No step turns a body, or turns or moves a joint, by more [rad, m]: the error of the rule is then
# below 1e-6 of a step, far below any noise.
LONGEST_TURN = 0.1
# A fit ends when an update is below this share of its standard deviation.
SETTLED = 1e-2
MOST_UPDATES = 6
# Residuals above so many standard deviations count with less weight (Huber 1964).
HUBER = 2.5
# [of the product of its diagonal] A determinant up to this is that of samples at one time, rounded.
NO_INVERSE = 1e-12


@dataclass(frozen=True, eq=False)
class FlightFit:
    """A flight through samples.

    Attributes:
        q, v: (nq,), (nv,) the state at t₀.
        share: (2, 2) covariance of (δq, δs) of each coordinate, in units of its noise variance;
            the slope of what samples are off is δs = δv − [v, δq], with ``bracket``.
        residuals: (N, nv) measured less fitted, on the tangent.
        weights: (N,) of the samples, 1 but for outliers.
    """

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
        free = replace(scene, impulses=(), contacts=())
        self._core = ForcesOfMotion(flat_motion(free).core, 0.0)
        dry = [0] * len({f.joint for f in scene.forces if isinstance(f, JointFriction)})
        self._nothing = RestingState(dry=dry)
        # Where free joints begin in q and v.
        self._free = [(joint.idx_q, joint.idx_v) for joint in free_joints(self.model)]

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return (nv,) v̇."""
        found = self._core.at(t, q, v, self._nothing)
        return found.acceleration

    def step(
        self, t: float, q: np.ndarray, v: np.ndarray, dt: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the state ``dt`` [s] later (or earlier), by a rule of fourth order."""
        pieces = max(1, ceil(abs(dt) * float(np.abs(v).max(initial=0.0)) / LONGEST_TURN))
        for _ in range(pieces):
            q, v = self._piece(t, q, v, dt / pieces)
            t += dt / pieces
        return q, v

    def _piece(
        self, t: float, q: np.ndarray, v: np.ndarray, h: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Follow a piece without commutators, CF4 (Celledoni, Marthinsen & Owren 2003)."""
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

    def step_all(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, dt: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return states (n, nq), (n, nv) at times (n,), each moved by its ``dt`` (n,) [s]."""
        q, v = q.copy(), v.copy()
        for i in range(len(dt)):
            q[i], v[i] = self.step(float(t[i]), q[i], v[i], float(dt[i]))
        return q, v

    def path(self, time: float, q: np.ndarray, v: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return (N, nq) configurations at times (N,) before and after that of the state."""
        found = np.tile(q, (len(times), 1))
        split = int(np.searchsorted(times, time))
        for part in (range(split, len(times)), range(split - 1, -1, -1)):
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
        """Return the flight whose configurations are nearest to samples, from a first guess.

        Args:
            times: (N,) [s]. samples: (N, nq).
            time: t₀ where the state is asked for.
            q, v: the first guess there.
            sigma: (nv,) noise of the samples on their tangents.

        Gauss-Newton with the first order of the Jacobian in the axes at t₀, δq + (δv − [v, δq]) τ:
        it settles in some three updates. Weights by Huber's rule.
        """
        tau = times - time
        design = np.stack([np.ones(len(tau)), tau], axis=1)
        weights = np.ones(len(times))
        for _ in range(MOST_UPDATES):
            path = self.path(time, q, v, times)
            offsets = [
                pin.difference(self.model, *pair) for pair in zip(path, samples, strict=True)
            ]
            residuals = self._in_axes_of(q, path, np.array(offsets))
            sizes = np.sqrt(np.mean((residuals / sigma) ** 2, axis=1))
            typical = max(1.0, float(np.median(sizes)))
            weights = np.minimum(1.0, HUBER * typical / np.maximum(sizes, NONZERO))
            share = _inverse(design.T @ (weights[:, None] * design))
            update = share @ design.T @ (weights[:, None] * residuals)
            v = v + update[1] + self.bracket(v) @ update[0]
            q = pin.integrate(self.model, q, update[0])
            scale = np.sqrt(np.diagonal(share))[:, None] * sigma
            if (np.abs(update) <= SETTLED * scale).all():
                break
        return FlightFit(q, v, share, residuals, weights)

    def _in_axes_of(self, base: np.ndarray, q: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        """Return (N, nv) offsets on the tangents at (N, nq), free bodies in axes at base."""
        for at, row in self._free:
            first = pin.Quaternion(base[at + 3 : at + 7]).matrix()
            turns = first.T @ turns_of(q[:, at + 3 : at + 7])
            own = offsets[:, row : row + 6].reshape(len(q), 2, 3) @ np.swapaxes(turns, 1, 2)
            offsets[:, row : row + 6] = own.reshape(len(q), 6)
        return offsets

    def bracket(self, v: np.ndarray) -> np.ndarray:
        """Return (nv, nv) [v, ·]: what an offset of q changes of v in the axes of a body.

        A free body that is seen turned by δθ has the velocities v × δθ and ω × δθ besides; 0 for
        joints of one degree of freedom.
        """
        found = np.zeros((self.model.nv, self.model.nv))
        for _, row in self._free:
            linear, angular = slice(row, row + 3), slice(row + 3, row + 6)
            found[linear, angular] = pin.skew(v[linear])
            found[angular, angular] = pin.skew(v[angular])
        return found


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Return (2, 2) inverse of a symmetric positive one, or its pseudoinverse where it has none."""
    (a, b), (_, c) = matrix.tolist()
    det = a * c - b * b
    if det <= NO_INVERSE * a * c:
        return np.linalg.pinv(matrix, hermitian=True)
    return np.array([[c, -b], [-b, a]]) / det


def parabola_residuals(
    model: pin.Model, t: np.ndarray, q: np.ndarray, own: np.ndarray
) -> np.ndarray:
    """Return (N, nv) what constant accelerations, of any size, leave of samples, on the tangent."""
    middle = int(own[len(own) // 2])
    tau = t[own] - t[middle]
    offsets = np.array([pin.difference(model, q[middle], q[k]) for k in own])
    powers = np.stack([np.ones(len(tau)), tau, tau**2], axis=1)
    return np.asarray(offsets - powers @ np.linalg.lstsq(powers, offsets, rcond=None)[0])


# χ² by which a kink must explain samples better than a smooth way with another acceleration, which
# has one unknown less: noise makes the kink that much better once in 10^4 times.
KINK_BETTER = 15.0


def is_smooth(
    flight: Flight, t: np.ndarray, q: np.ndarray, own: np.ndarray, sigma: np.ndarray, cost: float
) -> bool:
    """Return whether constant accelerations, of any size, explain samples as well as a kink.

    A body that slides or rolls is no flight; cut into short pieces of flight it seems to bounce.

    Args:
        own: indices of the samples on both sides. cost: of the kink, see ``Kink``.
    """
    left = parabola_residuals(flight.model, t, q, own) / sigma
    return float((left**2).sum()) < cost + KINK_BETTER
