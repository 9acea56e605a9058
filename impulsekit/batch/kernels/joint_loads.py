"""What joints carry and how links move, row by row, once Δv and all impulses are known.

The momentum balance of each body and all below it: the wrench that the parent gives the child
at the joint's origin is the change of their momentum less the impulses from outside (Chang &
Huston 1995, on constraint impulses), on the tree that motions go by.
"""

from __future__ import annotations

from ...geometry.point_table import back, origin, three, turned
from ...geometry.vectors import along, cross, row_of
from ...laws.borrowed import borrowing
from ...laws.compiled import OPTIONS as _OPTIONS
from ...laws.compiled import dispatcher, use_numba
from ...motion.tree.bodies import inwards, look_at, weighed
from ...rows.frame_pair import velocity_at

__all__ = ["joint_loads"]

use_numba()


@borrowing
def put_two(a, b, row):
    """Write two vectors."""
    row[0], row[1], row[2] = a
    row[3], row[4], row[5] = b


@borrowing
def write_links(links, places, speeds, bodies):
    """The jumps of links: of the mass centre's velocity and of the angular one, world axes."""
    for k in range(len(bodies)):
        j = links.joint[k]
        spin = three(speeds[j], 3)
        move = velocity_at(three(speeds[j], 0), spin, row_of(links.com, k))
        put_two(turned(places, j, move), turned(places, j, spin), bodies[k])


@borrowing
def less_outside(loads, numbers, places, force):
    """Take away the impulses from outside: each a number along a direction at a point."""
    for k in range(len(loads.joint)):
        size = loads.sign[k] * numbers[loads.column[k]]
        j, on = loads.joint[k], loads.point_on[k]
        push = back(places, j, turned(places, loads.axes_of[k], row_of(loads.direction, k)))
        moment = push
        if not loads.is_moment[k]:
            point = along(origin(places, on), 1.0, turned(places, on, row_of(loads.point, k)))
            moment = cross(back(places, j, along(point, -1.0, origin(places, j))), push)
        for i in range(3):
            force[j, i] -= 0.0 if loads.is_moment[k] else size * push[i]
            force[j, 3 + i] -= size * moment[i]


@borrowing
def write_reactions(tree, room, reactions):
    """Bring what bodies need inwards, and write what each joint bears, world axes."""
    force, places = room.force, room.kinematics.places
    for j in range(len(tree.joints) - 1, 0, -1):
        linear, angular = three(force[j], 0), three(force[j], 3)
        put_two(turned(places, j, linear), turned(places, j, angular), reactions[j - 1])
        parent = tree.joints[j, 0]
        if parent > 0:
            linear, angular = inwards(room.local, j, linear, angular)
            for i in range(3):
                force[parent, i] += linear[i]
                force[parent, 3 + i] += angular[i]


def _joint_loads(tree, room, loads, links, q, dv, numbers, reactions, bodies):
    """Reactions of all joints and jumps of all links for each row.

    Args:
        tree, room: of the model (``motion.tree``).
        loads, links: tables (``joint_loads`` of the room above).
        q: (B, nq). dv: (B, nv). numbers: (B, columns) all impulses from outside.
        reactions: (B, joints, 6) written: force and moment, world axes, at the joints; or (0,
            joints, 6).
        bodies: (B, links, 6) written: Δ of the mass centre's velocity and of the angular one.
    """
    places, speeds, force = room.kinematics.places, room.kinematics.speeds, room.force
    for row in range(len(q)):
        look_at(tree, room, q[row], dv[row])
        write_links(links, places, speeds, bodies[row])
        if len(reactions) == 0:
            continue
        for j in range(1, len(tree.joints)):
            needs = weighed(tree.numbers[j, 15:], three(speeds[j], 0), three(speeds[j], 3))
            put_two(needs[0], needs[1], force[j])
        less_outside(loads, numbers[row], places, force)
        write_reactions(tree, room, reactions[row])


joint_loads = dispatcher(_joint_loads, _OPTIONS)
