"""From a TOML file to a ``Scene`` with its state, or to all faults of the file at once."""

from __future__ import annotations

import dataclasses
import os
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pydantic

from ..errors import ImpulsekitError, SceneFileError, quoted, warn_of_setup
from ..errors.calls import public
from ..files import path_of, read_text_file, reason_of
from ..formatting import OneLine
from ..robot import Robot
from ..robot import state as states
from ..robot.arrays import lock
from ..robot.state import outside_limits
from ..scene import Scene
from ..scene.motion import MotionSettings
from ..scene.numbers import Vector
from ..scene.points import DesignPoint, ReportPoint
from .faults import Faults, no_such_key, tuples_of
from .robots import read_robots
from .vocabulary import (
    DESIGN,
    MOTION,
    MOVED,
    POINTS,
    SECTIONS,
    STRICT,
    Section,
    read_section,
)

_OWN = ("robot", "robots", "state", *MOVED, "motion", "design", "report", "batch")
_TOP = (*_OWN, *(section.name for section in SECTIONS))

_Numbers = pydantic.TypeAdapter(tuple[float, ...], config=pydantic.ConfigDict(strict=True))


_defaults: dict[str, Any] = {field.name: field.default for field in dataclasses.fields(Scene)}


@public
@dataclass(frozen=True, eq=False, repr=False)
class SceneFile(OneLine):
    """A scene file, read.

    Attributes:
        path: the file.
        scene: what strikes the robot.
        q: (nq,) configuration, read-only.
        v: (nv,) velocity before the impact, read-only.
        points: points whose velocity a report prints.
        motion: how the motion after the impact is followed; None where the file has no
            table [motion].
        design: points whose impact design measures are asked for.
    """

    path: str
    scene: Scene
    q: np.ndarray
    v: np.ndarray
    points: tuple[ReportPoint, ...] = ()
    motion: MotionSettings | None = None
    design: tuple[DesignPoint, ...] = ()


class _Settings(pydantic.BaseModel):
    """Keys of a file for the whole scene, above its first table."""

    model_config = STRICT
    gravity: Vector = _defaults["gravity"]
    gap_bound: Annotated[float, pydantic.AllowInfNan(True)] = _defaults["gap_bound"]
    controlled: tuple[str, ...] = _defaults["controlled"]


@public
def load_scene(path: str | os.PathLike[str]) -> SceneFile:
    """Read a scene file.

    Raises:
        SceneFileError: the file has errors; all are reported at once, each with its place
            and, for a name, the nearest that exist.

    Warns:
        SetupWarning: a joint of the state is outside its limits.

    Example:
        >>> file = load_scene("examples/whittaker_chain.toml")
        >>> file.scene.impulses[0].linear
        (0.0, 5.0, 0.0)
    """
    path = path_of(path, "a scene file")
    file = _scene_file(_read_toml(path), path, os.path.dirname(os.path.abspath(path)))
    warn_of_setup(outside_limits(file.scene.robot, file.q))
    return file


def read_scene(text: str, source: str) -> SceneFile:
    """Return the scene that a text holds, as ``load_scene`` reads it from a file.

    Args:
        text: the TOML.
        source: what messages call it.

    Raises:
        SceneFileError: all faults of the text.
    """
    return _scene_file(_parsed(lambda: text, source), source, os.getcwd())


def _scene_file(data: dict[str, Any], path: str, folder: str) -> SceneFile:
    faults = Faults()
    for key in data:
        if key not in _TOP:
            faults.add(no_such_key(key, key, _TOP))
    robot = read_robots(data, folder, faults, MOVED)
    q, v = _read_state(data.get("state", {}), robot, faults)
    settings = faults.validated(_Settings, {k: data[k] for k in MOVED if k in data}, "")
    if robot is not None and settings is not None:
        _tried(lambda names: Scene(robot, controlled=names), settings.controlled, "", faults, None)
    parts: dict[str, Any] = {}
    for section in SECTIONS:
        if section.name in data:
            parts[section.name] = read_section(section, data[section.name], robot, faults)
    points = _read_points(POINTS, data.get("report", {}), robot, faults)
    design = _read_points(DESIGN, data.get("design", {}), robot, faults)
    motion = read_section(MOTION, data["motion"], robot, faults) if "motion" in data else None
    if not faults and robot is not None and settings is not None:
        try:
            scene = Scene(robot, **parts, **dict(settings))
            return SceneFile(path, scene, q, v, points, motion, design)
        except ImpulsekitError as error:
            # What is wrong with no entry alone, such as two of one name.
            faults.add(str(error).removeprefix("Scene: "))
    raise faults.error(path)


def _read_toml(path: str) -> dict[str, Any]:
    def text() -> str:
        return read_text_file(path).decode("utf-8-sig").replace("\r\n", "\n")

    return _parsed(text, path)


def _parsed(text: Callable[[], str], path: str) -> dict[str, Any]:
    try:
        return tuples_of(tomllib.loads(text()))
    except tomllib.TOMLDecodeError as error:
        words = str(error).replace("Cannot overwrite a value", "a key or table stands there twice")
        reason = f"not well-formed TOML: {words}"
    except UnicodeDecodeError as error:
        reason = f"not UTF-8 text: byte {error.start} is {error.object[error.start]:#04x}"
    except RecursionError:
        reason = "not a scene: its values are nested too deep"
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else str(error)
    raise SceneFileError(f"{path}: {reason}", path=path, faults=(reason,)) from None


def _read_state(raw: Any, robot: Robot | None, faults: Faults) -> tuple[np.ndarray, np.ndarray]:
    q = np.zeros(0) if robot is None else robot.neutral()
    v = np.zeros(0) if robot is None else robot.velocity()
    if not isinstance(raw, dict):
        faults.add("state must be a table with q and v")
        return q, v
    for key in raw:
        if key not in ("q", "v"):
            faults.add(no_such_key(f"state.{key}", key, ("q", "v"), MOVED))
    if robot is not None:
        q = _read_vector(raw.get("q", {}), "q", robot, faults, q)
        v = _read_vector(raw.get("v", {}), "v", robot, faults, v)
    lock(q, v)
    return q, v


def _read_vector(
    raw: Any, letter: str, robot: Robot, faults: Faults, otherwise: np.ndarray
) -> np.ndarray:
    """A whole vector from a list, or from a table by joint name."""
    place, is_q = f"state.{letter}", letter == "q"
    if not isinstance(raw, dict | tuple):
        faults.add(f"{place} must be a list, or a table by joint name, got {quoted(raw)}")
        return otherwise
    if isinstance(raw, tuple):
        check = states.checked_configuration if is_q else states.checked_velocity
        numbers = _numbers(raw, place, faults)
        return _tried(lambda x: check(robot.model, x), numbers, place, faults, otherwise)

    def by_name(values: dict[str, Any]) -> np.ndarray:
        return states.configuration(robot, values) if is_q else robot.velocity(values)

    given = {}
    for name, value in raw.items():
        # One joint at a time, so that each has its say.
        at = f"{place}.{name}"
        numbers = _numbers(value if isinstance(value, tuple) else (value,), at, faults)
        if _tried(lambda x, n=name: by_name({n: x}), numbers, at, faults, None) is not None:
            given[name] = numbers
    return by_name(given)


def _numbers(raw: Any, place: str, faults: Faults) -> Any:
    try:
        return _Numbers.validate_python(raw)
    except pydantic.ValidationError as error:
        for part in error.errors():
            where = place + "".join(f"[{i}]" for i in part["loc"] if len(raw) > 1)
            faults.add(f"{where} must be a number, got {quoted(part['input'])}")
        return None


def _tried(make: Callable, value: Any, place: str, faults: Faults, otherwise: Any) -> Any:
    if value is None:
        return otherwise
    try:
        return make(value)
    except ImpulsekitError as error:
        faults.add(f"{place}: {error}" if place else str(error))
        return otherwise


def _read_points(section: Section, raw: Any, robot: Robot | None, faults: Faults) -> tuple:
    """The points of a table such as [report]."""
    table, _, key_of_points = section.name.partition(".")
    if not isinstance(raw, dict):
        faults.add(f"{table} must be a table with {key_of_points}")
        return ()
    for key in raw:
        if key != key_of_points:
            faults.add(no_such_key(f"{table}.{key}", key, (key_of_points,), MOVED))
    return read_section(section, raw.get(key_of_points, ()), robot, faults)
