"""Forces along the normal impulse of a contact: its two phases, and Hunt and Crossley's force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple, Protocol

import numpy as np

from ..errors import InputError, RangeError
from ..laws.borrowed import borrowing
from ..laws.compiled import entry

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
    """The phases of a contact that was struck.

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


@borrowing
def _excess(x: float) -> float:
    """x − ln(1 + x), to all its digits near 0."""
    if abs(x) > SERIES:
        return x - math.log1p(x)
    total, term = 0.0, x
    for k in range(2, 16):
        term *= -x
        total -= term / k
    return total


@borrowing
def _damping(c: float, s: float, m_in: float, m_out: float) -> float:
    """λ [s/m] with m_r L(−λ s) = m_c L(λ c): what is spent and regained returns to δ = 0.

    Found in y = −ln(1 − λ s), over which nothing is steep; NaN where y is above ``STEEP``.
    """
    spent = 0.5 * m_in * c * c
    lost = spent - 0.5 * m_out * s * s
    if lost <= LOSSLESS * spent:
        return 0.0
    # Near 0 the equation over λ² is −lost + λ (m_in c³ + m_out s³)/3 + …
    guess = 3.0 * lost / (m_in * c * c * c + m_out * s * s * s) * s
    y = -math.log1p(-guess) if guess < SMALL_LOSS else c / s
    low, high = 0.0, math.inf
    for _ in range(MOST_STEPS):
        share = -math.expm1(-y)
        x, slope = share / s, (1.0 - share) / s
        back = _excess(-share) if share < SERIES else y - share
        value = m_out * back - m_in * _excess(x * c)
        rate = m_out * share - m_in * x * c / (1.0 + x * c) * c * slope
        # Over λ²: the trivial root at 0 taken out.
        rate -= 2.0 * value * slope / x
        if value > 0.0:
            high = y
        else:
            low = y
        step = value / rate if rate > 0.0 else math.inf
        new = y - step
        if not low <= new <= high:
            new = 0.5 * (low + high) if high < math.inf else 2.0 * y
        if abs(new - y) <= NEWTON_ENDS * y:
            break
        y = new
    return -math.expm1(-y) / s if y < STEEP else math.nan


@borrowing
def _stored(mass: float, x: float, end: float, rate: float) -> float:
    """The energy of the spring where the rate is, of a phase that begins or ends with ``end``."""
    if abs(x * end) < UNDAMPED:
        return 0.5 * mass * (end * end - rate * rate)
    return mass / (x * x) * (_excess(x * end) - _excess(x * rate))


@borrowing
def _depth_of(stored: float, k: float, n: float) -> float:
    """δ at which k δ^(n + 1)/(n + 1) is an energy."""
    return ((n + 1.0) * max(stored, 0.0) / k) ** (1.0 / (n + 1.0))


@borrowing
def _rate_at_peak(x: float, c: float, n: float) -> float:
    """δ' where the force is largest; Newton's steps come down to it from c."""
    end = x * c
    if end == 0.0:
        return 0.0
    aim = (n + 1.0) * _excess(end)
    at = end
    for _ in range(MOST_STEPS):
        over = n * at + (n + 1.0) * _excess(at) - aim
        step = over / (n + (n + 1.0) * at / (1.0 + at))
        at = max(at - step, 0.0)
        if step <= NEWTON_ENDS * at:
            break
    return at / x


@entry(lambda: (1.0, 0.5, 1.0, 1.0, 1e6, 1.5), seconds=1.5)
def viscous_peak(
    c: float, s: float, m_in: float, m_out: float, k: float, n: float
) -> tuple[float, float, float]:
    """λ [s/m], the largest indentation [m] and the largest force [N]; NaN for e below 0.03.

    Args:
        c, s: speeds of approach and separation [m/s]; both above 0.
        m_in, m_out: effective masses of compression and restitution [kg].
        k, n: stiffness [N/m^n] and exponent.
    """
    x = _damping(c, s, m_in, m_out)
    if not x >= 0.0:
        return math.nan, math.nan, math.nan
    deepest = _depth_of(_stored(m_in, x, c, 0.0), k, n)
    rate = _rate_at_peak(x, c, n)
    depth = _depth_of(_stored(m_in, x, c, rate), k, n)
    return x, deepest, k * depth**n * (1.0 + x * rate)


def _examples() -> tuple[object, ...]:
    return np.ones(2), np.ones(2), np.ones(2), 1e6, 1.5, np.ones((2, 3))


@entry(_examples, seconds=2.0)
def viscous_peaks(
    c: np.ndarray, s: np.ndarray, mass: np.ndarray, k: float, n: float, out: np.ndarray
) -> None:
    """``viscous_peak`` of many contacts, of one mass in both phases, into (B, 3) ``out``."""
    for i in range(len(c)):
        x, deepest, peak = viscous_peak(c[i], s[i], mass[i], mass[i], k, n)
        out[i, 0], out[i, 1], out[i, 2] = x, deepest, peak


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
        self.damping, self.deepest, self.peak = viscous_peak(
            c, s, phases.mass_in, phases.mass_out, stiffness, exponent
        )
        if not self.damping >= 0.0:
            raise RangeError.of("HuntCrossley: restitution", s / c, "above 0.03")

    def _depth(self, rate: float, inwards: bool) -> float:
        """δ where it changes at a rate."""
        phases = self.phases
        mass = phases.mass_in if inwards else phases.mass_out
        end = phases.approach if inwards else -phases.separation
        return _depth_of(_stored(mass, self.damping, end, rate), self._k, self._n)

    def _force(self, rate: float, inwards: bool) -> float:
        return float(self._k * self._depth(rate, inwards) ** self._n * (1.0 + self.damping * rate))

    @cached_property
    def compression(self) -> float:
        """The duration of the compression [s]."""
        return self._time_near_end(0.0, True)

    @cached_property
    def duration(self) -> float:
        """The duration of the contact [s]."""
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
                depth = _depth_of(mass / (x * x) * stored, self._k, n)
                return mass / (x * self._k * depth**n)
        else:
            whole = mass * abs(end - rate)

            def part(y: float) -> float:
                return 1.0 / self._force(end - math.copysign(y / mass, end), inwards)

        # ∫ y^(−power) [y^power part(y)] dy from 0 to ``whole``.
        total = 0.0
        for node, weight in _jacobi(-power):
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


@cache
def _jacobi(power: float) -> list[tuple[float, float]]:
    """Nodes and weights on (0, 1) for ∫ x^power f(x) dx."""
    from scipy.special import roots_jacobi

    nodes, weights = roots_jacobi(NODES, 0.0, power)
    weights = weights * 0.5 ** (power + 1.0)
    return list(zip((0.5 * (nodes + 1.0)).tolist(), weights.tolist(), strict=True))
