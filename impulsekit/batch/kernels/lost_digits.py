"""What a lone contact lacks where a blow alone would throw its point.

The law is told the velocity that the blow leaves, and takes it away again by W P: where it is
many times what the point has in the end, as many digits are lost. What the twists of the
bodies leave of the law, taken as small, has all digits, and so has the ΔP that mends it.
"""

from __future__ import annotations

import math

from ...laws.coulomb import stopping
from ...tolerances import EPS
from ..codes import AGAIN
from .articulated import respond
from .doubt import jump_of_row, size_of_terms
from .given import Contact
from .jit import built_in, inlined
from .lanes import absolute, any_less, where_less, width
from .layout import BODY, BODY_INTS, DOF, FAINTEST, FORCE, JUMP, TARGET
from .memory import load, same, store

__all__ = ["MORE", "contact_of", "lacking", "press_more"]

# Where ΔP of a lone contact goes: FORCE of the first body, which is done with.
MORE = BODY + FORCE
# Among the floats of a contact: the speed below which restitution is 0, and e_t.
_CAPTURE, _OWN_E_T = 12, 11

# How many times as fast as all that makes up the point's motion the blow alone would throw it.
THROWN = 3.0
# As much is lost where W is so near singular that impulses cancel: their terms, by this share.
BALANCED = 2.0**-8
# From which share of the bounds of friction on, and of the free speed, a contact slides.
ON_CONE, SLIPS = 1e-12, 1e-13
# What a step may leave of the contact's velocities, with the rounding of W itself, relative to
# the speeds of the point: a tenth of what a batch may be off by.
LEFT = 1e-13


@inlined
def lacking(touch, inputs, base, places, work, code, witness):
    """Whether digits are lost in any lane; then ΔP is written, 0 where nothing is lacking.

    It goes to FORCE of the first body, with room behind it for as much again.

    Args:
        touch: of which one contact is all there is; three rows, or one without friction.
        inputs: of which the states from ``base`` on are those of the lanes.
    """
    rows = touch.rows
    w, count = width(witness), len(rows.first) - 1
    before_at, free_at, p_at, spare_at = places.before, places.free, places.p, places.spare
    zero = same(0.0, witness)
    free, slow = zero, zero
    for r in range(count):
        speed = absolute(load(work, (free_at + r) * w, witness))
        free = where_less(free, speed, speed, free)
        speed = absolute(load(work, (before_at + r) * w, witness))
        slow = where_less(slow, speed, speed, slow)
    trace, impulses = zero, zero
    for r in range(count):
        trace = trace + load(work, (places.delassus + r * (count + 1)) * w, witness)
        impulses = impulses + absolute(load(work, (p_at + r) * w, witness))
    terms = BALANCED * trace * impulses
    free = where_less(free, terms, terms, free)
    if not any_less(THROWN * slow, free):
        return False
    for r in range(count):
        size = size_of_terms(rows, r, places, work, witness)
        slow = where_less(slow, size, size, slow)
    slow = THROWN * slow
    if not any_less(slow, free):
        return False
    store(work, spare_at * w, slow)
    store(work, (spare_at + 1) * w, free)
    for r in range(count):
        speed = jump_of_row(rows, r, places, work, witness)
        speed = speed + load(work, (before_at + r) * w, witness)
        store(work, (MORE + count + r) * w, speed)
        store(work, (MORE + r) * w, zero)
    some = False
    for lane in range(w):
        thrown = float(work[(spare_at + 1) * w + lane])
        pn = float(work[(p_at + count - 1) * w + lane])
        if thrown > float(work[spare_at * w + lane]) and pn > 0.0 and code[lane] != AGAIN:
            contact = contact_of(touch, inputs, base + lane)
            slowest = float(work[spare_at * w + lane]) / THROWN
            mended = _lack(count, contact, thrown, slowest, places, work, w, lane)
            if not mended:
                code[lane] = AGAIN
            some = True
    return some


@inlined
def contact_of(touch, inputs, state):
    """The numbers of the one contact there is."""
    return Contact(
        touch.floats[_CAPTURE],
        touch.floats[_OWN_E_T],
        inputs.e[state * inputs.e_step],
        inputs.mu[state * inputs.mu_step],
        touch.floats[FAINTEST],
    )


@inlined
def press_more(tree, rows, sets, places, more_at, work, witness):
    """Add ΔP to P, and what it makes to Δv and to the jumps of all bodies.

    Where the generalized impulse stands there is room for another Δv.

    Args:
        more_at: where ΔP stands, which may be in FORCE of a body.
    """
    ints, floats, dofs = tree.ints, tree.floats, tree.dofs
    last, nv = len(ints) // BODY_INTS - 1, len(tree.armature)
    count = len(rows.first) - 1
    dof_at, p_at, dv_at, spare_at = places.dof, places.p, places.dv, places.sum
    w = width(witness)
    zero = same(0.0, witness)
    for dof in range(nv):
        store(work, (dof_at + dof * DOF + TARGET) * w, zero)
        store(work, (spare_at + dof) * w, load(work, (dv_at + dof) * w, witness))
    for r in range(count):
        more = load(work, (more_at + r) * w, witness)
        store(work, (p_at + r) * w, load(work, (p_at + r) * w, witness) + more)
        for k in range(rows.dof_first[r], rows.dof_first[r + 1]):
            at = (dof_at + rows.dof_list[k] * DOF + TARGET) * w
            u = load(work, (places.reduced + r * nv + rows.dof_list[k]) * w, witness)
            store(work, at, load(work, at, witness) + more * u)
    for body in range(1, last + 1):
        for k in range(6):
            jump = load(work, (body * BODY + JUMP + k) * w, witness)
            store(work, (body * BODY + FORCE + k) * w, jump)
    respond(ints, floats, dofs, last, sets.loaded, work, dof_at, dv_at, witness)
    for body in range(1, last + 1):
        for k in range(6):
            at = (body * BODY + JUMP + k) * w
            jump = load(work, (body * BODY + FORCE + k) * w, witness)
            store(work, at, jump + load(work, at, witness))
    for dof in range(nv):
        change = load(work, (spare_at + dof) * w, witness)
        store(work, (dv_at + dof) * w, change + load(work, (dv_at + dof) * w, witness))


@built_in
def _lack(rows, contact, thrown, slow, places, work, w, lane):
    """Write ΔP of one lane by one Newton step in the mode that P tells; whether that is enough.

    Sticking: ξ = 0. Sliding against s: ξ_n = 0 and ξ_t along s, with P_t = −μ P_n s.
    """
    capture, e_t, e, mu, _ = contact
    w_at, before_at, p_at, more_at = places.delassus, places.before, places.p, MORE
    n = (rows - 1) * w + lane
    before = float(work[before_at * w + n])
    xn = float(work[(more_at + rows) * w + n])
    if before < 0.0 and -before >= capture:
        xn += e * before
    nn = float(work[(w_at + rows * rows - 1) * w + lane])
    if rows == 1 or mu == 0.0:
        work[more_at * w + n] = -xn / nn
        return True
    x1 = float(work[(more_at + 3) * w + lane]) + e_t * float(work[before_at * w + lane])
    x2 = float(work[(more_at + 4) * w + lane]) + e_t * float(work[(before_at + 1) * w + lane])
    t11, t12 = float(work[w_at * w + lane]), float(work[(w_at + 1) * w + lane])
    n1, t22 = float(work[(w_at + 2) * w + lane]), float(work[(w_at + 4) * w + lane])
    n2 = float(work[(w_at + 5) * w + lane])
    p1, p2 = float(work[p_at * w + lane]), float(work[(p_at + 1) * w + lane])
    load = math.sqrt(p1 * p1 + p2 * p2)
    bound = mu * float(work[(p_at + 2) * w + lane])
    slip = -(p1 * x1 + p2 * x2) / load if load > 0.0 else 0.0
    sticks = load < bound * (1.0 - ON_CONE) or not slip > SLIPS * thrown
    if not sticks:
        s1, s2 = -p1 / load, -p2 / load
        # Columns: more load along the cone, and a turn of s by an angle; rows: n, and across s.
        a11 = nn - mu * (n1 * s1 + n2 * s2)
        a12 = bound * (n1 * s2 - n2 * s1)
        m1, m2 = n1 - mu * (t11 * s1 + t12 * s2), n2 - mu * (t12 * s1 + t22 * s2)
        a21 = m2 * s1 - m1 * s2
        a22 = -bound * (t11 * s2 * s2 - 2.0 * t12 * s1 * s2 + t22 * s1 * s1) - slip
        across = x2 * s1 - x1 * s2
        det = a11 * a22 - a12 * a21
        dn = (a12 * across - a22 * xn) / det
        turn = (a21 * xn - a11 * across) / det
        d1 = -mu * s1 * dn + bound * s2 * turn
        d2 = -mu * s2 * dn - bound * s1 * turn
    else:
        block = (t11, t12, t22, n1, n2, nn)
        (d1, d2, dn), _, _ = stopping(block, x1, x2, xn, thrown)
    work[more_at * w + lane], work[(more_at + 1) * w + lane] = d1, d2
    work[(more_at + 2) * w + lane] = dn
    if not sticks:
        return True
    left = abs(x1 + t11 * d1 + t12 * d2 + n1 * dn) + abs(x2 + t12 * d1 + t22 * d2 + n2 * dn)
    left += abs(xn + n1 * d1 + n2 * d2 + nn * dn)
    change = abs(d1) + abs(d2) + abs(dn)
    return left + EPS * (t11 + t22 + nn) * change <= LEFT * slow
