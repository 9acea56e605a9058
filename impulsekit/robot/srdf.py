"""SRDF, which MoveIt writes beside a URDF: named poses, and pairs of links that never collide."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

from ..errors import UrdfError, shown
from ..files import read_text_file, reason_of
from .urdf import parsed_xml


@dataclass(frozen=True)
class Srdf:
    """What an SRDF says of a robot, by the names of its URDF.

    Attributes:
        disabled: pairs of links whose collisions are disabled.
        poses: by the name of a pose, the values of its joints; states of several groups that have
            one name are one pose.
    """

    disabled: frozenset[frozenset[str]]
    poses: Mapping[str, Mapping[str, tuple[float, ...]]]


def read_srdf(path: str | os.PathLike[str]) -> Srdf:
    """Read an SRDF file.

    Raises:
        UrdfError: no such file, broken XML, or a joint value that is no number.

    Example:
        >>> from impulsekit.robot.examples import example_srdf
        >>> sorted(read_srdf(example_srdf("talos")).poses)
        ['half_sitting']
    """
    source = os.fspath(path)
    try:
        text = read_text_file(path).decode("utf-8-sig").lstrip()
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "the file is not UTF-8 text"
        raise UrdfError(f"{shown(source, 200)}: {reason}", source=source, element="") from None
    robot = parsed_xml(text, source)
    disabled = frozenset(
        frozenset((pair.get("link1", ""), pair.get("link2", "")))
        for pair in robot.findall("disable_collisions")
    )
    poses: dict[str, dict[str, tuple[float, ...]]] = {}
    for state in robot.findall("group_state"):
        pose = poses.setdefault(state.get("name", ""), {})
        for joint in state.findall("joint"):
            name, words = joint.get("name", ""), joint.get("value", "")
            try:
                pose[name] = tuple(map(float, words.split()))
            except ValueError:
                raise UrdfError(
                    f'{source}: <group_state name="{shown(state.get("name", ""))}">: joint '
                    f'"{shown(name)}" has the value "{shown(words)}", expected numbers',
                    source=source,
                    element="group_state",
                ) from None
    return Srdf(disabled, poses)
