"""The scene of one row of a batch, and what needs it: uniqueness, bounds of outcomes, motions."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ..impact.all_outcomes import outcome_bounds
from ..impact.solver import solve_without_warnings
from ..impact.status import BY_CODE
from ..scene import Scene
from ..scene.impulses import with_numbers
from .inputs import BatchInputs, of_row
from .masses import scaled_robot
from .result import VERDICTS

__all__ = ["bounds_of", "scene_of_row", "verdicts_of"]


def verdicts_of(scene: Scene, inputs: BatchInputs, codes: np.ndarray) -> np.ndarray:
    """(B,) the index in ``VERDICTS`` of each row: "not proven" of rows without a valid answer."""
    found = np.full(inputs.size, VERDICTS.index("not proven"), dtype=np.int8)
    for row in range(inputs.size):
        if not BY_CODE[int(codes[row])].valid:
            continue
        own = scene_of_row(scene, inputs, row) if inputs.varies else scene
        impact = solve_without_warnings(own, *inputs.state(row))
        found[row] = VERDICTS.index(impact.uniqueness.verdict)
    return found


def bounds_of(scene: Scene, inputs: BatchInputs, codes: np.ndarray) -> np.ndarray:
    """(B, 2, nv) the least and largest v⁺ of each row's outcomes; NaN of rows not valid."""
    found = np.full((inputs.size, 2, scene.robot.nv), np.nan)
    for row in range(inputs.size):
        if BY_CODE[int(codes[row])].valid:
            own = scene_of_row(scene, inputs, row) if inputs.varies else scene
            found[row] = outcome_bounds(solve_without_warnings(own, *inputs.state(row)))
    return found


def scene_of_row(scene: Scene, inputs: BatchInputs, row: int) -> Scene:
    """The scene with the impulses, coefficients, masses and points of a row."""
    impulses = with_numbers(scene.impulses, of_row(inputs.impulses, row))
    contacts: list = []
    contact: Any
    for i, contact in enumerate(scene.contacts):
        changes: dict[str, Any] = {}
        for name in ("restitution", "friction"):
            array = getattr(inputs, name)
            if array is not None and hasattr(contact, name):
                changes[name] = float(of_row(array, row)[i])
        if i in inputs.pointed and inputs.points is not None:
            at = 3 * inputs.pointed.index(i)
            changes["at"] = of_row(inputs.points, row)[at : at + 3]
        contacts.append(dataclasses.replace(contact, **changes))
    robot = scene.robot
    if inputs.masses is not None:
        factors = of_row(inputs.masses, row).tolist()
        robot = scaled_robot(robot, dict(zip(inputs.links, factors, strict=True)))
    return dataclasses.replace(scene, robot=robot, impulses=impulses, contacts=contacts)
