"""Outcomes as text: intervals of v⁺ and of joint loads, and the answers of the laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..formatting import decimals, table
from .forms import speeds_of

if TYPE_CHECKING:
    from ..impact import Outcomes

__all__ = ["outcome_blocks"]

PARTS = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z")


def outcome_blocks(outcomes: Outcomes) -> list[list[str]]:
    """Return the lines of a report, section by section; the first of each is its title."""
    impact, bounds = outcomes.impact, outcomes.bounds
    speeds = speeds_of(impact.scene.robot, impact.q)
    shown, size = [*bounds, *outcomes.laws.values()], float(np.abs(bounds).max())
    rows = [
        [f"{speed.title} [{speed.unit}]", *(decimals(v[i], size) for v in shown)]
        for i, speed in enumerate(speeds)
    ]
    most = float(np.abs(outcomes.impulses).max())
    loads = [
        [name, *(f"{decimals(low, most)} to {decimals(high, most)}" for low, high in own.T)]
        for name, own in outcomes.joint_loads.items()
    ]
    left_out = f"{outcomes.jammed} jammed and {outcomes.gained} with a gain of energy left out"
    return [
        [
            f"{impact.scene.robot.name}: {len(outcomes)} outcomes, {left_out}",
            "contacts compress in any order and shares; intervals are inner bounds",
        ],
        ["Velocities after the impact", *table(["", "least", "largest", *outcomes.laws], rows)],
        ["Joint loads [N s, N m s], in the axes of each joint", *table(["", *PARTS], loads)],
    ]
