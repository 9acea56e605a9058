"""``ForceField`` as compiled code: torques in joints and wrenches on bodies from tables.

What is a function of time alone is evaluated beforehand, at the times of a step's stages.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..laws.compiled import compiled
from .points import Kinematics, Vector, along, back, cross, dot, origin, three, turned
from .tree import Room, push

__all__ = ["NO_LENGTH", "Loads", "add_torques", "push_bodies"]

# Ends of a spring nearer than this [m] have no direction between them.
NO_LENGTH = 1e-12


class Loads(NamedTuple):
    """The forces of a scene.

    Attributes:
        constant: (nv,) torques that stay.
        joints: (a, 3) row in v and entry in q of a spring in a joint, and whether it is one of
            a joint that turns without end.
        in_joints: (a, 6) stiffness, damping, rest, side (0: both), what is added, limit.
        rows: (b,) of driven torques, in v.
        springs: (c, 2) joints of both ends. between: (c, 10) both points in these joints' axes,
            stiffness, damping, rest length, way (1: pulls only, −1: pushes only, 0: both).
        applied: (d, 2) joint, and whether axes are the world's. at: (d, 12) the frame in the
            joint: R column by column and origin.
    """

    constant: np.ndarray
    joints: np.ndarray
    in_joints: np.ndarray
    rows: np.ndarray
    springs: np.ndarray
    between: np.ndarray
    applied: np.ndarray
    at: np.ndarray


@compiled
def add_torques(
    loads: Loads, driven: np.ndarray, q: np.ndarray, v: np.ndarray, load: np.ndarray
) -> None:
    """Add torques to a load (nv,); ``driven`` (6 d + b,): of applied forces, then torques."""
    for k in range(len(load)):
        load[k] += loads.constant[k]
    for i in range(len(loads.joints)):
        row, entry, endless = loads.joints[i, 0], loads.joints[i, 1], loads.joints[i, 2]
        numbers = loads.in_joints[i]
        rest, side, limit = numbers[2], numbers[3], numbers[5]
        strain = q[entry] - rest
        if endless:
            strain = (math.atan2(q[entry + 1], q[entry]) - rest + math.pi) % (2.0 * math.pi)
            strain -= math.pi
        torque = -numbers[0] * strain - numbers[1] * v[row]
        if side != 0.0 and not (side * strain > 0.0 and side * torque < 0.0):
            torque = 0.0
        load[row] += min(max(torque + numbers[4], -limit), limit)
    first = 6 * len(loads.applied)
    for i in range(len(loads.rows)):
        load[loads.rows[i]] += driven[first + i]


@compiled
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


@compiled
def _pull(loads: Loads, i: int, room: Room) -> None:
    """A spring between two points."""
    kinematics, numbers = room.kinematics, loads.between[i]
    places = kinematics.places
    one, two = loads.springs[i, 0], loads.springs[i, 1]
    here, there = three(numbers, 0), three(numbers, 3)
    stiffness, damping, rest, way = numbers[6], numbers[7], numbers[8], numbers[9]
    between = along(
        along(origin(places, one), 1.0, turned(places, one, here)),
        -1.0,
        along(origin(places, two), 1.0, turned(places, two, there)),
    )
    length = math.sqrt(dot(between, between))
    if length < NO_LENGTH or way * (length - rest) < 0.0:
        return
    n = (between[0] / length, between[1] / length, between[2] / length)
    apart = along(_speed(kinematics, one, here), -1.0, _speed(kinematics, two, there))
    tension = stiffness * (length - rest) + damping * dot(n, apart)
    if way * tension < 0.0:
        return
    pull = (tension * n[0], tension * n[1], tension * n[2])
    if two > 0:
        push(room, two, there, back(places, two, pull))
    pull = (-pull[0], -pull[1], -pull[2])
    if one > 0:
        push(room, one, here, back(places, one, pull))


@compiled
def _speed(kinematics: Kinematics, j: int, point: Vector) -> Vector:
    """Of a joint's point, given in its axes, in the world."""
    speeds = kinematics.speeds
    return turned(
        kinematics.places, j, along(three(speeds[j], 0), 1.0, cross(three(speeds[j], 3), point))
    )
