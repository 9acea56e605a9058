"""The two phases of one contact, compression and restitution, along its normal impulse.

A law of impact tells the normal impulse P, the approach speed c, the separation speed s and the
normal work W. In each phase the normal velocity is linear in the impulse: an effective mass
m_c = p_c/c moves in, m_r = (P − p_c)/s moves out. The impulse of the compression p_c is the one
that makes the work right, W = −½ p_c c + ½ (P − p_c) s; where slip keeps its direction both
masses are P/(c + s).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from ..errors import InputError, RangeError

__all__ = ["Elastic", "Phases", "Sample", "Viscous", "phases_of"]

# A share of the impulse or work below this is rounding.
ROUNDING = 1e-13
# Damping λ c above this follows time over the logarithm of 1 + λ δ', which comes near 0 then.
DAMPED = 0.3
# Nodes of Gauss and Jacobi's quadrature; the integrands are analytic, and 40 reach 1e-15.
NODES = 40


class Phases(NamedTuple):
    """Speeds [m/s] and effective masses [kg] of compression and restitution."""

    approach: float
    separation: float
    mass_in: float
    mass_out: float

    @property
    def spent(self) -> float:
        """The work of the compression, positive [J]."""
        return 0.5 * self.mass_in * self.approach**2

    @property
    def regained(self) -> float:
        """The work of the restitution [J]."""
        return 0.5 * self.mass_out * self.separation**2

    @property
    def impulse(self) -> float:
        """P [N s]."""
        return self.mass_in * self.approach + self.mass_out * self.separation


def phases_of(impulse: float, before: float, after: float, work: float, where: str) -> Phases:
    """The phases of a contact that was struck.

    Args:
        impulse: P > 0 [N s].
        before, after: normal velocity [m/s].
        work: of the normal impulse [J].
        where: the contact, for errors.

    Raises:
        InputError: it was not approaching, or its normal impulse gained energy.
    """
    approach = -before
    separation = after if after > ROUNDING * abs(before) else 0.0
    if not approach > 0.0:
        raise InputError(
            f"{where} was not approaching (normal velocity {before:.6g} m/s): its impulse belongs "
            "to what happened elsewhere, and takes as long as that"
        )
    pressed = (0.5 * impulse * separation - work) / (0.5 * (approach + separation))
    pressed = min(pressed, impulse)
    if impulse - pressed <= ROUNDING * impulse or separation == 0.0:
        return Phases(approach, 0.0, impulse / approach, 0.0)
    found = Phases(approach, separation, pressed / approach, (impulse - pressed) / separation)
    if not pressed > 0.0 or found.regained > found.spent * (1.0 + 1e-9):
        raise InputError(
            f"{where}: its normal impulse gives back more work ({found.regained:.6g} J) than the "
            f"compression took ({found.spent:.6g} J), which no force by indentation does; use "
            'Law(restitution="stronge", slip="path")'
        )
    return found


class Sample(NamedTuple):
    """A contact at one instant: time [s], force [N], indentation [m], its rate [m/s], impulse."""

    time: float
    force: float
    indentation: float
    rate: float
    impulse: float


class _Loading(Protocol):
    """A curve on which a mass runs in."""

    def force(self, indentation: float) -> float: ...
    def energy(self, indentation: float) -> float: ...
    def deepest(self, energy: float) -> float: ...
    def time(self, indentation: float, mass: float, speed: float) -> float: ...


@dataclass(frozen=True)
class Elastic:
    """Loading on a curve, unloading on the same curve over r δ, r the share regained.

    Attributes:
        phases: of the contact.
        curve: the loading curve.
    """

    phases: Phases
    curve: _Loading

    @property
    def deepest(self) -> float:
        """The largest indentation [m]."""
        return self.curve.deepest(self.phases.spent)

    @property
    def remaining(self) -> float:
        """The permanent indentation [m]."""
        return (1.0 - self._share) * self.deepest

    @property
    def _share(self) -> float:
        return min(self.phases.regained / self.phases.spent, 1.0)

    @property
    def peak(self) -> float:
        """The largest force [N]; that of a curve that softens may come before the deepest point."""
        most = self.deepest
        points = getattr(self.curve, "indentation", ())
        before = [self.curve.force(d) for d in points if d < most]
        return max([self.curve.force(most), *before])

    @property
    def compression(self) -> float:
        """How long the compression lasts [s]."""
        return self.curve.time(self.deepest, self.phases.mass_in, self.phases.approach)

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.compression + self._restitution_to(0.0)

    def _restitution_to(self, elastic: float) -> float:
        """The time from the deepest point to where ``elastic`` of its indentation is left."""
        share, out = self._share, self.phases
        if out.separation == 0.0:
            return 0.0
        # Backwards it is a loading with mass r m and speed s/r on the same curve.
        mass, speed = share * out.mass_out, out.separation / share
        # r m (s/r)² is W_c twice over but for rounding; the deepest point has to be the same.
        whole = self.curve.time(self.deepest, mass, speed)
        return whole - self.curve.time(elastic, mass, speed)

    def at(self, fraction: float) -> Sample:
        """At a place of the way: 0 to 1 in compression, 1 to 2 in restitution."""
        phases, most, share = self.phases, self.deepest, self._share
        if fraction <= 1.0:
            depth = most * math.sin(0.5 * math.pi * fraction)
            left = max(phases.spent - self.curve.energy(depth), 0.0)
            rate = math.sqrt(2.0 * left / phases.mass_in) if fraction < 1.0 else 0.0
            time = self.curve.time(depth, phases.mass_in, phases.approach)
            impulse = phases.mass_in * (phases.approach - rate)
            return Sample(time, self.curve.force(depth), depth, rate, impulse)
        if phases.separation == 0.0:
            return self.at(1.0)
        depth = most * max(math.sin(0.5 * math.pi * (2.0 - fraction)), 0.0)
        given = max(phases.spent - self.curve.energy(depth), 0.0) * share
        rate = math.sqrt(2.0 * given / phases.mass_out)
        time = self.compression + self._restitution_to(depth)
        impulse = phases.mass_in * phases.approach + phases.mass_out * rate
        force = self.curve.force(depth)
        return Sample(time, force, self.remaining + share * depth, -rate, impulse)


class Viscous:
    """F = k δ^n (1 + λ δ'), with λ from the restitution.

    U(δ) = m/λ² [L(λ c) − L(λ δ')] with L(x) = x − ln(1 + x), for k δ^n dδ = −m δ' dδ'/(1 + λ δ').
    Time is ∫ dp/F, in which F ~ p^(n/(n + 1)) at both ends: quadrature of Gauss and Jacobi.
    """

    def __init__(self, phases: Phases, stiffness: float, exponent: float, where: str) -> None:
        if phases.separation == 0.0:
            raise RangeError.of(
                f"{where}: restitution under HuntCrossley", 0, "above 0 (a damper stops no motion)"
            )
        self.phases, self._k, self._n = phases, stiffness, exponent
        self.damping = _damping(phases)
        self.remaining = 0.0
        self._nodes = _jacobi(-exponent / (exponent + 1.0))

    @property
    def deepest(self) -> float:
        """The largest indentation [m]."""
        return self._depth(0.0, True)

    def _depth(self, rate: float, inwards: bool) -> float:
        """δ where it changes at a rate."""
        phases, x = self.phases, self.damping
        mass = phases.mass_in if inwards else phases.mass_out
        end = phases.approach if inwards else -phases.separation
        if abs(x * end) < 1e-9:
            stored = 0.5 * mass * (end * end - rate * rate)
        else:
            stored = mass / (x * x) * (_excess(x * end) - _excess(x * rate))
        return self._depth_of(stored)

    def _depth_of(self, stored: float) -> float:
        """δ at which k δ^(n + 1)/(n + 1) is an energy."""
        n = self._n + 1.0
        return float((n * max(stored, 0.0) / self._k) ** (1.0 / n))

    def _force(self, rate: float, inwards: bool) -> float:
        return float(self._k * self._depth(rate, inwards) ** self._n * (1.0 + self.damping * rate))

    @property
    def peak(self) -> float:
        """The largest force [N], in compression where it is damped."""
        from scipy.optimize import minimize_scalar

        c = self.phases.approach
        found = minimize_scalar(
            lambda rate: -self._force(rate, True), bounds=(0.0, c), method="bounded",
            options={"xatol": 1e-10 * c},
        )  # fmt: skip
        return max(-float(found.fun), self._force(0.0, True))

    @property
    def compression(self) -> float:
        """How long the compression lasts [s]."""
        return self._time_near_end(0.0, True)

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.compression + self._time_near_end(0.0, False)

    def _time_near_end(self, rate: float, inwards: bool) -> float:
        """From the first contact to a rate of indentation, or from there to the last one [s]."""
        phases, n, x = self.phases, self._n, self.damping
        mass = phases.mass_in if inwards else phases.mass_out
        end = phases.approach if inwards else -phases.separation
        if end == rate:
            return 0.0
        power = n / (n + 1.0)
        if x * phases.approach > DAMPED:
            # Over y = ln(1 + λ δ') what is near 1 + λ δ' = 0 is far: dt = m dy/(λ k δ^n).
            start = 1.0 + x * end
            whole = abs(math.log(start / (1.0 + x * rate)))
            sign = 1.0 if inwards else -1.0

            def part(y: float) -> float:
                stored = -start * math.expm1(-sign * y) - sign * y
                depth = self._depth_of(mass / (x * x) * stored)
                return mass / (x * self._k * depth**n)
        else:
            whole = mass * abs(end - rate)

            def part(y: float) -> float:
                return 1.0 / self._force(end - math.copysign(y / mass, end), inwards)

        # ∫ y^(−power) [y^power part(y)] dy from 0 to ``whole``.
        total = 0.0
        nodes, weights = self._nodes
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            y = whole * node
            total += weight * y**power * part(y)
        return float(total * whole ** (1.0 - power))

    def at(self, fraction: float) -> Sample:
        """At a place of the way: 0 to 1 in compression, 1 to 2 in restitution."""
        phases = self.phases
        if fraction <= 1.0:
            rate = phases.approach * math.cos(0.5 * math.pi * fraction) if fraction < 1.0 else 0.0
            time = self._time_near_end(rate, True)
            impulse = phases.mass_in * (phases.approach - rate)
            return Sample(time, self._force(rate, True), self._depth(rate, True), rate, impulse)
        rate = -phases.separation * math.sin(0.5 * math.pi * (fraction - 1.0))
        rate = -phases.separation if fraction == 2.0 else rate
        time = self.duration - self._time_near_end(rate, False)
        impulse = phases.mass_in * phases.approach - phases.mass_out * rate
        return Sample(time, self._force(rate, False), self._depth(rate, False), rate, impulse)


def _jacobi(power: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on (0, 1) for ∫ x^power f(x) dx."""
    from scipy.special import roots_jacobi

    nodes, weights = roots_jacobi(NODES, 0.0, power)
    return 0.5 * (nodes + 1.0), weights * 0.5 ** (power + 1.0)


def _excess(x: float) -> float:
    """x − ln(1 + x), to all its digits near 0."""
    if abs(x) > 0.05:
        return x - math.log1p(x)
    total, term = 0.0, x
    for k in range(2, 16):
        term *= -x
        total -= term / k
    return total


def _damping(phases: Phases) -> float:
    """λ [s/m] with m_r L(−λ s) = m_c L(λ c): what is spent and regained returns to δ = 0."""
    from scipy.optimize import brentq

    c, s, m_in, m_out = phases.approach, phases.separation, phases.mass_in, phases.mass_out
    lost = phases.spent - phases.regained
    if lost <= 1e-14 * phases.spent:
        return 0.0

    def left(x: float) -> float:
        # Over x²: the trivial root at 0 taken out.
        return (m_out * _excess(-x * s) - m_in * _excess(x * c)) / (x * x)

    # Near 0 it is −lost + x (m_in c³ + m_out s³)/3 + …
    low = 0.5 * 3.0 * lost / (m_in * c**3 + m_out * s**3)
    while left(low) > 0.0:
        low *= 0.5
    # It grows without bound towards 1/s; 1 − x s may be as small as exp(−c/s).
    gap = 0.5
    while left((1.0 - gap) / s) <= 0.0:
        gap *= 0.5
        if gap < 1e-15:
            raise RangeError.of("HuntCrossley: restitution", s / c, "above 0.03")
    return float(brentq(left, min(low, (1.0 - gap) / s), (1.0 - gap) / s, xtol=1e-300, rtol=1e-15))
