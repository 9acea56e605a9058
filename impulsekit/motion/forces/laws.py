"""Springs, PD laws and applied forces, from tables: torques in joints and wrenches on bodies.

``ForceField`` runs these functions as Python, steps that are compiled have them within. What is a
function of time alone is evaluated beforehand, at the times of a step's stages.

A one-sided spring has kinks: where its strain is zero, and where its damper would pull what the
spring pushes. Steps of a motion end there (``events.kinks``), and its state is set from one to the
next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Kinematics, back, origin, three, turned
from ...geometry.vectors import Vector, along, dot
from ...laws.borrowed import borrowing
from ...rows.frame_pair import velocity_at
from ..tree.bodies import push

__all__ = [
    "ACTS",
    "BETWEEN",
    "BEYOND",
    "BY_STATE",
    "LIMITED",
    "ON",
    "OUT",
    "SIDE",
    "SLACK",
    "STORES",
    "Loads",
    "add_torques",
    "left_of_limit",
    "potential_of",
    "push_bodies",
    "push_of",
    "torque_in_joint",
    "torque_of",
    "write_pushes",
]

# Ends of a spring nearer than this [m] have no direction between them.
NO_LENGTH = 1e-12
# Column of the state in tables of springs: out of its zone, without force; acts; without force,
# since the damper would pull what the spring pushes; or as each state says by itself, outside of
# a motion.
ON = 10
OUT, ACTS, SLACK, BY_STATE = 0, 1, 2, 3
# Column of the side of a PD law: 0 below its limit, 1 at the upper one, −1 at the lower one; and
# of whether energy is stored in it, as in a spring and not in a law.
SIDE, STORES = 6, 7
# What has a kink: a spring in a joint, one between points, a PD law with a limit.
_IN_JOINT, BETWEEN, LIMITED = 0, 1, 2
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
            limit, the side of a PD law (SIDE), whether energy is stored (STORES), two unused,
            and the state (ON).
        rows: (b,) of driven torques, in v.
        springs: (c, 2) joints of both ends. between: (c, 11) both points in these joints' axes,
            stiffness, damping, rest length, way (1: pulls only, −1: pushes only, 0: both), and
            the state (ON).
        kinks: (d, 2) springs that act on one side only and PD laws with a limit: which of these
            it is, and its row.
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
    """Add torques that do not stay to a load (nv,).

    ``driven`` (6 e + b,): of applied forces, then torques.
    """
    for i in range(len(loads.joints)):
        joint, numbers = loads.joints[i], loads.in_joints[i]
        load[joint[0]] += torque_in_joint(joint, numbers, q, v)
    first = 6 * len(loads.applied)
    for i in range(len(loads.rows)):
        load[loads.rows[i]] += driven[first + i]


@borrowing
def torque_in_joint(joint: np.ndarray, numbers: np.ndarray, q: np.ndarray, v: np.ndarray) -> float:
    """What a spring in a joint or a PD law does [N m, N]; ``joint`` and ``numbers``: its rows."""
    state = numbers[ON]
    if state != ACTS:
        if state != BY_STATE:
            return 0.0
        zone, _, force = _push_in_joint(joint, numbers, q, v)
        if not (zone > 0.0 and force > 0.0):
            return 0.0
    torque, limit = torque_of(joint, numbers, q, v), numbers[5]
    return min(max(torque, -limit), limit)


@borrowing
def torque_of(joint: np.ndarray, numbers: np.ndarray, q: np.ndarray, v: np.ndarray) -> float:
    """τ₀ − k (q − rest) − c v of a spring in a joint or a PD law, without its limit [N m, N]."""
    return numbers[4] - numbers[0] * _strain(joint, numbers, q) - numbers[1] * v[joint[0]]


@borrowing
def left_of_limit(joint: np.ndarray, numbers: np.ndarray, q: np.ndarray, v: np.ndarray) -> float:
    """Positive until a PD law comes to its limit, or back [N m, N]."""
    torque, limit, side = torque_of(joint, numbers, q, v), numbers[5], numbers[SIDE]
    return side * torque - limit if side != 0.0 else limit - abs(torque)


@borrowing
def _strain(joint: np.ndarray, numbers: np.ndarray, q: np.ndarray) -> float:
    """q − rest of a spring in a joint; continuous: within half a turn of the middle of its side."""
    entry, rest = joint[1], numbers[2]
    if not joint[2]:
        return q[entry] - rest
    middle = 0.5 * math.pi * numbers[3]
    angle = math.atan2(q[entry + 1], q[entry]) - rest - middle
    return (angle + math.pi) % (2.0 * math.pi) - math.pi + middle


@borrowing
def _zone_in_joint(joint: np.ndarray, numbers: np.ndarray, strain: float) -> float:
    """How far a one-sided spring in a joint is strained; of a continuous one the sine of that."""
    return numbers[3] * (math.sin(strain) if joint[2] else strain)


@borrowing
def _push_in_joint(
    joint: np.ndarray, numbers: np.ndarray, q: np.ndarray, v: np.ndarray
) -> tuple[float, float, float]:
    """``push_of`` a one-sided spring in a joint."""
    side, strain = numbers[3], _strain(joint, numbers, q)
    rate = side * v[joint[0]]
    if joint[2]:
        rate *= math.cos(strain)
    return _zone_in_joint(joint, numbers, strain), rate, -side * torque_of(joint, numbers, q, v)


@borrowing
def _push_between(
    loads: Loads, i: int, places: np.ndarray, speeds: np.ndarray
) -> tuple[float, float, float]:
    """``push_of`` a one-sided spring between two points."""
    rest, way = loads.between[i, 8], loads.between[i, 9]
    length, _, speed = _stretch(loads, i, places, speeds)
    scale = way / (rest if rest > 0.0 else 1.0)
    zone = 0.5 * scale * (length - rest) * (length + rest)
    return zone, scale * length * speed, way * _tension(loads, i, length, speed)


@borrowing
def push_of(
    loads: Loads, k: int, places: np.ndarray, speeds: np.ndarray, q: np.ndarray, v: np.ndarray
) -> tuple[float, float, float]:
    """Of a spring with kinks its zone, the rate of that, and its force towards its side.

    It acts while zone and force are positive. The zone is the strain towards its side [m, rad]; of
    a continuous joint the sine of it, and of a spring between points (l² − l₀²) / 2 l₀, which is
    smooth where they meet. Places and velocities are those of all joints.
    """
    i = loads.kinks[k, 1]
    if loads.kinks[k, 0] == BETWEEN:
        return _push_between(loads, i, places, speeds)
    return _push_in_joint(loads.joints[i], loads.in_joints[i], q, v)


@borrowing
def write_pushes(
    loads: Loads, kinematics: Kinematics, q: np.ndarray, v: np.ndarray, pushes: np.ndarray
) -> None:
    """Write (d, 3) ``push_of`` one-sided springs, signed: positive until one changes.

    Of a PD law with a limit the last is how far it is from changing.
    """
    for k in range(len(loads.kinks)):
        i = loads.kinks[k, 1]
        if loads.kinks[k, 0] == LIMITED:
            pushes[k, 0], pushes[k, 1] = 1.0, 0.0
            numbers = loads.in_joints[i]
            pushes[k, 2] = left_of_limit(loads.joints[i], numbers, q, v) + BEYOND * numbers[5]
            continue
        zone, rate, force = push_of(loads, k, kinematics.places, kinematics.speeds, q, v)
        between = loads.kinks[k, 0] == BETWEEN
        numbers = loads.between[i] if between else loads.in_joints[i]
        sign = -1.0 if numbers[ON] == OUT else 1.0
        pushes[k, 0], pushes[k, 1] = sign * zone + BEYOND, sign * rate
        # Without a damper the zone alone decides.
        pushes[k, 2] = 1.0
        first = 6 if between else 0
        if numbers[ON] != OUT and numbers[first + 1] > 0.0:
            beyond = BEYOND * (numbers[first] + numbers[first + 1])
            pushes[k, 2] = (force if numbers[ON] == ACTS else -force) + beyond


@borrowing
def push_bodies(
    loads: Loads, driven: np.ndarray, places: np.ndarray, speeds: np.ndarray, force: np.ndarray
) -> None:
    """Take what springs and applied forces do off what the bodies need (n, 6), as ``bodies.push``.

    ``places`` and ``speeds`` of all joints; joint 0 carries what acts on the world.
    """
    for i in range(len(loads.springs)):
        _pull(loads, i, places, speeds, force)
    for i in range(len(loads.applied)):
        j = loads.applied[i, 0]
        linear, angular = three(driven, 6 * i), three(driven, 6 * i + 3)
        if loads.applied[i, 1]:
            linear, angular = back(places, j, linear), back(places, j, angular)
        else:
            linear, angular = turned(loads.at, i, linear), turned(loads.at, i, angular)
        push(force, j, three(loads.at[i], 9), linear)
        for k in range(3):
            force[j, 3 + k] -= angular[k]


@borrowing
def _pull(loads: Loads, i: int, places: np.ndarray, speeds: np.ndarray, force: np.ndarray) -> None:
    """A spring between two points."""
    numbers = loads.between[i]
    acts = numbers[ON] == ACTS
    if numbers[ON] == BY_STATE:
        zone, _, own = _push_between(loads, i, places, speeds)
        acts = zone > 0.0 and own > 0.0
    length, n, rate = _stretch(loads, i, places, speeds)
    if not acts or length < NO_LENGTH:
        return
    one, two = loads.springs[i, 0], loads.springs[i, 1]
    tension = _tension(loads, i, length, rate)
    pull = (tension * n[0], tension * n[1], tension * n[2])
    push(force, two, three(numbers, 3), back(places, two, pull))
    pull = (-pull[0], -pull[1], -pull[2])
    push(force, one, three(numbers, 0), back(places, one, pull))


@borrowing
def _tension(loads: Loads, i: int, length: float, rate: float) -> float:
    """k (l − l₀) + c dl/dt of a spring between points [N]."""
    numbers = loads.between[i]
    return numbers[6] * (length - numbers[8]) + numbers[7] * rate


@borrowing
def _stretch(
    loads: Loads, i: int, places: np.ndarray, speeds: np.ndarray
) -> tuple[float, Vector, float]:
    """The length of a spring between points, its direction, and how fast it grows."""
    numbers = loads.between[i]
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
    apart = along(_speed(places, speeds, one, here), -1.0, _speed(places, speeds, two, there))
    return length, n, dot(n, apart)


@borrowing
def _speed(places: np.ndarray, speeds: np.ndarray, j: int, point: Vector) -> Vector:
    """Of a joint's point, given in its axes, in the world."""
    return turned(places, j, velocity_at(three(speeds[j], 0), three(speeds[j], 3), point))


@borrowing
def potential_of(loads: Loads, places: np.ndarray, speeds: np.ndarray, q: np.ndarray) -> float:
    """The energy in the springs [J]."""
    total = 0.0
    for i in range(len(loads.joints)):
        joint, numbers = loads.joints[i], loads.in_joints[i]
        strain = _strain(joint, numbers, q)
        if numbers[STORES] != 0.0 and _zone_in_joint(joint, numbers, strain) >= 0.0:
            total += 0.5 * numbers[0] * strain * strain
    for i in range(len(loads.springs)):
        numbers = loads.between[i]
        strain = _stretch(loads, i, places, speeds)[0] - numbers[8]
        if numbers[9] * strain >= 0.0:
            total += 0.5 * numbers[6] * strain * strain
    return total
