"""The scene of one row of a batch, and what needs it: verdicts on uniqueness, and motions."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ..impact.solver import solve_without_warnings
from ..impact.status import BY_CODE
from ..scene import Scene
from ..scene.impulses import with_numbers
from .inputs import BatchInputs
from .masses import scaled_robot
from .result import VERDICTS

__all__ = ["scene_of_row", "varies", "verdicts_of"]


def verdicts_of(scene: Scene, inputs: BatchInputs, codes: np.ndarray) -> np.ndarray:
    """(B,) the index in ``VERDICTS`` of each row: "not proven" of rows without a valid answer."""
    rows_differ = varies(scene, inputs)
    found = np.full(inputs.size, VERDICTS.index("not proven"), dtype=np.int8)
    for row in range(inputs.size):
        if not BY_CODE[int(codes[row])].valid:
            continue
        own = scene_of_row(scene, inputs, row) if rows_differ else scene
        q, v = (x[row if len(x) > 1 else 0] for x in (inputs.q, inputs.v))
        found[row] = VERDICTS.index(solve_without_warnings(own, q, v).uniqueness.verdict)
    return found


def varies(scene: Scene, inputs: BatchInputs) -> bool:
    """Whether the rows are not all of the scene's own impulses and coefficients."""
    own = [x for entry in scene.impulses for x in entry.values]
    if len(inputs.given) > 1 or not np.array_equal(inputs.given[0], own):
        return True
    given = (inputs.restitution, inputs.friction, inputs.masses, inputs.points)
    return any(each is not None for each in given)


def scene_of_row(scene: Scene, inputs: BatchInputs, row: int) -> Scene:
    """The scene with the impulses, coefficients, masses and points of a row."""
    given = inputs.given[row if len(inputs.given) > 1 else 0]
    impulses = with_numbers(scene.impulses, given)
    contacts: list = []
    contact: Any
    for i, contact in enumerate(scene.contacts):
        changes: dict[str, Any] = {}
        for name in ("restitution", "friction"):
            array = getattr(inputs, name)
            if array is not None and hasattr(contact, name):
                changes[name] = float(array[row if len(array) > 1 else 0, i])
        if i in inputs.pointed and inputs.points is not None:
            at = 3 * inputs.pointed.index(i)
            own = inputs.points[row if len(inputs.points) > 1 else 0]
            changes["at"] = own[at : at + 3]
        contacts.append(dataclasses.replace(contact, **changes))
    robot = scene.robot
    if inputs.masses is not None:
        factors = inputs.masses[row if len(inputs.masses) > 1 else 0].tolist()
        robot = scaled_robot(robot, dict(zip(inputs.links, factors, strict=True)))
    return dataclasses.replace(scene, robot=robot, impulses=impulses, contacts=contacts)
