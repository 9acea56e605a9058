"""Forces along the normal impulse of a contact: its two phases, and Hunt and Crossley's force.

A law of impact gives the normal impulse P, the approach speed c, the separation speed s and the
normal work W. In each phase the normal velocity is linear in the impulse: an effective mass
m_c = p_c/c moves in, m_r = (P − p_c)/s moves out. The impulse of the compression p_c is the one
that makes the work right, W = −½ p_c c + ½ (P − p_c) s; where slip keeps its direction both
masses are P/(c + s).

Hunt and Crossley's force is F = k δ^n (1 + λ δ'). With r = δ' and k δ^n dδ = −m r dr/(1 + λ r),
the energy of the spring is U = m/λ² [L(λ c) − L(λ r)], L(x) = x − ln(1 + x) (Hunt & Crossley
1975; Lankarani & Nikravesh 1990 keep its first terms). Where the force is largest,
n λ r + (n + 1) L(λ r) = (n + 1) L(λ c).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import InputError, RangeError

# Energy that comes back beyond what was spent, by rounding.
GAINED = 1e-9
# Approaches [m/s] whose energies, and powers of what these press in, are doubles.
SLOWEST, FASTEST = 1e-60, 1e100
# A share of the impulse or work below this is rounding.
ROUNDING = 1e-13


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
    """Return the phases of a contact that was struck.

    Args:
        impulse: P > 0 [N s].
        before, after: normal velocity [m/s].
        work: of the normal impulse [J].
        where: the contact, for errors.

    Raises:
        InputError: it was not approaching, or its normal impulse gained energy.
        RangeError: it approached at more than 1e100 or less than 1e-60 m/s.
    """
    approach = -before
    separation = after if after > ROUNDING * abs(before) else 0.0
    if not approach > 0.0:
        raise InputError(
            f"{where} was not approaching (normal velocity {before:.6g} m/s): its impulse belongs "
            "to what happened elsewhere, and takes as long as that"
        )
    if not SLOWEST <= approach <= FASTEST:
        allowed = f"{SLOWEST:g} to {FASTEST:g} m/s"
        raise RangeError.of(f"{where}: approach speed", approach, allowed)
    pressed = (0.5 * impulse * separation - work) / (0.5 * (approach + separation))
    pressed = min(pressed, impulse)
    if impulse - pressed <= ROUNDING * impulse or separation == 0.0:
        return Phases(approach, 0.0, impulse / approach, 0.0)
    found = Phases(approach, separation, pressed / approach, (impulse - pressed) / separation)
    if not pressed > 0.0 or found.regained > found.spent * (1.0 + GAINED):
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

    @cached_property
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

    @cached_property
    def peak(self) -> float:
        """The largest force [N]; that of a curve that softens may come before the deepest point."""
        most = self.deepest
        points = getattr(self.curve, "indentation", ())
        before = [self.curve.force(d) for d in points if d < most]
        return max([self.curve.force(most), *before])

    @cached_property
    def compression(self) -> float:
        """The duration of the compression [s]."""
        return self.curve.time(self.deepest, self.phases.mass_in, self.phases.approach)

    @cached_property
    def duration(self) -> float:
        """The duration of the contact [s]."""
        return self.compression + self._restitution_to(0.0)

    def _restitution_to(self, elastic: float) -> float:
        """Return the time from the deepest point to where ``elastic`` of its indentation is
        left."""
        share, out = self._share, self.phases
        if out.separation == 0.0:
            return 0.0
        # Backwards it is a loading with mass r m and speed s/r on the same curve.
        mass, speed = share * out.mass_out, out.separation / share
        # r m (s/r)² is W_c twice over but for rounding; the deepest point has to be the same.
        whole = self.curve.time(self.deepest, mass, speed)
        return whole - self.curve.time(elastic, mass, speed)

    def at(self, fraction: float) -> Sample:
        """Return the sample at a place of the way: 0 to 1 in compression, 1 to 2 in restitution."""
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


# Above this damping λ c, time is integrated over ln(1 + λ δ'), since 1 + λ δ' comes near 0.
DAMPED = 0.3
# Nodes of Gauss and Jacobi's quadrature; the integrands are analytic, and 40 reach 1e-15.
NODES = 40
# A loss below this share of the work is rounding error: no damping.
LOSSLESS = 1e-14
# Below this λ times the speed, damping changes the spring's energy by less than a billionth.
UNDAMPED = 1e-9
# Below this L(x) is summed as a series, whose terms behind the fifteenth are below 1e-17.
SERIES = 0.05
# ln(1/(1 − λ s)) above this leaves no digits in 1 − λ s: e below 0.03.
STEEP = 34.5
# Newton's method takes about six steps, with a bisection in between some more; a step below
# NEWTON_ENDS, relative, ends it.
MOST_STEPS = 100
NEWTON_ENDS = 4e-16
# Losses up to which the series about 0 is a better start than that of large ones.
SMALL_LOSS = 0.9


def _excess(x: np.ndarray) -> np.ndarray:
    """Return x − ln(1 + x), to all its digits near 0."""
    near = np.where(np.abs(x) > SERIES, 0.0, x)
    total, term = np.zeros_like(near), near
    for k in range(2, 16):
        term = term * -near
        total = total - term / k
    return np.where(np.abs(x) > SERIES, x - np.log1p(x), total)


def _damping(c: np.ndarray, s: np.ndarray, m_in: np.ndarray, m_out: np.ndarray) -> np.ndarray:
    """Return λ [s/m] with m_r L(−λ s) = m_c L(λ c): what is spent and regained returns to δ = 0.

    Found in y = −ln(1 − λ s), over which nothing is steep; NaN where y is above ``STEEP``.
    """
    spent = 0.5 * m_in * c * c
    lost = spent - 0.5 * m_out * s * s
    lossless = lost <= LOSSLESS * spent
    # Near 0 the equation over λ² is −lost + λ (m_in c³ + m_out s³)/3 + …
    guess = 3.0 * lost / (m_in * c * c * c + m_out * s * s * s) * s
    y = np.where(guess < SMALL_LOSS, -np.log1p(-np.minimum(guess, SMALL_LOSS)), c / s)
    low, high = np.zeros_like(y), np.full_like(y, np.inf)
    for _ in range(MOST_STEPS):
        share = -np.expm1(-y)
        x, slope = share / s, (1.0 - share) / s
        back = np.where(share < SERIES, _excess(-share), y - share)
        value = m_out * back - m_in * _excess(x * c)
        rate = m_out * share - m_in * x * c / (1.0 + x * c) * c * slope
        # Over λ²: the trivial root at 0 taken out.
        rate = rate - 2.0 * value * slope / x
        low, high = np.where(value > 0.0, low, y), np.where(value > 0.0, y, high)
        new = y - np.where(rate > 0.0, value / rate, np.inf)
        middle = np.where(high < np.inf, 0.5 * (low + high), 2.0 * y)
        new = np.where((low <= new) & (new <= high), new, middle)
        ended = lossless | (np.abs(new - y) <= NEWTON_ENDS * y)
        if ended.all():
            break
        y = np.where(ended, y, new)
    found = np.where(y < STEEP, -np.expm1(-y) / s, np.nan)
    return np.where(lossless, 0.0, found)


def _stored(mass: np.ndarray, x: np.ndarray, end: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return the energy of the spring where the rate is, of a phase that begins or ends with
    ``end``."""
    undamped = np.abs(x * end) < UNDAMPED
    damping = np.where(undamped, 1.0, x)
    damped = mass / (damping * damping) * (_excess(x * end) - _excess(x * rate))
    return np.where(undamped, 0.5 * mass * (end * end - rate * rate), damped)


def _depth_of(stored: np.ndarray, k: float, n: float) -> np.ndarray:
    """Return δ at which k δ^(n + 1)/(n + 1) is an energy."""
    return ((n + 1.0) * np.maximum(stored, 0.0) / k) ** (1.0 / (n + 1.0))


def _rate_at_peak(x: np.ndarray, c: np.ndarray, n: float) -> np.ndarray:
    """Return δ' where the force is largest; Newton's steps come down to it from c."""
    at = x * c
    aim = (n + 1.0) * _excess(at)
    for _ in range(MOST_STEPS):
        over = n * at + (n + 1.0) * _excess(at) - aim
        step = over / (n + (n + 1.0) * at / (1.0 + at))
        at = np.maximum(at - step, 0.0)
        if (step <= NEWTON_ENDS * at).all():
            break
    return at / np.where(x > 0.0, x, 1.0)


def viscous_peak(
    c: Any, s: Any, m_in: Any, m_out: Any, k: float, n: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return λ [s/m], the largest indentation [m] and the largest force [N]; NaN for e below 0.03.

    Args:
        c, s: (B,) or numbers, speeds of approach and separation [m/s]; both above 0.
        m_in, m_out: effective masses of compression and restitution [kg].
        k, n: stiffness [N/m^n] and exponent.
    """
    c, s, m_in, m_out = (np.asarray(each, dtype=float) for each in (c, s, m_in, m_out))
    with np.errstate(all="ignore"):
        x = _damping(c, s, m_in, m_out)
        deepest = _depth_of(_stored(m_in, x, c, np.zeros_like(x)), k, n)
        rate = _rate_at_peak(x, c, n)
        depth = _depth_of(_stored(m_in, x, c, rate), k, n)
    bad = np.isnan(x)
    peak = k * depth**n * (1.0 + x * rate)
    return x, np.where(bad, np.nan, deepest), np.where(bad, np.nan, peak)


class Viscous:
    """F = k δ^n (1 + λ δ'), with λ from the restitution.

    Time is ∫ dp/F, in which F ~ p^(n/(n + 1)) at both ends: quadrature of Gauss and Jacobi.
    """

    def __init__(self, phases: Phases, stiffness: float, exponent: float, where: str) -> None:
        if phases.separation == 0.0:
            raise RangeError.of(
                f"{where}: restitution under HuntCrossley", 0, "above 0 (a damper stops no motion)"
            )
        self.phases, self._k, self._n = phases, stiffness, exponent
        self.remaining = 0.0
        c, s = phases.approach, phases.separation
        found = viscous_peak(c, s, phases.mass_in, phases.mass_out, stiffness, exponent)
        self.damping, self.deepest, self.peak = (float(each) for each in found)
        if not self.damping >= 0.0:
            raise RangeError.of("HuntCrossley: restitution", s / c, "above 0.03")

    def _depth(self, rate: Any, inwards: bool) -> np.ndarray:
        """Return δ where it changes at rates."""
        phases = self.phases
        mass = phases.mass_in if inwards else phases.mass_out
        end = phases.approach if inwards else -phases.separation
        ends = (np.asarray(each, dtype=float) for each in (mass, self.damping, end, rate))
        with np.errstate(all="ignore"):
            return _depth_of(_stored(*ends), self._k, self._n)

    def _force(self, rate: Any, inwards: bool) -> np.ndarray:
        return self._k * self._depth(rate, inwards) ** self._n * (1.0 + self.damping * rate)

    @cached_property
    def compression(self) -> float:
        """The duration of the compression [s]."""
        return self._time_near_end(0.0, True)

    @cached_property
    def duration(self) -> float:
        """The duration of the contact [s]."""
        return self.compression + self._time_near_end(0.0, False)

    def _time_near_end(self, rate: float, inwards: bool) -> float:
        """Return the time from the first contact to a rate, or from there to the last one [s]."""
        phases, n, x = self.phases, self._n, self.damping
        mass = phases.mass_in if inwards else phases.mass_out
        end = phases.approach if inwards else -phases.separation
        if end == rate:
            return 0.0
        power = n / (n + 1.0)
        nodes, weights = _jacobi(-power)
        if x * phases.approach > DAMPED:
            # Over y = ln(1 + λ δ') what is near 1 + λ δ' = 0 is far: dt = m dy/(λ k δ^n).
            start = 1.0 + x * end
            whole = abs(math.log(start / (1.0 + x * rate)))
            y = whole * nodes if inwards else -whole * nodes
            depth = _depth_of(mass / (x * x) * (-start * np.expm1(-y) - y), self._k, n)
            parts = mass / (x * self._k * depth**n)
        else:
            whole = mass * abs(end - rate)
            parts = 1.0 / self._force(end - np.copysign(whole * nodes / mass, end), inwards)
        # ∫ y^(−power) [y^power part(y)] dy from 0 to ``whole``.
        return float(weights @ ((whole * nodes) ** power * parts) * whole ** (1.0 - power))

    def at(self, fraction: float) -> Sample:
        """Return the sample at a place of the way: 0 to 1 in compression, 1 to 2 in restitution."""

        phases = self.phases
        if fraction <= 1.0:
            rate = phases.approach * math.cos(0.5 * math.pi * fraction) if fraction < 1.0 else 0.0
            time = self._time_near_end(rate, True)
            impulse = phases.mass_in * (phases.approach - rate)
            return self._sample(time, rate, impulse, True)
        rate = -phases.separation * math.sin(0.5 * math.pi * (fraction - 1.0))
        rate = -phases.separation if fraction == 2.0 else rate
        time = self.duration - self._time_near_end(rate, False)
        impulse = phases.mass_in * phases.approach - phases.mass_out * rate
        return self._sample(time, rate, impulse, False)

    def _sample(self, time: float, rate: float, impulse: float, inwards: bool) -> Sample:
        force, depth = float(self._force(rate, inwards)), float(self._depth(rate, inwards))
        return Sample(time, force, depth, rate, impulse)


@cache
def _jacobi(power: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights on (0, 1) for ∫ x^power f(x) dx."""
    from scipy.special import roots_jacobi

    nodes, weights = roots_jacobi(NODES, 0.0, power)
    return 0.5 * (nodes + 1.0), weights * 0.5 ** (power + 1.0)
