"""The unknowns of a fit: coefficients of contacts and inertias of bodies, put into scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, UnknownNameError
from ..robot import Robot
from ..scene import JointStop, Rope, Scene

__all__ = ["INERTIA_PARAMETERS", "Parameter", "changed_scene", "parameters_of"]

# The order of pinocchio.Inertia.toDynamicParameters.
INERTIA_PARAMETERS = ("mass", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz")


@dataclass(frozen=True)
class Parameter:
    """One unknown.

    Attributes:
        kind: "restitution", "friction" or "inertia".
        entry: the contact, or the joint before the body.
        index: which inertia parameter.
        start, low, high: where the fit starts, and its bounds.
    """

    kind: str
    entry: str
    index: int
    start: float
    low: float
    high: float

    @property
    def name(self) -> str:
        """How results call it."""
        what = INERTIA_PARAMETERS[self.index] if self.kind == "inertia" else self.kind
        return f"{self.entry}: {what}"


def parameters_of(
    scene: Scene,
    restitution: Sequence[str],
    friction: Sequence[str],
    inertias: Mapping[str, Sequence[str]],
) -> list[Parameter]:
    """The unknowns by their names, starting from a scene's values.

    Raises:
        UnknownNameError: no such contact, joint or inertia parameter.
        InputError: a coefficient that is no number.
    """
    contacts = dict(zip(scene.entry_names("contacts"), scene.contacts, strict=True))
    found = []
    for kind, wanted in (("restitution", restitution), ("friction", friction)):
        for name in wanted:
            if name not in contacts:
                raise UnknownNameError.among("contact", name, contacts, "fit_impacts")
            value = getattr(contacts[name], kind, None)
            if not isinstance(value, float):
                raise InputError(f"fit_impacts: {name} has no {kind} that is a number")
            high = 1.0 if kind == "restitution" else np.inf
            found.append(Parameter(kind, name, 0, value, 0.0, high))
    for joint, items in inertias.items():
        values = scene.robot.model.inertias[scene.robot.joint_id(joint)].toDynamicParameters()
        for item in items:
            if item not in INERTIA_PARAMETERS:
                raise UnknownNameError.among(
                    "inertia parameter", item, INERTIA_PARAMETERS, "fit_impacts"
                )
            index = INERTIA_PARAMETERS.index(item)
            low = 0.0 if item in ("mass", "ixx", "iyy", "izz") else -np.inf
            found.append(Parameter("inertia", joint, index, float(values[index]), low, np.inf))
    return found


def changed_scene(scene: Scene, parameters: Sequence[Parameter], x: np.ndarray) -> Scene:
    """A scene with the values x (P,) of the unknowns."""
    changes: dict[str, dict[str, Any]] = {}
    bodies: dict[str, dict[int, float]] = {}
    for parameter, value in zip(parameters, x.tolist(), strict=True):
        if parameter.kind == "inertia":
            bodies.setdefault(parameter.entry, {})[parameter.index] = value
        else:
            changes.setdefault(parameter.entry, {})[parameter.kind] = value
    contacts = []
    for name, entry in zip(scene.entry_names("contacts"), scene.contacts, strict=True):
        own = changes.get(name, {})
        if isinstance(entry, JointStop | Rope):
            own = {key: value for key, value in own.items() if key == "restitution"}
        contacts.append(replace(entry, **own))
    robot = scene.robot
    if bodies:
        model = pin.Model(robot.model)
        for joint, items in bodies.items():
            joint_id = robot.joint_id(joint)
            values = model.inertias[joint_id].toDynamicParameters()
            for index, value in items.items():
                values[index] = value
            model.inertias[joint_id] = pin.Inertia.FromDynamicParameters(values)
        robot = Robot.from_model(model)
    return replace(scene, robot=robot, contacts=contacts)
