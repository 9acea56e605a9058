"""Rows that the kernels leave: one after the other by the solver of single states."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from ..errors import (
    ContradictionError,
    ImpulsekitError,
    NotFiniteError,
    RangeError,
    SingularMassError,
    StateError,
)
from ..impact.contact_results import ContactResult
from ..impact.result import Impact
from ..impact.solver import solve_without_warnings
from ..laws.status import Status
from ..rows.entries import rows_of_entry
from ..scene import AppliedImpulse, Scene
from .inputs import BatchInputs
from .masses import scaled_robot
from .result import VERDICTS

__all__ = ["scene_of_row", "solve_rows", "varies"]


def solve_rows(
    scene: Scene,
    inputs: BatchInputs,
    rows: Iterable[int],
    arrays: dict[str, np.ndarray],
    codes: np.ndarray,
    verdicts: np.ndarray,
) -> None:
    """Solve those rows and write their answers, codes and verdicts on their uniqueness."""
    rows_differ = varies(scene, inputs)
    for row in rows:
        if inputs.codes[row] != Status.SOLVED:
            codes[row] = inputs.codes[row]
            continue
        q = inputs.q[row if len(inputs.q) > 1 else 0]
        v = inputs.v[row if len(inputs.v) > 1 else 0]
        try:
            impact = solve_without_warnings(
                scene_of_row(scene, inputs, row) if rows_differ else scene, q, v
            )
            _write(scene, impact, row, arrays)
            codes[row] = impact.status
            if impact.status.valid:
                verdicts[row] = VERDICTS.index(impact.uniqueness.verdict)
        except ImpulsekitError as error:
            # A function that fails is no fault of this row alone.
            if error.from_function:
                raise
            codes[row] = _code(error)


def _code(error: ImpulsekitError) -> Status:
    for kind, code in (
        (NotFiniteError, Status.NOT_FINITE),
        (StateError, Status.OFF_MANIFOLD),
        (RangeError, Status.OUT_OF_RANGE),
        (SingularMassError, Status.SINGULAR_MASS),
        (ContradictionError, Status.CONTRADICTION),
    ):
        if isinstance(error, kind):
            return code
    return Status.REFUSED


def varies(scene: Scene, inputs: BatchInputs) -> bool:
    """Whether the rows are not all of the scene's own impulses and coefficients."""
    own: list[float] = []
    for entry in scene.impulses:
        own.extend(
            (*entry.linear, *entry.angular) if isinstance(entry, AppliedImpulse) else entry.values
        )
    if len(inputs.given) > 1 or not np.array_equal(inputs.given[0], own):
        return True
    given = (inputs.restitution, inputs.friction, inputs.masses, inputs.points)
    return any(each is not None for each in given)


def scene_of_row(scene: Scene, inputs: BatchInputs, row: int) -> Scene:
    """The scene with the impulses, coefficients, masses and points of a row."""
    numbers = inputs.given[row if len(inputs.given) > 1 else 0].tolist()
    impulses: list = []
    for entry in scene.impulses:
        if isinstance(entry, AppliedImpulse):
            part, numbers = numbers[:6], numbers[6:]
            impulses.append(dataclasses.replace(entry, linear=part[:3], angular=part[3:]))
        else:
            size = len(entry.values)
            part, numbers = numbers[:size], numbers[size:]
            impulses.append(dataclasses.replace(entry, impulse=tuple(part)))
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


def _write(scene: Scene, impact: Impact, row: int, arrays: dict[str, np.ndarray]) -> None:
    for name, array in arrays.items():
        if name == "energy_change":
            array[row] = impact.energy.change
        elif name == "contact_impulses":
            for i, contact in enumerate(impact.contacts):
                array[row, i] = 0.0
                array[row, i, : len(contact.impulse)] = contact.impulse
        elif name == "normal_components":
            for i, contact in enumerate(impact.contacts):
                array[row, i] = _along_normal(contact)
        elif name == "constraint_impulses":
            array[row] = _constraint_impulses(scene, impact)
        elif name == "reactions":
            array[row] = [impact.reactions[name] for name in scene.robot.joint_names]
        elif name == "bodies":
            moved = [impact.bodies[link.name] for link in scene.robot.links]
            changes = [[*body.dv_com, *body.domega] for body in moved]
            array[row] = np.reshape(changes, array[row].shape)
        else:
            array[row] = getattr(impact, name)


def _along_normal(contact: ContactResult) -> tuple[float, float, float]:
    """Mean normal velocity before and after, and normal impulse, of points that carry one."""
    loaded = [point for point in contact.points if point.impulse.any()]
    if not loaded:
        return 0.0, 0.0, 0.0
    found = np.array(
        [
            [vector @ normal for vector in (p.velocity_before, p.velocity_after, p.impulse)]
            for p in loaded
            # A joint stop pushes along its coordinate: the sign of its impulse is its normal.
            for normal in (np.sign(p.impulse) if p.normal is None else p.normal,)
        ]
    )
    return float(found[:, 0].mean()), float(found[:, 1].mean()), float(found[:, 2].sum())


def _constraint_impulses(scene: Scene, impact: Impact) -> np.ndarray:
    """(rows,) of the scene's constraints; 0 of the control of a joint that met its stop."""
    parts = []
    for name, entry in zip(scene.entry_names("held"), scene.held, strict=True):
        found = [each.impulse for each in impact.constraints if each.name == name]
        parts += found or [np.zeros(len(rows_of_entry(scene.robot, entry).labels))]
    return np.concatenate([*parts, np.zeros(0)])
