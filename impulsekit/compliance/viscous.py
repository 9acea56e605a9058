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
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, RangeError
from .curves import MeasuredCurve, PowerCurve

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


class Way:
    """A contact's way on a curve, F = (1 + λ δ') F(δ): in, and out again.

    With a damper λ follows from the restitution, and unloading ends at δ = 0. Without one, λ = 0,
    unloading follows the curve over r δ, r the share of the work regained. Everything is a function
    of the rate δ': the energy of the spring, from it the indentation, and the time.

    Attributes:
        phases: of the contact.
        damping: λ [s/m].
    """

    def __init__(
        self, phases: Phases, curve: PowerCurve | MeasuredCurve, where: str, viscous: bool
    ) -> None:
        self.phases, self._curve, self.damping = phases, curve, 0.0
        self._share = min(phases.regained / phases.spent, 1.0)
        if not viscous or not isinstance(curve, PowerCurve):
            return
        if phases.separation == 0.0:
            raise RangeError.of(
                f"{where}: restitution under HuntCrossley", 0, "above 0 (a damper stops no motion)"
            )
        c, s, masses = phases.approach, phases.separation, (phases.mass_in, phases.mass_out)
        found = viscous_peak(c, s, *masses, curve.stiffness, curve.exponent)
        self.damping, _, self.peak = (float(each) for each in found)
        self._share = 1.0
        if not self.damping >= 0.0:
            raise RangeError.of("HuntCrossley: restitution", s / c, "above 0.03")

    @cached_property
    def deepest(self) -> float:
        """The largest indentation [m]."""
        return self._curve.deepest(self._stored(0.0, True))

    @cached_property
    def peak(self) -> float:
        """The largest force [N]; that of a curve that softens may come before the deepest point."""
        most = self.deepest
        points = getattr(self._curve, "indentation", ())
        before = [self._curve.force(d) for d in points if d < most]
        return max([self._curve.force(most), *before])

    @property
    def remaining(self) -> float:
        """The permanent indentation [m]."""
        return (1.0 - self._share) * self.deepest

    @cached_property
    def compression(self) -> float:
        """The duration of the compression [s]."""
        return self._time_near_end(0.0, self.deepest, True)

    @cached_property
    def duration(self) -> float:
        """The duration of the contact [s]."""
        return self.compression + self._time_near_end(0.0, self.deepest, False)

    def at(self, fraction: float) -> Sample:
        """Return the sample at a place of the way: 0 to 1 in compression, 1 to 2 in restitution."""
        phases, inwards = self.phases, fraction <= 1.0 or self.phases.separation == 0.0
        place = 0.5 * math.pi * (min(fraction, 1.0) if inwards else 2.0 - fraction)
        mass, end = self._end(inwards)
        if self.damping:
            rate = end * math.cos(place) if place < 0.5 * math.pi else 0.0
            elastic = self._curve.deepest(self._stored(rate, inwards))
        else:
            elastic = self.deepest * math.sin(place)
            left = max(phases.spent - self._curve.energy(elastic), 0.0)
            left *= 1.0 if inwards else self._share
            rate = math.copysign(math.sqrt(2.0 * left / mass), end)
            rate = rate if place < 0.5 * math.pi else 0.0
        time, impulse = self._time_near_end(rate, elastic, inwards), mass * (end - rate)
        depth = elastic
        if not inwards:
            time, impulse = self.duration - time, phases.impulse + impulse
            depth = self.remaining + self._share * elastic
        force = self._curve.force(elastic) * (1.0 + self.damping * rate)
        return Sample(time, force, depth, rate, impulse)

    def _end(self, inwards: bool) -> tuple[float, float]:
        """Return mass and rate at the end of a phase."""
        phases = self.phases
        if inwards:
            return phases.mass_in, phases.approach
        return phases.mass_out, -phases.separation

    def _stored(self, rate: float, inwards: bool) -> float:
        """Return the energy of the spring where it changes at a rate."""
        mass, end = self._end(inwards)
        with np.errstate(all="ignore"):
            stored = float(_stored(*map(np.asarray, (mass, self.damping, end, rate))))
        return max(stored, 0.0)

    def _time_near_end(self, rate: float, elastic: float, inwards: bool) -> float:
        """Return the time from the first contact to a place, or from there to the last one [s]."""
        (mass, end), curve = self._end(inwards), self._curve
        if end == rate:
            return 0.0
        if self.damping == 0.0 or not isinstance(curve, PowerCurve):
            # Backwards the way out is a loading with mass r m and speed s/r on the same curve.
            share = 1.0 if inwards else self._share
            return curve.time(elastic, share * mass, abs(end) / share)
        k, n, x = curve.stiffness, curve.exponent, self.damping
        power = n / (n + 1.0)
        nodes, weights = _jacobi(-power)
        if x * self.phases.approach > DAMPED:
            # Over y = ln(1 + λ δ') what is near 1 + λ δ' = 0 is far: dt = m dy/(λ k δ^n).
            start = 1.0 + x * end
            whole = abs(math.log(start / (1.0 + x * rate)))
            y = whole * nodes if inwards else -whole * nodes
            depth = _depth_of(mass / (x * x) * (-start * np.expm1(-y) - y), k, n)
            parts = mass / (x * k * depth**n)
        else:
            whole = mass * abs(end - rate)
            rates = end - np.copysign(whole * nodes / mass, end)
            with np.errstate(all="ignore"):
                depth = _depth_of(_stored(*map(np.asarray, (mass, x, end, rates))), k, n)
            parts = 1.0 / (k * depth**n * (1.0 + x * rates))
        # ∫ y^(−power) [y^power part(y)] dy from 0 to ``whole``.
        return float(weights @ ((whole * nodes) ** power * parts) * whole ** (1.0 - power))


@cache
def _jacobi(power: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights on (0, 1) for ∫ x^power f(x) dx."""
    from scipy.special import roots_jacobi

    nodes, weights = roots_jacobi(NODES, 0.0, power)
    return 0.5 * (nodes + 1.0), weights * 0.5 ** (power + 1.0)
