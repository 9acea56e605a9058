"""Derivatives of v⁺ by the state where rows are functions of q, by differences of impacts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..impact.solver import solve_without_warnings
from ..scene import GapConstraint, GapContact, Scene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["has_functions", "slopes_by_differences"]

# Step of central differences [m, rad, m/s, rad/s]: truncation 1e-10 of the speeds, and rounding
# 1e-10, or 1e-7 where gradients are differences of gaps themselves.
STEP = 1e-5
# What touches is held to touch at all states of the differences: gaps are less by this [m, rad],
# more than the fastest gap changes in a step.
HELD_TOUCHING = 1.0


def has_functions(scene: Scene) -> bool:
    """Whether rows of a scene are functions of q, whose second derivatives nobody gives."""
    entries = (*scene.contacts, *scene.constraints)
    return any(isinstance(entry, GapContact | GapConstraint) for entry in entries)


@dataclass(frozen=True)
class _Lowered:
    """A gap that is less by ``HELD_TOUCHING``: its gradient, and so every impact, is the same."""

    gap: Callable[[Any], Any]

    def __call__(self, q: np.ndarray) -> Any:
        return np.asarray(self.gap(q), dtype=float) - HELD_TOUCHING


def slopes_by_differences(
    scene: Scene, q: ArrayLike, v: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """∂v⁺/∂q on its tangent and ∂v⁺/∂v⁻, each (nv, nv); what touches at q goes on touching.

    By central differences, which lie between both sides where the mode changes at (q, v).
    """
    place, speed = np.array(q, dtype=float), np.array(v, dtype=float)
    touching = {c.name for c in solve_without_warnings(scene, q, v).contacts if c.touching}
    contacts = [
        replace(entry, gap=_Lowered(entry.gap))
        if isinstance(entry, GapContact) and name in touching
        else entry
        for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True)
    ]
    held, model = replace(scene, contacts=contacts), scene.robot.model

    def after(way: np.ndarray, faster: np.ndarray) -> np.ndarray:
        return solve_without_warnings(
            held, pin.integrate(model, place, way), speed + faster
        ).v_after

    none, steps = np.zeros(len(speed)), STEP * np.eye(len(speed))
    by_q = [(after(step, none) - after(-step, none)) / (2 * STEP) for step in steps]
    by_v = [(after(none, step) - after(none, -step)) / (2 * STEP) for step in steps]
    return np.array(by_q).T, np.array(by_v).T
