"""``ForceField`` as compiled code: torques in joints and wrenches on bodies from tables.

What is a function of time alone is evaluated beforehand, at the times of a step's stages.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.point_table import Kinematics, back, origin, three, turned
from ..geometry.vectors import Vector, along, cross, dot
from ..laws.borrowed import borrowing
from .tree import Room, push

__all__ = [
    "ACTS",
    "BEYOND",
    "NO_LENGTH",
    "ON",
    "OUT",
    "SIDE",
    "SLACK",
    "Loads",
    "add_torques",
    "push_between",
    "push_bodies",
    "push_in_joint",
    "turned_from",
    "write_pushes",
]

# Ends of a spring nearer than this [m] have no direction between them.
NO_LENGTH = 1e-12
# Column of the state in tables of springs: out of its zone, without force; acts; without force,
# since the damper would pull what the spring pushes.
ON = 10
OUT, ACTS, SLACK = 0, 1, 2
# Column of the side of a PD law: 0 below its limit, 1 at the upper one, −1 at the lower one.
SIDE = 6
# A spring changes this far beyond its kink [m, rad, m/s, rad/s]: rounding does not bring it back,
# nor stop a joint with friction that has just begun to move.
BEYOND = 1e-13


class Loads(NamedTuple):
    """The forces of a scene.

    Attributes:
        constant: (nv,) torques that stay.
        joints: (a, 3) row in v and entry in q of a spring in a joint, and whether it is one of
            a joint that turns without end.
        in_joints: (a, 11) stiffness, damping, rest, side (0: both), a torque that is added,
            limit, the side of a PD law (SIDE), three unused, and the state (ON).
        rows: (b,) of driven torques, in v.
        springs: (c, 2) joints of both ends. between: (c, 11) both points in these joints' axes,
            stiffness, damping, rest length, way (1: pulls only, −1: pushes only, 0: both), and
            the state (ON).
        kinks: (d, 2) what has kinks: springs that act on one side only, 0 in a joint, 1 between
            points, and PD laws with a limit, 2; its row.
        applied: (e, 2) joint, and whether axes are the world's. at: (e, 12) the frame in the
            joint: R column by column and origin.
    """

    constant: np.ndarray
    joints: np.ndarray
    in_joints: np.ndarray
    rows: np.ndarray
    springs: np.ndarray
    between: np.ndarray
    kinks: np.ndarray
    applied: np.ndarray
    at: np.ndarray


@borrowing
def add_torques(
    loads: Loads, driven: np.ndarray, q: np.ndarray, v: np.ndarray, load: np.ndarray
) -> None:
    """Add torques to a load (nv,); ``driven`` (6 e + b,): of applied forces, then torques."""
    for k in range(len(load)):
        load[k] += loads.constant[k]
    for i in range(len(loads.joints)):
        row, numbers = loads.joints[i, 0], loads.in_joints[i]
        if numbers[ON] == ACTS:
            limit = numbers[5]
            torque = -numbers[0] * _strain(loads, i, q) - numbers[1] * v[row]
            load[row] += min(max(torque + numbers[4], -limit), limit)
    first = 6 * len(loads.applied)
    for i in range(len(loads.rows)):
        load[loads.rows[i]] += driven[first + i]


@borrowing
def _strain(loads: Loads, i: int, q: np.ndarray) -> float:
    """q − rest of a spring in a joint; continuous: within half a turn of the middle of its side."""
    entry, rest = loads.joints[i, 1], loads.in_joints[i, 2]
    if not loads.joints[i, 2]:
        return q[entry] - rest
    return turned_from(q[entry], q[entry + 1], rest, loads.in_joints[i, 3])


@borrowing
def turned_from(c: float, s: float, rest: float, side: float) -> float:
    """An angle − rest [rad] within half a turn of the middle of a side, 0 for both."""
    middle = 0.5 * math.pi * side
    angle = math.atan2(s, c) - rest - middle
    return (angle + math.pi) % (2.0 * math.pi) - math.pi + middle


@borrowing
def push_in_joint(
    strain: float, speed: float, side: float, stiffness: float, damping: float, continuous: bool
) -> tuple[float, float, float]:
    """Zone, its rate and force of a one-sided spring in a joint; see ``springs.Push``."""
    force = side * (stiffness * strain + damping * speed)
    if continuous:
        return side * math.sin(strain), math.cos(strain) * (side * speed), force
    return side * strain, side * speed, force


@borrowing
def push_between(
    length: float, speed: float, rest: float, way: float, stiffness: float, damping: float
) -> tuple[float, float, float]:
    """The same of one between two points, whose length grows at a speed."""
    force = way * (stiffness * (length - rest) + damping * speed)
    scale = way / (rest if rest > 0.0 else 1.0)
    return 0.5 * scale * (length - rest) * (length + rest), scale * length * speed, force


@borrowing
def write_pushes(
    loads: Loads, kinematics: Kinematics, q: np.ndarray, v: np.ndarray, pushes: np.ndarray
) -> None:
    """Write (d, 3) ``springs.Push`` of one-sided springs, signed: positive until one changes.

    Of a PD law with a limit the last is how far it is from changing.
    """
    for k in range(len(loads.kinks)):
        i = loads.kinks[k, 1]
        if loads.kinks[k, 0] == 2:
            numbers = loads.in_joints[i]
            torque = numbers[4] - numbers[0] * _strain(loads, i, q)
            torque -= numbers[1] * v[loads.joints[i, 0]]
            limit, side = numbers[5], numbers[SIDE]
            pushes[k, 0], pushes[k, 1] = 1.0, 0.0
            pushes[k, 2] = side * torque - limit if side != 0.0 else limit - abs(torque)
            pushes[k, 2] += BEYOND * limit
            continue
        if loads.kinks[k, 0] == 0:
            numbers = loads.in_joints[i]
            strain, speed = _strain(loads, i, q), v[loads.joints[i, 0]]
            continuous = loads.joints[i, 2] != 0
            zone, rate, force = push_in_joint(
                strain, speed, numbers[3], numbers[0], numbers[1], continuous
            )
        else:
            numbers = loads.between[i]
            length, _, speed = _stretch(loads, i, kinematics)
            zone, rate, force = push_between(
                length, speed, numbers[8], numbers[9], numbers[6], numbers[7]
            )
        sign = -1.0 if numbers[ON] == OUT else 1.0
        pushes[k, 0], pushes[k, 1] = sign * zone + BEYOND, sign * rate
        # Without a damper the zone alone decides.
        pushes[k, 2] = 1.0
        first = 6 if loads.kinks[k, 0] else 0
        if numbers[ON] != OUT and numbers[first + 1] > 0.0:
            beyond = BEYOND * (numbers[first] + numbers[first + 1])
            pushes[k, 2] = (force if numbers[ON] == ACTS else -force) + beyond


@borrowing
def push_bodies(loads: Loads, driven: np.ndarray, room: Room) -> None:
    """Let springs and applied forces act on the bodies; ``room`` with velocities."""
    places = room.kinematics.places
    for i in range(len(loads.springs)):
        _pull(loads, i, room)
    for i in range(len(loads.applied)):
        j = loads.applied[i, 0]
        linear, angular = three(driven, 6 * i), three(driven, 6 * i + 3)
        if loads.applied[i, 1]:
            linear, angular = back(places, j, linear), back(places, j, angular)
        else:
            linear, angular = turned(loads.at, i, linear), turned(loads.at, i, angular)
        push(room, j, three(loads.at[i], 9), linear)
        for k in range(3):
            room.force[j, 3 + k] -= angular[k]


@borrowing
def _pull(loads: Loads, i: int, room: Room) -> None:
    """A spring between two points."""
    numbers, places = loads.between[i], room.kinematics.places
    if numbers[ON] != ACTS:
        return
    one, two = loads.springs[i, 0], loads.springs[i, 1]
    here, there = three(numbers, 0), three(numbers, 3)
    length, n, rate = _stretch(loads, i, room.kinematics)
    if length < NO_LENGTH:
        return
    tension = numbers[6] * (length - numbers[8]) + numbers[7] * rate
    pull = (tension * n[0], tension * n[1], tension * n[2])
    if two > 0:
        push(room, two, there, back(places, two, pull))
    pull = (-pull[0], -pull[1], -pull[2])
    if one > 0:
        push(room, one, here, back(places, one, pull))


@borrowing
def _stretch(loads: Loads, i: int, kinematics: Kinematics) -> tuple[float, Vector, float]:
    """The length of a spring between points, its direction, and how fast it grows."""
    numbers, places = loads.between[i], kinematics.places
    one, two = loads.springs[i, 0], loads.springs[i, 1]
    here, there = three(numbers, 0), three(numbers, 3)
    between = along(
        along(origin(places, one), 1.0, turned(places, one, here)),
        -1.0,
        along(origin(places, two), 1.0, turned(places, two, there)),
    )
    length = math.sqrt(dot(between, between))
    if length < NO_LENGTH:
        return length, (0.0, 0.0, 0.0), 0.0
    n = (between[0] / length, between[1] / length, between[2] / length)
    apart = along(_speed(kinematics, one, here), -1.0, _speed(kinematics, two, there))
    return length, n, dot(n, apart)


@borrowing
def _speed(kinematics: Kinematics, j: int, point: Vector) -> Vector:
    """Of a joint's point, given in its axes, in the world."""
    speeds = kinematics.speeds
    return turned(
        kinematics.places, j, along(three(speeds[j], 0), 1.0, cross(three(speeds[j], 3), point))
    )
