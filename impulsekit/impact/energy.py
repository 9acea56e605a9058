"""The energy balance: the work of every entry of the scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import RangeError
from ..formatting import Displayed
from ..named import ByName
from ..scene import AppliedImpulse
from ..tolerances import NONZERO

if TYPE_CHECKING:
    from .touched import TouchedAnswer

__all__ = ["Energy", "energy_books"]


@dataclass(frozen=True, repr=False)
class Energy(Displayed):
    """Kinetic energy and work [J].

    Attributes:
        before, after: kinetic energy ½ vᵀ M v.
        change: after − before, computed from the velocities alone: ½ (v⁺ + v⁻)ᵀ M Δv.
        work: by entry name, the work of its impulse: impulse · (u⁻ + u⁺)/2 with the
            velocity u it acts on (Kelvin's theorem). The sum is ``change``.
        of_lost_velocities: ½ Δvᵀ M Δv. Where constraints are imposed and nothing else
            strikes, this is what is lost (Carnot's theorem).
    """

    before: float
    after: float
    change: float
    of_lost_velocities: float
    work: Mapping[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "before": self.before,
            "after": self.after,
            "change": self.change,
            "of_lost_velocities": self.of_lost_velocities,
            "work": dict(self.work),
        }

    @property
    def imbalance(self) -> float:
        """Sum of the works minus the change, relative to the largest energy or work."""
        scale = max(self.before, self.after, *(abs(w) for w in self.work.values()), NONZERO)
        return abs(sum(self.work.values()) - self.change) / scale


def energy_books(impact: TouchedAnswer) -> Energy:
    """The energy of an impact by entry.

    Raises:
        RangeError: velocities so large that their energy is no double.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        books = _books(impact)
    numbers = (books.before, books.after, books.change, books.of_lost_velocities)
    if not all(map(math.isfinite, (*numbers, *books.work.values()))):
        largest = float(np.abs([impact.v_before, impact.v_after, impact.dv]).max())
        # A velocity that is no number itself is for those to tell who put it there.
        if math.isfinite(largest):
            allowed = "such that their energy does not overflow, 1e150 at most"
            raise RangeError.of("velocities", largest, allowed)
    return books


def _books(impact: TouchedAnswer) -> Energy:
    mechanics = impact.mechanics
    mean = 0.5 * (impact.v_before + impact.v_after)
    work: dict[str, float] = {}
    scene = impact.scene
    for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
        if isinstance(entry, AppliedImpulse):
            wrench = np.array(entry.values)
            work[name] = float(wrench @ (mechanics.impulse_jacobian(entry) @ mean))
        else:
            work[name] = float(np.dot(entry.impulse, mean[mechanics.joint_rows(entry.joint)]))
    work.update({result.name: result.work for result in impact.constraints})
    work.update({result.name: result.work for result in impact.contacts})
    momentum_jump = mechanics.mass_matrix @ impact.dv
    return Energy(
        before=0.5 * float(impact.v_before @ impact.momentum_before),
        after=0.5 * float(impact.v_after @ impact.momentum_after),
        change=float(mean @ momentum_jump),
        of_lost_velocities=0.5 * float(impact.dv @ momentum_jump),
        work=ByName(work, "entry"),
    )
