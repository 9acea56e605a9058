"""Force by indentation: Hertz, Hunt and Crossley, and curves that were measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeVar

from ..errors import InputError, RangeError, ShapeError, quoted
from ..errors.calls import public
from ..scene.numbers import between, keep, number, positive
from ..tolerances import EPS

# Forces at the ends of a piece that differ by less than this share are equal: the piece has no
# slope, and its time is that under a constant force.
SAME = 1e-9
# Roundings by which the deepest indentation may differ from itself as an argument.
ROUNDINGS = 8.0

if TYPE_CHECKING:
    import numpy as np

    Numbers = Sequence[float] | np.ndarray
    Floats = TypeVar("Floats", float, np.ndarray)
else:
    Numbers = tuple


@public
@dataclass(frozen=True)
class Hertz:
    """Two elastic bodies with round surfaces: F = 4/3 E* √R* δ^1.5 (Hertz 1882).

    1/E* = (1 − ν²)/E + (1 − ν'²)/E', 1/R* = 1/R + 1/R' (Johnson, Contact Mechanics, 4.2).
    What an impact loses stays as a permanent indentation: unloading follows a curve of the same
    form from the peak force down to δ_r = (1 − W_r/W_c) δ_max, where W_c is the work of the
    compression and W_r what is regained, so that the restitution of the impact is kept.

    Attributes:
        E: Young's modulus [Pa].
        nu: Poisson's ratio, -1 to 0.5.
        radius: of the surface [m].
        other_E, other_nu: of the other body; rigid unless given.
        other_radius: its radius [m]; flat unless given, negative where it is hollow.

    Raises:
        RangeError, NotFiniteError.

    Example:
        >>> steel = Hertz(E=210e9, nu=0.3, radius=0.01, other_E=210e9, other_nu=0.3)
        >>> round(steel.stiffness / 1e10, 3)  # N/m^1.5
        1.538
    """

    E: float
    nu: float
    radius: float
    other_E: float = math.inf
    other_nu: float = 0.0
    other_radius: float = math.inf

    def __post_init__(self) -> None:
        keep(self, "Hertz", positive, "E", "radius")
        for name, check in (("other_E", positive), ("other_radius", number)):
            if getattr(self, name) != math.inf:
                keep(self, "Hertz", check, name)
        keep(self, "Hertz", between(-1.0, 0.5), "nu", "other_nu")
        if self.other_radius == 0.0 or not self.curvature > 0.0:
            allowed = f"positive, or less than -radius = {-self.radius:g} for a hollow"
            raise RangeError.of("Hertz: other_radius", self.other_radius, allowed)

    @property
    def modulus(self) -> float:
        """E* [Pa]."""
        return 1.0 / ((1.0 - self.nu**2) / self.E + (1.0 - self.other_nu**2) / self.other_E)

    @property
    def curvature(self) -> float:
        """1/R* [1/m]."""
        return 1.0 / self.radius + 1.0 / self.other_radius

    @property
    def exponent(self) -> float:
        """1.5."""
        return 1.5

    @property
    def stiffness(self) -> float:
        """k in F = k δ^1.5 [N/m^1.5]."""
        return 4.0 / 3.0 * self.modulus / math.sqrt(self.curvature)

    def pressure(self, force: float) -> float:
        """Return the largest pressure under a force, p = (6 F E*²/(π³ R*²))^⅓ [Pa]."""
        return float(
            (6.0 * force * (self.modulus * self.curvature) ** 2 / math.pi**3) ** (1.0 / 3.0)
        )


@public
@dataclass(frozen=True)
class PowerCurve:
    """A curve F = k δ^n: a linear spring with n = 1, Hertz's contact with n = 1.5.

    The energy that an impact loses stays as a permanent indentation, as for ``Hertz``.
    ``energy``, ``force`` and ``deepest`` take numbers or arrays.

    Attributes:
        stiffness: k [N/m^n]; of a joint stop with rad in place of m.
        exponent: n, 1 to 10.

    Raises:
        RangeError: a stiffness that is not above 0, an exponent outside 1 to 10.
        NotFiniteError: something that is not a finite number.

    Example:
        >>> PowerCurve(stiffness=2e5, exponent=1.0).deepest(10.0)
        0.01
    """

    stiffness: float
    exponent: float = 1.0

    def __post_init__(self) -> None:
        _of_power(self)

    def energy(self, indentation: Floats) -> Floats:
        """Return ∫F dδ [J]."""
        return self.stiffness * indentation ** (self.exponent + 1.0) / (self.exponent + 1.0)

    def force(self, indentation: Floats) -> Floats:
        """Return F [N]."""
        return self.stiffness * indentation**self.exponent

    def deepest(self, energy: Floats) -> Floats:
        """Return the indentation that takes an energy [m]."""
        n = self.exponent + 1.0
        return (n * energy / self.stiffness) ** (1.0 / n)

    def time(self, indentation: float, mass: float, speed: float) -> float:
        """Return the time in which a mass with a speed reaches an indentation on its way in [s].

        δ_max/((n + 1) c) B(x; 1/(n + 1), ½) with x = (δ/δ_max)^(n + 1).
        """
        n = self.exponent + 1.0
        most = self.deepest(0.5 * mass * speed * speed)
        whole = float(most / (n * speed) * _beta(1.0 / n))
        x = (indentation / most) ** n
        # The deepest point, the most frequent argument, needs no incomplete beta function.
        if x >= 1.0 - ROUNDINGS * EPS:
            return whole
        from scipy.special import betainc

        return float(whole * betainc(1.0 / n, 0.5, x))


@public
@dataclass(frozen=True)
class HuntCrossley:
    """A spring with a damper that grows with it: F = k δ^n (1 + λ δ') (Hunt & Crossley 1975).

    λ is not given: it is found so that the restitution of the impact is kept, which must be
    above 0. With n = 1.5 and k of ``Hertz`` it is Hertz's contact with viscous losses.

    Attributes:
        stiffness: k [N/m^n].
        exponent: n, 1 to 10.

    Raises:
        RangeError, NotFiniteError.

    Example:
        >>> HuntCrossley(stiffness=1e8).exponent
        1.5
    """

    stiffness: float
    exponent: float = 1.5

    def __post_init__(self) -> None:
        _of_power(self)


@public
@dataclass(frozen=True)
class MeasuredCurve:
    """A force by indentation that was measured while loading, linear between the points.

    What an impact loses stays as a permanent indentation, as for ``Hertz``. The force starts at
    zero and stays above it; an impact that needs more than the last point is an error.

    Attributes:
        indentation: rising, from 0 [m]; for a joint stop [rad].
        force: at each, from 0 [N]; for a stop [N m].

    Raises:
        ShapeError, RangeError, NotFiniteError.

    Example:
        >>> foam = MeasuredCurve([0.0, 0.01, 0.02], [0.0, 50.0, 200.0])
        >>> round(foam.energy(0.015), 6)
        0.6875
    """

    indentation: Numbers
    forces: Numbers

    def __post_init__(self) -> None:
        what = "MeasuredCurve"
        depths = _numbers(self.indentation, f"{what}: indentation")
        forces = _numbers(self.forces, f"{what}: forces")
        if len(depths) < 2:
            raise ShapeError.of(f"{what}: indentation", (2,), (len(depths),), "two or more")
        if len(forces) != len(depths):
            raise ShapeError.of(f"{what}: forces", (len(depths),), (len(forces),))
        if depths[0] != 0.0 or any(b <= a for a, b in pairwise(depths)):
            raise RangeError.of(f"{what}: indentation", depths, "rising from 0")
        if forces[0] != 0.0 or min(forces[1:]) <= 0.0:
            raise RangeError.of(f"{what}: forces", forces, "0 first, then above 0")
        object.__setattr__(self, "indentation", depths)
        object.__setattr__(self, "forces", forces)

    @property
    def _points(self) -> list[tuple[float, float]]:
        return list(zip(self.indentation, self.forces, strict=True))

    def energy(self, indentation: float) -> float:
        """Return ∫F dδ [J]."""
        total = 0.0
        for (a, f), (b, g) in pairwise(self._points):
            end = min(b, indentation)
            if end <= a:
                break
            total += 0.5 * (end - a) * (2.0 * f + (g - f) * (end - a) / (b - a))
        return total

    def force(self, indentation: float) -> float:
        """Return F [N]."""
        import numpy as np

        return float(np.interp(indentation, self.indentation, self.forces))

    def deepest(self, energy: float) -> float:
        """Return the indentation that takes an energy [m].

        Raises:
            RangeError: more than the curve holds.
        """
        left = energy
        if not left > 0.0:
            return 0.0
        for (a, f), (b, g) in pairwise(self._points):
            whole = 0.5 * (f + g) * (b - a)
            if left <= whole:
                slope = (g - f) / (b - a)
                # ½ s x² + f x = left, in a form that holds for s → 0.
                return a + 2.0 * left / (f + math.sqrt(max(f * f + 2.0 * slope * left, 0.0)))
            left -= whole
        raise RangeError.of(
            "MeasuredCurve: energy of the impact", energy, f"at most {self._whole:.6g} J, its area"
        )

    @property
    def _whole(self) -> float:
        return self.energy(self.indentation[-1])

    def time(self, indentation: float, mass: float, speed: float) -> float:
        """Return the time in which a mass with a speed reaches an indentation on its way in [s].

        On each piece of slope s the motion is that of a spring: closed form.
        """
        start = 0.5 * mass * speed * speed
        most = self.deepest(start)
        until = min(indentation, most)
        total, v = 0.0, speed
        for (a, f), (b, g) in pairwise(self._points):
            end = min(b, until)
            if end <= a:
                break
            slope = (g - f) / (b - a)
            left = start - self.energy(end)
            # At the deepest point all is spent; the rest is rounding.
            w = 0.0 if end >= most else math.sqrt(max(2.0 * left / mass, 0.0))
            total += _time_on_spring(f, f + slope * (end - a), v, w, slope, mass)
            v = w
        return total


def _numbers(given: Numbers, what: str) -> tuple[float, ...]:
    try:
        entries = tuple(given)
    except TypeError:
        raise InputError(f"{what} must be a list of numbers, got {quoted(given)}") from None
    return tuple(number(each, what) for each in entries)


def _time_on_spring(f: float, g: float, v: float, w: float, slope: float, mass: float) -> float:
    """Return the time from force f and speed v to g and w, where force grows by ``slope`` [s]."""
    if abs(g - f) <= SAME * max(f, g):
        return 2.0 * mass * (v - w) / (f + g)
    rate = math.sqrt(abs(slope) / mass)
    if slope > 0.0:
        # F = A sin, m ω v = A cos.
        return (math.atan2(g, mass * rate * w) - math.atan2(f, mass * rate * v)) / rate
    return math.log((f + mass * rate * v) / (g + mass * rate * w)) / rate


def _beta(a: float) -> float:
    """Return B(a, ½)."""
    return math.gamma(a) * math.gamma(0.5) / math.gamma(a + 0.5)


def _of_power(entry: HuntCrossley | PowerCurve) -> None:
    what = type(entry).__name__
    keep(entry, what, positive, "stiffness")
    keep(entry, what, between(1.0, 10.0), "exponent")


Curve = Hertz | HuntCrossley | MeasuredCurve | PowerCurve
