"""The accelerations of a tree of bodies as compiled code: places, velocities, M = Lᵀ D L, load.

Everything is in the axes of the bodies' own joints, spatial vectors linear before angular, as
Pinocchio has it: the arrays are those that ``Memory`` shows of Pinocchio's data, so that tables
of points and the law of resting points work on either. Velocities and accelerations go outwards,
forces inwards (Featherstone, Rigid Body Dynamics Algorithms, 5.3), M by composite bodies (6.2)
and its factor along the branches (8.5).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Kinematics, back, three, turned
from ...geometry.vectors import Vector, along, cross, dot
from ...laws.borrowed import borrowing
from ...laws.dense import put
from ...laws.half import Factor

__all__ = ["BALL", "CIRCLE", "FREE", "PLANAR", "SLIDE", "TRANSLATION", "TURN", "Room", "Tree"]

# Kinds of joints.
TURN, CIRCLE, SLIDE, BALL, FREE, PLANAR, TRANSLATION = 0, 1, 2, 3, 4, 5, 6


class Tree(NamedTuple):
    """Joints and bodies; row 0 is the world.

    Attributes:
        joints: (n, 5) parent, kind, first entries of q and v, how many of v.
        numbers: (n, 25) placement in the parent (R column by column, then the origin), axis (3),
            and of the body about its joint mass, first moment (3), xx, xy, xz, yy, yz, zz.
        columns: (nv, 6) the direction of each speed in the joint's axes.
        armature: (nv,) what each adds to its own entry of M.
        gravity: (3,) [m/s²].
    """

    joints: np.ndarray
    numbers: np.ndarray
    columns: np.ndarray
    armature: np.ndarray
    gravity: np.ndarray


class Room(NamedTuple):
    """What is known of one state.

    Attributes:
        kinematics: of all joints in the world, with accelerations at zero joint acceleration.
        factor: of M.
        local: (n, 12) placements in the parents.
        composite: (n, 10) mass, first moment and inertia of a body with all that hangs on it.
        force: (n, 6) what a joint bears of these.
    """

    kinematics: Kinematics
    factor: Factor
    local: np.ndarray
    composite: np.ndarray
    force: np.ndarray


@borrowing
def look_at(tree: Tree, room: Room, q: np.ndarray, v: np.ndarray) -> None:
    """Write placements, velocities and accelerations at zero joint acceleration."""
    places, speeds = room.kinematics.places, room.kinematics.speeds
    rates, local = room.kinematics.rates, room.local
    for j in range(1, len(tree.joints)):
        parent, kind, at, first = (
            tree.joints[j, 0],
            tree.joints[j, 1],
            tree.joints[j, 2],
            tree.joints[j, 3],
        )
        _place_in_parent(tree, local, j, kind, q, at)
        origin = three(local[j], 9)
        for column in range(3):
            x = turned(places, parent, three(local[j], 3 * column))
            places[j, 3 * column], places[j, 3 * column + 1], places[j, 3 * column + 2] = x
        x = along(three(places[parent], 9), 1.0, turned(places, parent, origin))
        places[j, 9], places[j, 10], places[j, 11] = x
        spin = three(speeds[parent], 3)
        move = back(local, j, along(three(speeds[parent], 0), 1.0, cross(spin, origin)))
        spin = back(local, j, spin)
        up = three(rates[parent], 3)
        rate = back(local, j, along(three(rates[parent], 0), 1.0, cross(up, origin)))
        up = back(local, j, up)
        own_move, own_spin = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for k in range(first, first + tree.joints[j, 4]):
            own_move = along(own_move, v[k], three(tree.columns[k], 0))
            own_spin = along(own_spin, v[k], three(tree.columns[k], 3))
        move, spin = along(move, 1.0, own_move), along(spin, 1.0, own_spin)
        rate = along(along(rate, 1.0, cross(spin, own_move)), 1.0, cross(move, own_spin))
        up = along(up, 1.0, cross(spin, own_spin))
        _put_two(speeds[j], move, spin)
        _put_two(rates[j], rate, up)


@borrowing
def _put_two(row: np.ndarray, a: Vector, b: Vector) -> None:
    row[0], row[1], row[2] = a
    row[3], row[4], row[5] = b


@borrowing
def _place_in_parent(
    tree: Tree, local: np.ndarray, j: int, kind: int, q: np.ndarray, at: int
) -> None:
    """Write the placement of a joint in its parent's axes."""
    numbers = tree.numbers
    axis = three(numbers[j], 12)
    shift = (0.0, 0.0, 0.0)
    one, two, last = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    if kind == SLIDE:
        shift = (q[at] * axis[0], q[at] * axis[1], q[at] * axis[2])
    elif kind in (TURN, CIRCLE):
        if kind == TURN:
            c, s = math.cos(q[at]), math.sin(q[at])
        else:
            c, s = q[at], q[at + 1]
        one, two, last = _about(axis, c, s)
    elif kind == PLANAR:
        shift = (q[at], q[at + 1], 0.0)
        one, two, last = _about(axis, q[at + 2], q[at + 3])
    else:
        if kind != BALL:
            shift = three(q, at)
        if kind != TRANSLATION:
            k = at + 3 if kind == FREE else at
            one, two, last = _of_quaternion(q[k], q[k + 1], q[k + 2], q[k + 3])
    row = local[j]
    row[0], row[1], row[2] = turned(numbers, j, one)
    row[3], row[4], row[5] = turned(numbers, j, two)
    row[6], row[7], row[8] = turned(numbers, j, last)
    row[9], row[10], row[11] = along(three(numbers[j], 9), 1.0, turned(numbers, j, shift))


@borrowing
def _about(axis: Vector, c: float, s: float) -> tuple[Vector, Vector, Vector]:
    """The columns of a turn about an axis (Rodrigues)."""
    x, y, z = axis
    u = 1.0 - c
    return (
        (c + u * x * x, u * x * y + s * z, u * x * z - s * y),
        (u * x * y - s * z, c + u * y * y, u * y * z + s * x),
        (u * x * z + s * y, u * y * z - s * x, c + u * z * z),
    )


@borrowing
def _of_quaternion(x: float, y: float, z: float, w: float) -> tuple[Vector, Vector, Vector]:
    """The columns of a unit quaternion's rotation."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        (2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@borrowing
def write_jacobian(tree: Tree, room: Room) -> None:
    """Write the Jacobian at the origin of the world; ``room`` with placements."""
    places, jacobian = room.kinematics.places, room.kinematics.jacobian
    for j in range(1, len(tree.joints)):
        origin = three(places[j], 9)
        for k in range(tree.joints[j, 3], tree.joints[j, 3] + tree.joints[j, 4]):
            spin = turned(places, j, three(tree.columns[k], 3))
            move = turned(places, j, three(tree.columns[k], 0))
            _put_two(jacobian[k], along(move, 1.0, cross(origin, spin)), spin)


@borrowing
def weighed(inertia: np.ndarray, move: Vector, spin: Vector) -> tuple[Vector, Vector]:
    """Momentum, linear and about the joint, of a body with this velocity."""
    m, h = inertia[0], three(inertia, 1)
    turning = (
        inertia[4] * spin[0] + inertia[5] * spin[1] + inertia[6] * spin[2],
        inertia[5] * spin[0] + inertia[7] * spin[1] + inertia[8] * spin[2],
        inertia[6] * spin[0] + inertia[8] * spin[1] + inertia[9] * spin[2],
    )
    linear = along((m * move[0], m * move[1], m * move[2]), 1.0, cross(spin, h))
    return linear, along(turning, 1.0, cross(h, move))


@borrowing
def begin_forces(tree: Tree, room: Room) -> None:
    """Write what each body needs to move so, weight taken off; ``room`` with velocities."""
    places, speeds = room.kinematics.places, room.kinematics.speeds
    rates, force = room.kinematics.rates, room.force
    gravity = three(tree.gravity, 0)
    _put_two(force[0], (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    for j in range(1, len(tree.joints)):
        inertia = tree.numbers[j, 15:]
        move, spin = three(speeds[j], 0), three(speeds[j], 3)
        momentum, about = weighed(inertia, move, spin)
        fall = along(three(rates[j], 0), -1.0, back(places, j, gravity))
        linear, angular = weighed(inertia, fall, three(rates[j], 3))
        linear = along(linear, 1.0, cross(spin, momentum))
        angular = along(angular, 1.0, along(cross(spin, about), 1.0, cross(move, momentum)))
        _put_two(force[j], linear, angular)


@borrowing
def push(forces: np.ndarray, j: int, point: Vector, force: Vector) -> None:
    """A force acts on a body at a point, both in the joint's axes: ``forces`` (n, 6) has less."""
    turning, row = cross(point, force), forces[j]
    for k in range(3):
        row[k] -= force[k]
        row[3 + k] -= turning[k]


@borrowing
def take_forces(tree: Tree, room: Room, load: np.ndarray) -> None:
    """Bring the forces of bodies inwards, and take them off the load (nv,)."""
    local, force = room.local, room.force
    for j in range(len(tree.joints) - 1, 0, -1):
        linear, angular = three(force[j], 0), three(force[j], 3)
        for k in range(tree.joints[j, 3], tree.joints[j, 3] + tree.joints[j, 4]):
            column = tree.columns[k]
            load[k] -= dot(three(column, 0), linear) + dot(three(column, 3), angular)
        parent = tree.joints[j, 0]
        if parent > 0:
            linear, angular = inwards(local, j, linear, angular)
            for k in range(3):
                force[parent, k] += linear[k]
                force[parent, 3 + k] += angular[k]


@borrowing
def inwards(local: np.ndarray, j: int, linear: Vector, angular: Vector) -> tuple[Vector, Vector]:
    """A force on a body, in the axes of its parent and about the parent's joint."""
    linear = turned(local, j, linear)
    moment = cross(three(local[j], 9), linear)
    return linear, along(turned(local, j, angular), 1.0, moment)


@borrowing
def write_factor(tree: Tree, room: Room) -> None:
    """Write M's diagonal and its factor; ``room`` with placements."""
    write_mass(tree, room)
    factorize_mass(room)


@borrowing
def factorize_mass(room: Room) -> None:
    """The factor of M in place of what ``write_mass`` wrote."""
    _factorize(room.factor, room.kinematics.before)


@borrowing
def write_mass(tree: Tree, room: Room) -> None:
    """Write M's lower half where its factor is to be; ``room`` with placements."""
    composite, count = room.composite, len(tree.joints)
    mass, factor = room.factor.mass, room.factor.factor
    before = room.kinematics.before
    for j in range(1, count):
        put(tree.numbers[j, 15:], composite[j])
    for j in range(count - 1, 0, -1):
        parent = tree.joints[j, 0]
        if parent > 0:
            _join(composite, parent, j, room.local)
    for j in range(1, count):
        first = tree.joints[j, 3]
        for k in range(first, first + tree.joints[j, 4]):
            column = tree.columns[k]
            linear, angular = weighed(composite[j], three(column, 0), three(column, 3))
            at, row = j, k
            while row >= 0:
                while row < tree.joints[at, 3]:
                    linear, angular = inwards(room.local, at, linear, angular)
                    at = tree.joints[at, 0]
                other = tree.columns[row]
                factor[k, row] = dot(three(other, 0), linear) + dot(three(other, 3), angular)
                row = before[row]
            factor[k, k] += tree.armature[k]
            mass[k, k] = factor[k, k]


@borrowing
def _factorize(found: Factor, before: np.ndarray) -> None:
    """M in place to L and D."""
    factor, pivots = found.factor, found.pivots
    for k in range(len(pivots) - 1, -1, -1):
        pivots[k] = factor[k, k]
        i = before[k]
        while i >= 0:
            part = factor[k, i] / pivots[k]
            j = i
            while j >= 0:
                factor[i, j] -= part * factor[k, j]
                j = before[j]
            factor[k, i] = part
            i = before[i]


@borrowing
def _join(composite: np.ndarray, parent: int, j: int, local: np.ndarray) -> None:
    """Add a body's inertia to its parent's, about the parent's joint."""
    own, sum_ = composite[j], composite[parent]
    m, p = own[0], three(local[j], 9)
    h = turned(local, j, three(own, 1))
    # R I Rᵀ, column by column.
    a = turned(local, j, (own[4], own[5], own[6]))
    b = turned(local, j, (own[5], own[7], own[8]))
    c = turned(local, j, (own[6], own[8], own[9]))
    x = turned(local, j, (a[0], b[0], c[0]))
    y = turned(local, j, (a[1], b[1], c[1]))
    z = turned(local, j, (a[2], b[2], c[2]))
    middle = 2.0 * dot(p, h) + m * dot(p, p)
    sum_[0] += m
    for k in range(3):
        sum_[1 + k] += h[k] + m * p[k]
    sum_[4] += x[0] + middle - 2.0 * p[0] * h[0] - m * p[0] * p[0]
    sum_[5] += x[1] - p[0] * h[1] - h[0] * p[1] - m * p[0] * p[1]
    sum_[6] += x[2] - p[0] * h[2] - h[0] * p[2] - m * p[0] * p[2]
    sum_[7] += y[1] + middle - 2.0 * p[1] * h[1] - m * p[1] * p[1]
    sum_[8] += y[2] - p[1] * h[2] - h[1] * p[2] - m * p[1] * p[2]
    sum_[9] += z[2] + middle - 2.0 * p[2] * h[2] - m * p[2] * p[2]
