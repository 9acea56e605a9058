"""The balance of momentum of a motion: forces and impulses together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...formatting import OneLine
from ...named import ByName
from ...robot.arrays import lock
from ...scene import AppliedImpulse
from .energies import momenta_of

if TYPE_CHECKING:
    from ...impact import Impact
    from .sampled import SampledMotion

__all__ = ["MomentumBalance", "momentum_balance"]


@dataclass(frozen=True, eq=False, repr=False)
class MomentumBalance(OneLine):
    """The sources of the momentum of all moving bodies between two times.

    World axes, (6,) each: linear [N s] before angular about the world's origin [N m s].

    Attributes:
        start, end: [s]; impacts at the end belong to it, those at the start do not.
        change: of the momentum.
        shares: by entry of the scene, "weight", and "base": what joints to the world gave. An
            entry between bodies that move changes nothing.
    """

    start: float
    end: float
    change: np.ndarray
    shares: Mapping[str, np.ndarray]

    @property
    def residual(self) -> np.ndarray:
        """(6,) what the shares leave unexplained: the error of motion and forces together."""
        return self.change - sum(self.shares.values(), np.zeros(6))


def momentum_balance(
    motion: SampledMotion, start: float | None, end: float | None
) -> MomentumBalance:
    """The balance between two times; see ``Trajectory.balance``."""
    a, b = motion.checked_span(start, end)
    held = [*motion.scene.entry_names("held"), *motion.scene.entry_names("contacts")]
    names = [*held, *motion.scene.entry_names("forces"), "weight", "base"]
    total = motion.loads.integral(a, b, lambda loads: loads.wrenches.ravel(), 6 * len(names))
    shares = {name: np.zeros(6) for name in motion.scene.entry_names("impulses")}
    shares |= dict(zip(names, total.reshape(-1, 6), strict=True))
    hits = [impact for time, impact in motion.impacts if (start is None or time > a) and time <= b]
    first = motion.at(a)
    if start is None and hits and motion.impacts[0][0] == a:
        first = hits[0].q, hits[0].v_before
    for impact in hits:
        _add(shares, impact)
    lock(*shares.values())
    q, v = map(np.array, zip(first, motion.at(b), strict=True))
    momentum = momenta_of(motion, (q, v))
    ends = np.hstack([momentum.linear, momentum.angular])
    change = ends[1] - ends[0]
    change.setflags(write=False)
    return MomentumBalance(a, b, change, ByName(shares, "entry"))


def _add(shares: dict[str, np.ndarray], impact: Impact) -> None:
    """Add an impact's momentum to the shares of its entries."""
    scene, loads = impact.scene, impact.loads
    struck = zip(scene.entry_names("impulses"), scene.impulses, strict=True)
    names = [name for name, entry in struck if isinstance(entry, AppliedImpulse)]
    names += [*scene.entry_names("held"), *scene.entry_names("contacts")]
    for name, wrench in zip(names, loads.entries.reshape(-1, 6), strict=True):
        shares[name] = shares[name] + wrench
    shares["base"] = shares["base"] + loads.base
