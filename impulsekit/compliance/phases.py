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
from functools import cached_property
from typing import NamedTuple, Protocol

from ..errors import InputError, RangeError

__all__ = ["FASTEST", "SLOWEST", "Elastic", "Phases", "Sample", "phases_of"]

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
        """How long the compression lasts [s]."""
        return self.curve.time(self.deepest, self.phases.mass_in, self.phases.approach)

    @cached_property
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
