"""The robots of a scene file: [robot], or [robots.NAME] for several in one world."""

from __future__ import annotations

import dataclasses
import os
from typing import Any, Literal

import numpy as np
import pinocchio as pin
import pydantic

from ..errors import ImpulsekitError, InputError, UrdfError
from ..robot import Robot, RobotPart
from ..robot.combine import combine
from ..robot.examples import example_names, example_path, example_urdf
from ..robot.placing import pose
from ..robot.source import Changes, Ground
from ..scene.numbers import Vector
from .faults import Faults
from .vocabulary import STRICT, model_of

Row = tuple[float, float, float, float]
ROOTS = ("fixed", "planar", "sagittal", "freeflyer")


class BodyTable(pydantic.BaseModel):
    """[[robot.bodies]]: a body welded to a link."""

    model_config = STRICT
    frame: str
    name: str | None = None
    mass: float
    com: Vector = (0.0, 0.0, 0.0)
    inertia: tuple[float, ...] | None = None


class RobotTable(pydantic.BaseModel):
    """[robot]"""

    model_config = STRICT
    urdf: str | None = None
    example: str | None = None
    root: Literal["fixed", "planar", "sagittal", "freeflyer"] = "fixed"
    mimic: bool = False
    package_dirs: tuple[str, ...] = ()
    armature: dict[str, float | tuple[float, ...]] = {}
    gear: dict[str, float] = {}
    bodies: tuple[BodyTable, ...] = ()
    lock: dict[str, float] = {}
    # Keys of [[robot.grounds]] are the fields of ``Ground``.
    grounds: tuple[model_of(Ground), ...] = ()  # type: ignore[valid-type]


class PlacementTable(pydantic.BaseModel):
    """The placement of a robot's root: a point [m] with roll, pitch, yaw [rad], or a 4×4 matrix."""

    model_config = STRICT
    xyz: Vector | None = None
    rpy: Vector | None = None
    matrix: tuple[Row, Row, Row, Row] | None = None


class PlacedRobotTable(RobotTable):
    """[robots.NAME]"""

    placement: PlacementTable | None = None


def read_robots(
    data: dict[str, Any], folder: str, faults: Faults, top: tuple[str, ...]
) -> Robot | None:
    """Return the robot of a file, or None with the reasons in ``faults``."""
    if ("robot" in data) == ("robots" in data):
        both = "robot" in data
        faults.add(
            "[robot] and [robots] exclude each other"
            if both
            else "[robot] is missing: a file has [robot], or [robots.NAME] for each of several"
        )
        return None
    if "robot" in data:
        table = faults.validated(RobotTable, data["robot"], "robot", top)
        return None if table is None else _built(table, folder, "robot", faults)
    if not isinstance(data["robots"], dict) or not data["robots"]:
        faults.add("robots must be a table [robots.NAME] for each robot")
        return None
    robots: dict[str, Robot] = {}
    placements = {}
    for name, raw in data["robots"].items():
        place = f"robots.{name}"
        table = faults.validated(PlacedRobotTable, raw, place, top)
        robot = None if table is None else _built(table, folder, place, faults)
        if table is None or robot is None:
            continue
        placement = _placement(table.placement or PlacementTable(), f"{place}.placement", faults)
        try:
            # Alone first, so that each has its say.
            combine({name: robot}, placements={name: placement})
        except ImpulsekitError as error:
            faults.add(f"{place}: {str(error).removeprefix('combine: ')}")
        else:
            robots[name], placements[name] = robot, placement
    if len(robots) < len(data["robots"]):
        return None
    return combine(robots, placements=placements)


def _built(table: RobotTable, folder: str, place: str, faults: Faults) -> Robot | None:
    if (table.urdf is None) == (table.example is None):
        has = "neither is there" if table.urdf is None else "both are there"
        faults.add(f'{place}: give either urdf = "FILE" or example = "NAME"; {has}')
        return None
    step = "urdf" if table.example is None else "example"
    try:
        if table.example is not None:
            robot = Robot.from_example(table.example, table.root, mimic=table.mimic)
        else:
            urdf, folders = table.urdf or "", [os.path.join(folder, x) for x in table.package_dirs]
            if not urdf.lstrip().startswith("<"):
                urdf = os.path.join(folder, urdf)
            robot = Robot.from_urdf(urdf, table.root, mimic=table.mimic, package_dirs=folders)
        step = "armature"
        if table.armature or table.gear:
            robot = robot.with_armature(table.armature, gear=table.gear)
        step = "bodies"
        for body in table.bodies:
            robot = robot.with_body(**body.model_dump())
        step = "lock"
        if table.lock:
            robot = robot.with_lock(table.lock)
        step = "grounds"
        for ground in table.grounds:
            robot = robot.with_ground(**ground.model_dump(exclude_unset=True))
    except ImpulsekitError as error:
        faults.add(f"{place}.{step}: {error}")
        return None
    return robot


def _placement(table: PlacementTable, place: str, faults: Faults) -> pin.SE3 | np.ndarray:
    if table.matrix is None:
        return pose(table.xyz or (0.0, 0.0, 0.0), rpy=table.rpy)
    if table.xyz is not None or table.rpy is not None:
        faults.add(f"{place}: matrix excludes xyz and rpy")
    return np.array(table.matrix)


def part_as_table(part: RobotPart, folder: str | None) -> dict[str, Any]:
    """Return the table that makes a part of a robot again, bit for bit.

    Args:
        folder: paths are written relative to it; None writes them absolute.

    Raises:
        InputError: the part was made from a ``pin.Model`` or on a root without a name.
        UrdfError: its file is gone, or has changed since it was read.
    """
    if part.changes.text is not None:
        part = dataclasses.replace(part, urdf=part.changes.text)
    if part.urdf is None:
        raise InputError(
            "a robot made from a pin.Model cannot be written to a scene file; load it from a "
            "URDF or by the name of an example"
        )
    root = {"JointModelPlanar": "planar", "JointModelFreeFlyer": "freeflyer"}.get(
        part.root, part.root
    )
    if root not in ROOTS:
        raise InputError(
            f'a robot on a root of its own ("{part.root}") cannot be written to a scene file; '
            f"roots with a name are {', '.join(ROOTS)}"
        )
    table: dict[str, Any] = {}
    name = _example_of(part)
    if name is not None:
        table["example"] = name
    else:
        table["urdf"] = part.urdf if part.path is None else _path_of(part, folder)
        if part.package_dirs:
            table["package_dirs"] = [_relative(one, folder) for one in part.package_dirs]
    if root != "fixed":
        table["root"] = root
    if part.mimic:
        table["mimic"] = True
    table.update(_changes_as_table(part.changes))
    if part.placement is not None:
        matrix = np.array(part.placement)
        if not np.array_equal(matrix[:3, :3], np.eye(3)):
            table["placement"] = {"matrix": matrix.tolist()}
        elif matrix[:3, 3].any():
            table["placement"] = {"xyz": matrix[:3, 3].tolist()}
    return table


def _changes_as_table(changes: Changes) -> dict[str, Any]:
    """Armature, bodies, locks and grounds as they stand in a file."""
    table: dict[str, Any] = {
        "armature": {
            name: values[0] if len(values) == 1 else values for name, values in changes.armature
        },
        "bodies": [dataclasses.asdict(body) for body in changes.bodies],
        "lock": dict(changes.locks),
        "grounds": [
            {key: own for key, own in dataclasses.asdict(ground).items() if own is not False}
            for ground in changes.grounds
        ],
    }
    return {key: value for key, value in table.items() if value}


def _example_of(part: RobotPart) -> str | None:
    """The shortest name under which example-robot-data has a part."""
    for name in sorted(example_names(), key=lambda name: (len(name), name)):
        text = example_urdf(name)
        same = part.path == str(example_path(name)) if text is None else part.urdf == text
        # Where meshes are looked up goes with the name, and so does the text.
        if same and _source(Robot.from_example(name, mimic=part.mimic).parts[0]) == _source(part):
            return name
    return None


def _source(part: RobotPart) -> tuple[str | None, tuple[str, ...]]:
    return part.urdf, part.package_dirs


def _path_of(part: RobotPart, folder: str | None) -> str:
    path = part.path or ""
    # Through a symbolic link "../" may lead elsewhere: then the whole path has to do.
    for candidate in dict.fromkeys((_relative(path, folder), path)):
        if _text_at(os.path.join(folder or "", candidate)) == part.urdf:
            return candidate
    raise UrdfError(
        f"{part.path}: the file is gone or has changed since the robot was read; a scene file "
        "would name another robot",
        source=part.label,
        element="",
    )


def _text_at(path: str) -> str | None:
    from ..robot.urdf import read_urdf

    try:
        return read_urdf(path).text
    except UrdfError:
        return None


def _relative(path: str, folder: str | None) -> str:
    if folder is None:
        return path
    try:
        return os.path.relpath(path, folder).replace(os.sep, "/")
    except ValueError:  # another drive
        return path
