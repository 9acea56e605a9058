"""One state alone, of a tree of any length: what Python calls for it."""

from __future__ import annotations

import numpy as np

from .articulated import press, respond, twists
from .bearing import bear
from .blows import strike
from .inertia import factor
from .jit import kernel
from .kinematics import place_bodies
from .layout import TWIST
from .rows import clear

__all__ = ["jump", "reactions", "speeds"]

SINGLE = 0.0


@kernel
def jump(ints, floats, dofs, armature, count, loaded, placed, blows, work, places):
    """Write Δv, and the jump of every body's twist.

    Args:
        ints, floats, dofs, armature: the tables of the tree.
        count: of its bodies.
        loaded: mask of the bodies that the blows load, and a list of them.
        placed: mask of all bodies.
        blows: ints, floats, kicks and numbers of the known impulses.
        work: zeros but for q and v.
        places: see ``layout.places``.
    """
    dof_at, q_at, dv_at, spare_at = places[0], places[1], places[3], places[5]
    mask, bodies = loaded
    place_bodies(ints, floats, count, placed, work, q_at, spare_at, SINGLE)
    factor(ints, floats, dofs, armature, count, work, dof_at, np.int64(0), SINGLE)
    blow_ints, blow_floats, kicks, given = blows
    zero = np.int64(0)
    clear(ints, bodies, zero, len(bodies), work, dof_at, SINGLE)
    strike(blow_ints, blow_floats, kicks, given, zero, zero, work, dof_at, SINGLE)
    press(ints, floats, dofs, count, mask, zero, work, dof_at, SINGLE)
    respond(ints, floats, dofs, count, mask, work, dof_at, dv_at, SINGLE)


@kernel
def speeds(ints, floats, dofs, wanted, work, places):
    """Write the twists of the bodies before the impact."""
    twists(ints, floats, dofs, wanted, work, places[2], np.int64(TWIST), SINGLE)


@kernel
def reactions(ints, floats, count, blows, work, places):
    """Write into FORCE of every body, 0 on entry, what its joint bears, in the body's axes."""
    blow_ints, blow_floats, kicks, given = blows
    zero = np.int64(0)
    strike(blow_ints, blow_floats, kicks, given, zero, zero, work, places[0], SINGLE)
    bear(ints, floats, count, work, zero, SINGLE)
