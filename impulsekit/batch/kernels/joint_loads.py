"""What joints carry and how links move, row by row, once Δv and all impulses are known.

The momentum balance of each body and all below it: the wrench that the parent gives the child
at the joint's origin is the change of their momentum less the impulses from outside (Chang &
Huston 1995, on constraint impulses). Plain arrays, one state after the other.
"""

from __future__ import annotations

import numpy as np

from ...laws.compiled import OPTIONS as _OPTIONS
from ...laws.compiled import compiled, dispatcher, use_numba

__all__ = ["CIRCLE", "FREE", "HINGE", "PLANE", "SLIDER", "SPHERE", "joint_loads"]

use_numba()

# Kinds of joints, by what their coordinates are.
HINGE, CIRCLE, SLIDER, SPHERE, PLANE, FREE = 0, 1, 2, 3, 4, 5


@compiled
def turned(rotation, vector, out):
    """out = R x."""
    for i in range(3):
        out[i] = (
            rotation[i, 0] * vector[0] + rotation[i, 1] * vector[1] + rotation[i, 2] * vector[2]
        )


@compiled
def crossed(a, b, out):
    """out += a × b."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@compiled
def multiplied(a, b, out):
    """out = A B."""
    for i in range(3):
        for k in range(3):
            out[i, k] = a[i, 0] * b[0, k] + a[i, 1] * b[1, k] + a[i, 2] * b[2, k]


@compiled
def about(axis, c, s, out):
    """The rotation about a unit axis whose cosine and sine are given (Rodrigues)."""
    x, y, z = axis[0], axis[1], axis[2]
    d = 1.0 - c
    out[0, 0], out[0, 1], out[0, 2] = c + d * x * x, d * x * y - s * z, d * x * z + s * y
    out[1, 0], out[1, 1], out[1, 2] = d * x * y + s * z, c + d * y * y, d * y * z - s * x
    out[2, 0], out[2, 1], out[2, 2] = d * x * z - s * y, d * y * z + s * x, c + d * z * z


@compiled
def of_quaternion(q, out):
    """The rotation of a unit quaternion x, y, z, w."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    out[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[0, 1] = 2.0 * (x * y - w * z)
    out[0, 2] = 2.0 * (x * z + w * y)
    out[1, 0] = 2.0 * (x * y + w * z)
    out[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[1, 2] = 2.0 * (y * z - w * x)
    out[2, 0] = 2.0 * (x * z - w * y)
    out[2, 1] = 2.0 * (y * z + w * x)
    out[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@compiled
def moved(kind, axis, q, rotation, shift):
    """Rotation and shift of a joint's child in the joint's own frame at its coordinates."""
    for i in range(3):
        shift[i] = 0.0
        for k in range(3):
            rotation[i, k] = 1.0 if i == k else 0.0
    if kind == HINGE:
        about(axis, np.cos(q[0]), np.sin(q[0]), rotation)
    elif kind == CIRCLE:
        about(axis, q[0], q[1], rotation)
    elif kind == SLIDER:
        for i in range(3):
            shift[i] = axis[i] * q[0]
    elif kind == SPHERE:
        of_quaternion(q, rotation)
    elif kind == PLANE:
        shift[0], shift[1] = q[0], q[1]
        about(axis, q[2], q[3], rotation)
    else:
        for i in range(3):
            shift[i] = q[i]
        of_quaternion(q[3:], rotation)


@compiled
def jump_along(kind, axis, dv, rotation, linear, angular, spare):
    """Add what a joint's own Δv gives its child, in world axes."""
    if kind in (HINGE, CIRCLE):
        turned(rotation, axis, spare)
        for i in range(3):
            angular[i] += spare[i] * dv[0]
    elif kind == SLIDER:
        turned(rotation, axis, spare)
        for i in range(3):
            linear[i] += spare[i] * dv[0]
    elif kind == SPHERE:
        turned(rotation, dv, spare)
        for i in range(3):
            angular[i] += spare[i]
    elif kind == PLANE:
        for i in range(3):
            linear[i] += rotation[i, 0] * dv[0] + rotation[i, 1] * dv[1]
            angular[i] += rotation[i, 2] * dv[2]
    else:
        for i in range(3):
            linear[i] += rotation[i, 0] * dv[0] + rotation[i, 1] * dv[1] + rotation[i, 2] * dv[2]
            angular[i] += rotation[i, 0] * dv[3] + rotation[i, 1] * dv[4] + rotation[i, 2] * dv[5]


@compiled
def place(tree, q, dv, rotations, origins, linears, angulars, work):
    """Rotation and origin of each joint in the world, and the jump of its body's twist there."""
    turn, to_world, shift, spare = work[0:3], work[3:6], work[6], work[7]
    for joint in range(1, len(tree.parent)):
        above = tree.parent[joint]
        kind, axis = tree.kind[joint], tree.axis[joint]
        moved(kind, axis, q[tree.first_q[joint] :], turn, shift)
        multiplied(rotations[above], tree.rotation[joint], to_world)
        turned(to_world, shift, spare)
        turned(rotations[above], tree.shift[joint], shift)
        for i in range(3):
            shift[i] += spare[i]
            origins[joint, i] = origins[above, i] + shift[i]
            linears[joint, i] = linears[above, i]
            angulars[joint, i] = angulars[above, i]
        multiplied(to_world, turn, rotations[joint])
        crossed(angulars[above], shift, linears[joint])
        jump_along(
            kind, axis, dv[tree.first_v[joint] :], rotations[joint], linears[joint],
            angulars[joint], spare,
        )  # fmt: skip


@compiled
def change_of_momentum(tree, joint, rotation, linear, angular, force, moment, work):
    """Add the change of a body's momentum, linear and about its joint's origin."""
    arm, spin, spare = work[0], work[1], work[2]
    mass = tree.mass[joint]
    turned(rotation, tree.lever[joint], arm)
    for i in range(3):
        spare[i] = linear[i]
    crossed(angular, arm, spare)
    for i in range(3):
        spare[i] *= mass
        force[i] += spare[i]
    crossed(arm, spare, moment)
    for i in range(3):
        spin[i] = (
            rotation[0, i] * angular[0] + rotation[1, i] * angular[1] + rotation[2, i] * angular[2]
        )
    inertia = tree.inertia[joint]
    for i in range(3):
        spare[i] = inertia[i, 0] * spin[0] + inertia[i, 1] * spin[1] + inertia[i, 2] * spin[2]
    turned(rotation, spare, spin)
    for i in range(3):
        moment[i] += spin[i]


@compiled
def less_outside(loads, numbers, rotations, origins, forces, moments, work):
    """Take away the impulses from outside: each a number along a direction at a point."""
    along, point, spare = work[0], work[1], work[2]
    for k in range(len(loads.joint)):
        size = loads.sign[k] * numbers[loads.column[k]]
        joint = loads.joint[k]
        turned(rotations[loads.axes_of[k]], loads.direction[k], along)
        if loads.is_moment[k]:
            for i in range(3):
                moments[joint, i] -= size * along[i]
            continue
        turned(rotations[loads.point_on[k]], loads.point[k], point)
        for i in range(3):
            point[i] += origins[loads.point_on[k], i] - origins[joint, i]
            spare[i] = 0.0
        crossed(point, along, spare)
        for i in range(3):
            forces[joint, i] -= size * along[i]
            moments[joint, i] -= size * spare[i]


def _joint_loads(tree, loads, links, q, dv, numbers, reactions, bodies):
    """Reactions of all joints and jumps of all links for each row.

    Args:
        tree, loads, links: tables (``joint_loads`` of the room above).
        q: (B, nq). dv: (B, nv). numbers: (B, columns) all impulses from outside.
        reactions: (B, joints, 6) written: force and moment, world axes, at the joints; or (0,
            joints, 6).
        bodies: (B, links, 6) written: Δ of the mass centre's velocity and of the angular one.
    """
    joints = len(tree.parent)
    rotations, origins = np.zeros((joints, 3, 3)), np.zeros((joints, 3))
    linears, angulars = np.zeros((joints, 3)), np.zeros((joints, 3))
    forces, moments, work = np.zeros((joints, 3)), np.zeros((joints, 3)), np.zeros((8, 3))
    for i in range(3):
        rotations[0, i, i] = 1.0
    for row in range(len(q)):
        place(tree, q[row], dv[row], rotations, origins, linears, angulars, work)
        for k in range(bodies.shape[1]):
            joint = links.joint[k]
            turned(rotations[joint], links.com[k], work[0])
            for i in range(3):
                bodies[row, k, i] = linears[joint, i]
                bodies[row, k, 3 + i] = angulars[joint, i]
            crossed(angulars[joint], work[0], bodies[row, k, :3])
        if len(reactions) == 0:
            continue
        forces[:] = 0.0
        moments[:] = 0.0
        less_outside(loads, numbers[row], rotations, origins, forces, moments, work)
        for joint in range(joints - 1, 0, -1):
            change_of_momentum(
                tree, joint, rotations[joint], linears[joint], angulars[joint], forces[joint],
                moments[joint], work,
            )  # fmt: skip
            above = tree.parent[joint]
            for i in range(3):
                work[0, i] = origins[joint, i] - origins[above, i]
                forces[above, i] += forces[joint, i]
                moments[above, i] += moments[joint, i]
                reactions[row, joint - 1, i] = forces[joint, i]
                reactions[row, joint - 1, 3 + i] = moments[joint, i]
            crossed(work[0], forces[joint], moments[above])


joint_loads = dispatcher(_joint_loads, _OPTIONS)
