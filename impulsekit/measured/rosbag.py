"""Columns of a recording out of a ROS 2 bag, by rosbags (no ROS is needed)."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError, InputError, MissingExtraError, UnknownNameError, shown
from ..robot import Robot
from .columns import RecordingFormat

# [s]
NANOSECOND = 1e-9

_POSES = ("geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry",
          "geometry_msgs/msg/PoseWithCovarianceStamped",
          "geometry_msgs/msg/TransformStamped")  # fmt: skip
_JOINTS = "sensor_msgs/msg/JointState"


def columns_of_bag(
    path: str | os.PathLike[str], format: RecordingFormat, robot: Robot
) -> tuple[dict[str, Any], list[str]]:
    """Return columns by name, and notes on what is left out.

    Times are from the messages' own stamps; poses of the free root, joints by name.

    Without ``format.topics`` the only topic of poses and the only one of joint states are read.
    Where there are both, joints are taken at the times of the poses, on straight lines between
    their messages; poses before the first and after the last of these are left out.
    Twists of Odometry are not read, and noted: smoothed poses say the velocity.

    Raises:
        MissingExtraError: rosbags is not installed.
        FileError: the bag does not exist.
        UnknownNameError: it has no such topic.
        InputError: it has no topic of poses or joint states, or more than one.
    """
    with MissingExtraError.unless("rosbags", "record", "reading a ROS 2 bag"):
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    label = shown(Path(path).name, 80)
    try:
        with AnyReader([Path(path)], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            kinds = {c.topic: str(c.msgtype) for c in bag.connections}
            chosen = _chosen(kinds, format.topics, label)
            found: dict[str, list[tuple[float, Any]]] = {topic: [] for topic in chosen}
            connections = [c for c in bag.connections if c.topic in chosen]
            for connection, received, raw in bag.messages(connections=connections):
                message = bag.deserialize(raw, connection.msgtype)
                found[connection.topic].append((_stamp(message, received), message))
    except (AnyReaderError, OSError) as error:
        raise FileError(f"{label}: no ROS 2 bag ({error})", path=os.fspath(path)) from None
    start = min((own[0][0] for own in found.values() if own), default=None)
    if start is None:
        raise InputError(f"{label}: there is no message in its topics {', '.join(chosen)}")
    return _columns(found, kinds, start, robot), _notes(found)


def _notes(found: Mapping[str, list[tuple[float, Any]]]) -> list[str]:
    return [
        f"the twists of {topic} are not read: velocities are those of its poses"
        for topic, own in found.items()
        if own and hasattr(own[0][1], "twist")
    ]


def _chosen(kinds: Mapping[str, str], asked: Mapping[str, str] | None, label: str) -> list[str]:
    if asked is not None:
        for topic in asked:
            if topic not in kinds:
                raise UnknownNameError.among("topic", topic, kinds, label)
        return list(asked)
    poses = [topic for topic, kind in kinds.items() if kind in _POSES]
    joints = [topic for topic, kind in kinds.items() if kind == _JOINTS]
    if len(poses) > 1 or len(joints) > 1:
        raise InputError(
            f"{label}: several topics hold poses or joint states ({', '.join([*poses, *joints])}); "
            "name those meant in the RecordingFormat's topics"
        )
    if not poses and not joints:
        raise InputError(
            f"{label}: no topic holds poses or joint states, got {', '.join(kinds) or 'none'}"
        )
    return [*poses, *joints]


def _stamp(message: Any, received: int) -> float:
    """Return the message's own time [s]; when it was received, if it has none."""
    header = getattr(message, "header", None)
    if header is not None and (header.stamp.sec or header.stamp.nanosec):
        return float(header.stamp.sec) + NANOSECOND * float(header.stamp.nanosec)
    return NANOSECOND * received


def _pose(message: Any) -> list[float]:
    transform = getattr(message, "transform", None)
    if transform is not None:
        place, turn = transform.translation, transform.rotation
    else:
        pose = message.pose
        pose = getattr(pose, "pose", pose)
        place, turn = pose.position, pose.orientation
    return [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w]


def _angle(message: Any, name: str, topic: str) -> float:
    """Return the position of a joint that the topic's first message has."""
    positions = dict(zip(message.name, message.position, strict=False))
    if name not in positions:
        stamp = message.header.stamp
        raise InputError(
            f"{topic}: the joint states at {stamp.sec}.{stamp.nanosec:09d} s have no position of "
            f"joint {shown(name, 80)}, the first have; every message must have it"
        )
    return float(positions[name])


def _columns(
    found: Mapping[str, list[tuple[float, Any]]],
    kinds: Mapping[str, str],
    start: float,
    robot: Robot,
) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    times: np.ndarray | None = None
    span = -math.inf, math.inf
    for topic, own in found.items():
        if kinds[topic] in _POSES and own:
            times = np.array([time for time, _ in own]) - start
            numbers = np.array([_pose(message) for _, message in own])
            columns |= {"t": times, "position": numbers[:, :3], "quaternion_xyzw": numbers[:, 3:]}
    for topic, own in found.items():
        if kinds[topic] != _JOINTS or not own:
            continue
        names = list(own[0][1].name)
        stamps = np.array([time for time, _ in own]) - start
        span = max(span[0], stamps[0]), min(span[1], stamps[-1])
        for name in (str(each) for each in robot.model.names if str(each) in names):
            seen = np.array([_angle(m, name, topic) for _, m in own])
            if times is None:
                columns |= {"t": stamps, f"q.{name}": seen}
            else:
                columns[f"q.{name}"] = _between(times, stamps, seen, topic)
        joints = [str(each) for each in robot.model.names if str(each) != "universe"]
        if not set(names) & set(joints):
            raise InputError(
                f"{topic}: none of its joints ({shown(', '.join(names), 80)}) is one of the "
                f"robot's ({shown(', '.join(joints), 80)})"
            )
    return columns if times is None else _within(columns, *span)


def _within(columns: dict[str, Any], first: float, last: float) -> dict[str, Any]:
    """Return the rows between two times [s]."""
    kept = (columns["t"] >= first) & (columns["t"] <= last)
    if not kept.any():
        raise InputError(
            f"no pose of the bag lies between its first and last joint states, at {first:.9g} s "
            f"and {last:.9g} s after the first message"
        )
    return {key: each[kept] for key, each in columns.items()}


def _between(times: np.ndarray, stamps: np.ndarray, seen: np.ndarray, topic: str) -> np.ndarray:
    """Return positions of a joint at the times of poses, on straight lines."""
    if (np.diff(stamps) <= 0.0).any():
        k = int(np.flatnonzero(np.diff(stamps) <= 0.0)[0])
        raise InputError(
            f"{topic}: the stamps of joint states run back at {stamps[k]:.9g} s after the first "
            "message, expected each later than the one before"
        )
    return np.interp(times, stamps, seen)
