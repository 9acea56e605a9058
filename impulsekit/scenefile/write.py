"""From a ``Scene`` and a state to a TOML file that reads back to the same, bit for bit."""

from __future__ import annotations

import dataclasses
import os
import pathlib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import tomli_w

from ..errors import InputError, a_thing, check_kind, quoted
from ..errors.calls import public
from ..files import ENDINGS, checked_output, write_file
from ..robot import Robot
from ..robot import state as states
from ..scene import Scene
from ..scene.coefficients import as_given
from ..scene.motion import MotionSettings
from ..scene.points import DesignPoint, ReportPoint
from .robots import part_as_table
from .vocabulary import DESIGN, MOTION, MOVED, NESTED, POINTS, SECTIONS, Section, default_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@public
def dump_scene(
    scene: Scene,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    *,
    points: Iterable[ReportPoint] = (),
    motion: MotionSettings | None = None,
    design: Iterable[DesignPoint] = (),
    folder: str | os.PathLike[str] | None = None,
) -> str:
    """Return the text of a scene file; read back, every float is the same double.

    Args:
        scene: what strikes the robot.
        q: (nq,) configuration; neutral unless given.
        v: (nv,) velocity before the impact; zero unless given.
        points: points whose velocity a report prints.
        motion: how the motion after the impact is followed.
        design: points whose impact design measures are asked for.
        folder: where the file will be; paths are written relative to it, else absolute.

    Raises:
        InputError: something that a scene file cannot hold, such as a robot made from a
            ``pin.Model``.
        UrdfError: the robot's file is gone, or has changed since it was read.
        ShapeError, NotFiniteError, StateError: what is wrong with q or v.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> text = dump_scene(Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])]))
        >>> print(text.splitlines()[1])
        example = "panda"
    """
    check_kind(scene, Scene, "dump_scene")
    robot = scene.robot
    model = robot.model
    q = robot.neutral() if q is None else states.checked_configuration(model, q)
    v = robot.velocity() if v is None else states.checked_velocity(model, v)
    blocks: list[str] = []
    for field in dataclasses.fields(Scene):
        value = getattr(scene, field.name)
        if field.name in MOVED and repr(value) != repr(field.default):
            blocks.append(_line(field.name, value))
    blocks += _robot_blocks(robot, None if folder is None else os.path.abspath(folder))
    parts = _by_joint(robot, q, robot.neutral(), "q"), _by_joint(robot, v, robot.velocity(), "v")
    blocks += [
        _table(f"[state.{key}]", part) for key, part in zip("qv", parts, strict=True) if part
    ]
    _check_writable(scene)
    for section in SECTIONS:
        entries = getattr(scene, section.name)
        # Without a table the numbers that contacts have from another one are their own.
        if section.name == "contacts" and scene.materials:
            entries = tuple(map(as_given, entries))
        blocks += _section_blocks(section, entries)
    if motion is not None:
        blocks += [_table("[motion]", _entry(MOTION, motion))]
    blocks += _section_blocks(DESIGN, tuple(design))
    blocks += _section_blocks(POINTS, tuple(points))
    return "\n".join(blocks)


@public
def save_scene(
    path: str | os.PathLike[str],
    scene: Scene,
    q: ArrayLike | None = None,
    v: ArrayLike | None = None,
    *,
    points: Iterable[ReportPoint] = (),
    motion: MotionSettings | None = None,
    design: Iterable[DesignPoint] = (),
) -> None:
    """Write a scene file; paths in it are relative to it. See ``dump_scene``.

    Raises:
        InputError: the path does not end in .toml; and others of ``dump_scene``.
        FileError: it cannot be written.

    Example:
        >>> from impulsekit import load_scene
        >>> file = load_scene("examples/hammer.toml")
        >>> save_scene("copy.toml", file.scene, file.q, file.v)  # doctest: +SKIP
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"save_scene takes a path first, then the scene, not {a_thing(path)}")
    path = pathlib.Path(checked_output(path, "save_scene: path", *ENDINGS["scene"]))
    folder = path.absolute().parent
    text = dump_scene(scene, q, v, points=points, motion=motion, design=design, folder=folder)
    write_file(path, text)


def _check_writable(scene: Scene) -> None:
    """Nothing of a scene is left out in silence."""
    known = {"robot", *MOVED, *(section.name for section in SECTIONS)}
    for item in dataclasses.fields(scene):
        if item.name not in known and repr(getattr(scene, item.name)) != repr(default_of(item)):
            raise InputError(f"a scene file cannot hold {item.name}")


def _robot_blocks(robot: Robot, folder: str | None) -> list[str]:
    parts = robot.parts
    if len(parts) == 1 and not parts[0].prefix:
        return [_table("[robot]", part_as_table(parts[0], folder))]
    blocks = []
    for part in parts:
        name = part.prefix.removesuffix("/")
        if not name or "/" in name:
            raise InputError(
                f'the robot "{name}" was combined twice; a scene file holds robots side by side'
            )
        blocks.append(_table(f"[robots.{_key(name)}]", part_as_table(part, folder)))
    return blocks


def _by_joint(robot: Robot, vector: np.ndarray, plain: np.ndarray, letter: str) -> dict[str, Any]:
    """The entries of q or v that are not plain, by joint; -0.0 is not 0.0."""
    table: dict[str, Any] = {}
    for name, joint in zip(list(robot.model.names)[1:], list(robot.model.joints)[1:], strict=True):
        start, size = getattr(joint, f"idx_{letter}"), getattr(joint, f"n{letter}")
        part = vector[start : start + size]
        if part.tobytes() != plain[start : start + size].tobytes():
            table[name] = part.tolist() if size > 1 else float(part[0])
    return table


def _section_blocks(section: Section, value: Any) -> list[str]:
    if not section.many:
        plain = value is None or value == type(value)()
        value = () if plain else (value,)
    head = f"[[{section.name}]]" if section.many else f"[{section.name}]"
    return [_table(head, _entry(section, entry)) for entry in value]


def _entry(section: Section, entry: Any) -> dict[str, Any]:
    kind = section.kind_of(entry)
    if kind is None:
        raise InputError(f"a scene file cannot hold a {type(entry).__name__} in {section.name}")
    table: dict[str, Any] = {"kind": kind} if section.needs_kind and len(section.kinds) > 1 else {}
    for item in dataclasses.fields(entry):
        value = getattr(entry, item.name)
        # By repr, for -0.0 equals 0.0.
        if repr(value) != repr(default_of(item)):
            table[item.name] = value
    return table


def _table(head: str, entries: Mapping[str, Any]) -> str:
    return head + "\n" + "".join(_line(key, value) for key, value in entries.items())


def _line(key: str, value: Any) -> str:
    return f"{_key(key)} = {_literal(value)}\n"


def _key(key: str) -> str:
    return tomli_w.dumps({key: 0}).removesuffix(" = 0\n")


def _literal(value: Any) -> str:
    """A value on one line; text of many lines, a URDF, on as many."""
    if isinstance(value, NESTED):
        value = {key: entry for key, entry in vars(value).items() if entry is not None}
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_literal(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_literal, value)) + "]"
    if callable(value):
        raise InputError("a scene file cannot hold a function of Python")
    if not isinstance(value, str | bool | int | float):
        raise InputError(f"a scene file cannot hold {quoted(value)}, a {type(value).__name__}")
    # TOML turns a carriage return at a line's end into a plain one.
    multiline = isinstance(value, str) and "\r" not in value
    return (
        tomli_w.dumps({"x": value}, multiline_strings=multiline).removeprefix("x = ").rstrip("\n")
    )
