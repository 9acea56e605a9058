"""The unknowns of a fit: coefficients of contacts and inertias of bodies, put into scenes."""

from __future__ import annotations

import re
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
        entry: the contact, the pattern or names of contacts that share it, or the joint before
            the body.
        contacts: the contacts that have it.
        index: which inertia parameter.
        start, low, high: where the fit starts, and its bounds.
    """

    kind: str
    entry: str
    index: int
    start: float
    low: float
    high: float
    contacts: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """How results call it."""
        what = INERTIA_PARAMETERS[self.index] if self.kind == "inertia" else self.kind
        return f"{self.entry}: {what}"


def parameters_of(
    scenes: Scene | Sequence[Scene],
    restitution: Sequence[str | Sequence[str]],
    friction: Sequence[str | Sequence[str]],
    inertias: Mapping[str, Sequence[str]],
) -> list[Parameter]:
    """The unknowns by their names, starting from the values of the scenes, the first one's first.

    A pattern with ``*`` or ``?``, such as "corner_*", or a tuple of names is one unknown that
    these contacts share.

    Raises:
        UnknownNameError: no such contact, joint or inertia parameter.
        InputError: a coefficient that is no number.
    """
    several = [scenes] if isinstance(scenes, Scene) else list(scenes)
    scene = several[0]
    contacts: dict[str, Any] = {}
    for each in {id(each): each for each in several}.values():
        contacts = {
            **dict(zip(each.entry_names("contacts"), each.contacts, strict=True)),
            **contacts,
        }
    found = []
    for kind, wanted in (("restitution", restitution), ("friction", friction)):
        taken: dict[str, str] = {}
        for given in wanted:
            entry, names = _tied(given, contacts)
            for name in names:
                if name in taken:
                    raise InputError(
                        f"fit: {kind} of {name} is in {taken[name]} and in {entry}; name it once"
                    )
                taken[name] = entry
                if not isinstance(getattr(contacts[name], kind, None), float):
                    raise InputError(f"fit_impacts: {name} has no {kind} that is a number")
            start = float(np.mean([getattr(contacts[name], kind) for name in names]))
            high = 1.0 if kind == "restitution" else np.inf
            found.append(Parameter(kind, entry, 0, start, 0.0, high, names))
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


def _tied(given: str | Sequence[str], contacts: Mapping[str, Any]) -> tuple[str, tuple[str, ...]]:
    """What a shared coefficient is called, and the contacts that share it."""
    if not isinstance(given, str):
        names = tuple(str(name) for name in given)
        entry = ", ".join(names)
    elif given not in contacts and set("*?") & set(given):
        parts = re.split(r"([*?])", given)
        fitting = re.compile("".join({"*": ".*", "?": "."}.get(p, re.escape(p)) for p in parts))
        names = tuple(name for name in contacts if fitting.fullmatch(name))
        entry = given
    else:
        names, entry = (given,), given
    for name in names or (entry,):
        if name not in contacts:
            raise UnknownNameError.among("contact", name, contacts, "fit_impacts")
    return entry, names


def changed_scene(scene: Scene, parameters: Sequence[Parameter], x: np.ndarray) -> Scene:
    """A scene with the values x (P,) of the unknowns."""
    changes: dict[str, dict[str, Any]] = {}
    bodies: dict[str, dict[int, float]] = {}
    for parameter, value in zip(parameters, x.tolist(), strict=True):
        if parameter.kind == "inertia":
            bodies.setdefault(parameter.entry, {})[parameter.index] = value
        for name in parameter.contacts:
            changes.setdefault(name, {})[parameter.kind] = value
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
