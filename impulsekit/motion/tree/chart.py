"""A chart of the configuration space: q as a function of x (nv,), and ẋ as one of x and v.

- Coordinates that are plain numbers are their own chart: x is q, ẋ is v.
- A planar joint has its place in the world and its angle for x.
- Joints that turn in space have q = q_ref ⊕ x, and v = J x' with the right Jacobian
  J = (1 − exp(−ad)) / ad. Its inverse is 1 + ½ ad + a ad² + b ad⁴, exactly, with

      1 − γ = 1 − (θ/2) cot(θ/2),  a = (4 (1 − γ) + θ γ') / 2θ²,  b = (2 (1 − γ) + θ γ') / 2θ⁴

  (Bullo & Murray 1995, "Proportional derivative control on the Euclidean group"). It is
  written out here because Pinocchio's own derivatives of ⊖ lose up to half their digits
  at small angles, where a step of an integrator lies.
"""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from ...laws.borrowed import borrowing
from ...laws.compiled import entry

__all__ = ["Chart", "unrolled"]

# Bound once: these run at every stage of every step.
_integrate, _d_difference, _AFTER = pin.integrate, pin.dDifference, pin.ArgumentPosition.ARG1

# 1 − (θ/2) cot(θ/2) = Σ c_n θ²ⁿ, c_n = |B_2n| / (2n)!
_SERIES = (
    1 / 12,
    1 / 720,
    1 / 30240,
    1 / 1209600,
    1 / 47900160,
    691 / 1307674368000,
    1 / 74724249600,
    3617 / 10670622842880000,
)
# Below this the series is exact to rounding, above it the closed form is.
SMALL = 0.35
# Six numbers, linear before angular; three of them.
Motion = tuple[float, float, float, float, float, float]
_NOTHING = (0.0, 0.0, 0.0)
# Of θ²: where three terms of the series do, and where b ad⁴ is below rounding.
SMALL_TURN, NO_FOURTH = 2e-3, 1e-7


class Chart:
    """Coordinates x (nv,) of configurations q (nq,), near a reference where joints turn in space.

    Attributes:
        reference: (nq,) the place of x = 0, for joints that need one.
        is_flat: whether there is nothing to re-centre.
        turning: (nv,) which speeds are of joints that turn without end.
    """

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        self._identity = model.nq == model.nv
        self.reference = pin.neutral(model)
        self._planar: list[tuple[int, int]] = []
        self._spatial: list[tuple[slice, int]] = []
        self._others: list[tuple[pin.Model, slice, slice]] = []
        plain = np.ones(model.nq, dtype=bool)
        referred = np.zeros(model.nv, dtype=bool)
        turning = np.zeros(model.nv, dtype=bool)
        for joint in list(model.joints)[1:]:
            own_q = slice(joint.idx_q, joint.idx_q + joint.nq)
            own_v = slice(joint.idx_v, joint.idx_v + joint.nv)
            kind = joint.shortname()
            if joint.nq == joint.nv:
                continue
            plain[own_q] = False
            turning[own_v] = True
            if kind == "JointModelPlanar":
                self._planar.append((joint.idx_q, joint.idx_v))
                continue
            referred[own_v] = True
            if kind in ("JointModelFreeFlyer", "JointModelSpherical"):
                self._spatial.append((own_v, joint.nv))
            elif joint.nv > 1:
                alone = pin.Model()
                alone.addJoint(0, joint, pin.SE3.Identity(), "alone")
                self._others.append((alone, own_q, own_v))
        self.reference[plain] = 0.0
        self._plain, self._referred, self.turning = plain, referred, turning
        self._bent = bool(self._planar or self._spatial or self._others)
        self.is_flat = not referred.any()

    def centred(self, q: np.ndarray) -> np.ndarray:
        """(nv,) move the reference to q where there is one; gives the x of q."""
        if self._identity:
            return q.copy()
        self.reference = np.where(self._plain, 0.0, q)
        neutral = pin.neutral(self._model)
        for at, _ in self._planar:
            self.reference[at : at + 4] = neutral[at : at + 4]
        x = self.coordinates(q)
        x[self._referred] = 0.0
        return x

    def coordinates(self, q: np.ndarray) -> np.ndarray:
        """(nv,) the x of a q near the reference; angles of planar joints within half a turn."""
        x = np.array(pin.difference(self._model, self.reference, q))
        for at, to in self._planar:
            c, s = q[at + 2 : at + 4].tolist()
            x[to], x[to + 1], x[to + 2] = q[at], q[at + 1], math.atan2(s, c)
        return x

    def unwrap(self, x: np.ndarray) -> None:
        """Let angles of planar joints in rows x (k, nv or more) go on from row to row, in place."""
        for _, to in self._planar:
            x[:, to + 2] = np.unwrap(x[:, to + 2])

    def configuration(self, x: np.ndarray, reference: np.ndarray | None = None) -> np.ndarray:
        """(nq,) q; ``reference`` for another one than the chart's own."""
        if self._identity:
            return x
        q = _integrate(self._model, self.reference if reference is None else reference, x)
        for at, to in self._planar:
            px, py, angle = x[to : to + 3].tolist()
            q[at : at + 4] = px, py, math.cos(angle), math.sin(angle)
        return q

    def rate(self, x: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) ẋ at x, the chart of q, with velocity v; x has to be within half a turn."""
        if not self._bent:
            return v
        rate = v.copy()
        for at, to in self._planar:
            c, s = q[at + 2 : at + 4].tolist()
            v0, v1 = v[to : to + 2].tolist()
            rate[to], rate[to + 1] = c * v0 - s * v1, s * v0 + c * v1
        for own, size in self._spatial:
            if size == 6:
                rate[own] = unrolled(tuple(x[own].tolist()), tuple(v[own].tolist()))
            else:
                whole = unrolled((*_NOTHING, *x[own].tolist()), (*_NOTHING, *v[own].tolist()))
                rate[own] = whole[3:]
        for alone, own_q, own_v in self._others:
            turn = _d_difference(alone, self.reference[own_q], q[own_q], _AFTER)
            rate[own_v] = turn.dot(v[own_v])
        return rate

    def turning_speed(self, v: np.ndarray) -> float:
        """The largest rate of a joint that turns without end [1/s]."""
        # Translations of a free body count as well: they are turned along.
        return float(np.abs(v[self.turning]).max(initial=0.0))


@entry(lambda: ((0.0,) * 6, (0.0,) * 6), seconds=1.5)
def unrolled(x: Motion, v: Motion) -> Motion:
    """J⁻¹(x) v of a free body, linear before angular."""
    square = x[3] * x[3] + x[4] * x[4] + x[5] * x[5]
    a, b = _factors(square)
    once = _bracket(x, v)
    twice = _bracket(x, once)
    rate = _plus(_plus(v, 0.5, once), a, twice)
    if square > NO_FOURTH:
        rate = _plus(rate, b, _bracket(x, _bracket(x, twice)))
    return rate


@borrowing
def _plus(v: Motion, factor: float, w: Motion) -> Motion:
    return (
        v[0] + factor * w[0],
        v[1] + factor * w[1],
        v[2] + factor * w[2],
        v[3] + factor * w[3],
        v[4] + factor * w[4],
        v[5] + factor * w[5],
    )


@borrowing
def _bracket(x: Motion, v: Motion) -> Motion:
    """ad_x v = (ω_x × v + v_x × ω, ω_x × ω)."""
    a, b, c, d, e, f = x
    p, q, r, s, t, u = v
    return (
        e * r - f * q + b * u - c * t,
        f * p - d * r + c * s - a * u,
        d * q - e * p + a * t - b * s,
        e * u - f * t,
        f * s - d * u,
        d * t - e * s,
    )


@borrowing
def _factors(square: float) -> tuple[float, float]:
    """a and b for θ²."""
    if square < SMALL_TURN:
        return (
            1 / 12 - square * square / 30240,
            -1 / 720 - square * (1 / 15120 + square / 403200),
        )
    if square < SMALL * SMALL:
        a = b = 0.0
        power = 1.0
        for n in range(len(_SERIES)):
            a += (1 - n) * _SERIES[n] * power
            if n + 1 < len(_SERIES):
                b -= (n + 1) * _SERIES[n + 1] * power
            power *= square
        return a, b
    theta = math.sqrt(square)
    half = 0.5 * theta
    gamma = half / math.tan(half)
    slope = gamma - 0.25 * square / math.sin(half) ** 2
    less = 1.0 - gamma
    return (4.0 * less + slope) / (2.0 * square), (2.0 * less + slope) / (2.0 * square * square)
