"""What a lone contact lacks where a blow alone would throw its point.

The law is told the velocity that the blow leaves, and takes it away again by W P: where it is
many times what the point has in the end, as many digits are lost. What the twists of the
bodies leave of the law, taken as small, has all digits, and so has the ΔP that mends it.
"""

from __future__ import annotations

import math

from ...laws.coulomb import stopping
from ..codes import AGAIN
from .articulated import respond
from .doubt import size_of_terms
from .jit import built_in, inlined
from .lanes import absolute, any_less, where_less, width
from .layout import BODY, DOF, FORCE, JUMP, TARGET
from .memory import load, same, store
from .rows import row_velocity

__all__ = ["lacking", "press_more"]

# How many times as fast as all that makes up the point's motion the blow alone would throw it.
THROWN = 3.0
# As much is lost where W is so near singular that impulses cancel: their terms, by this share.
BALANCED = 2.0**-8
# From which share of the bounds of friction on, and of the free speed, a contact slides.
ON_CONE, SLIPS = 1e-12, 1e-13
# What a step may leave of the contact's velocities, with the rounding of W itself, relative to
# the speeds of the point: a tenth of what a batch may be off by.
LEFT, EPS = 1e-13, 2.0**-52


@inlined
def lacking(
    count, capture, e_t, e, e_at, e_step, mu, mu_at, mu_step, term_ints, term_floats, row_first,
    work, w_at, before_at, free_at, p_at, dv_at, term_at, spare_at, more_at, w, code, witness,
):  # fmt: skip
    """Whether digits are lost in any lane; then ΔP is written, 0 where nothing is lacking.

    Args:
        count: 3, or 1 without friction.
        e_at, e_step, mu_at, mu_step: the contact's own numbers of each lane.
        spare_at: room for two values.
        more_at: where ΔP goes, with room for as much again.
    """
    zero = same(0.0, witness)
    free, slow = zero, zero
    for r in range(count):
        speed = absolute(load(work, (free_at + r) * w, witness))
        free = where_less(free, speed, speed, free)
        speed = absolute(load(work, (before_at + r) * w, witness))
        slow = where_less(slow, speed, speed, slow)
    trace, impulses = zero, zero
    for r in range(count):
        trace = trace + load(work, (w_at + r * (count + 1)) * w, witness)
        impulses = impulses + absolute(load(work, (p_at + r) * w, witness))
    terms = BALANCED * trace * impulses
    free = where_less(free, terms, terms, free)
    if not any_less(THROWN * slow, free):
        return False
    for r in range(count):
        begin, end = row_first[r], row_first[r + 1]
        size = size_of_terms(term_ints, term_floats, begin, end, work, dv_at, term_at, witness)
        slow = where_less(slow, size, size, slow)
    slow = THROWN * slow
    if not any_less(slow, free):
        return False
    store(work, spare_at * w, slow)
    store(work, (spare_at + 1) * w, free)
    for r in range(count):
        begin, end = row_first[r], row_first[r + 1]
        speed = row_velocity(
            term_ints, term_floats, begin, end, JUMP, work, dv_at, term_at, witness
        )
        speed = speed + load(work, (before_at + r) * w, witness)
        store(work, (more_at + count + r) * w, speed)
        store(work, (more_at + r) * w, zero)
    some = False
    for lane in range(w):
        thrown = float(work[(spare_at + 1) * w + lane])
        pn = float(work[(p_at + count - 1) * w + lane])
        if thrown > float(work[spare_at * w + lane]) and pn > 0.0 and code[lane] != AGAIN:
            mended = _lack(
                count, capture, e_t, e[e_at + lane * e_step], mu[mu_at + lane * mu_step], thrown,
                float(work[spare_at * w + lane]) / THROWN,
                work, w_at, before_at, p_at, more_at, w, lane,
            )  # fmt: skip
            if not mended:
                code[lane] = AGAIN
            some = True
    return some


@inlined
def press_more(
    ints, floats, dofs, bodies, loaded, count, dof_list, dof_first, work, dof_at, reduced_at, nv,
    p_at, more_at, dv_at, spare_at, witness,
):  # fmt: skip
    """Add ΔP to P, and what it makes to Δv and to the jumps of all bodies.

    Args:
        more_at: where ΔP stands, which may be in FORCE of a body.
        spare_at: room for another Δv.
    """
    w = width(witness)
    zero = same(0.0, witness)
    for dof in range(nv):
        store(work, (dof_at + dof * DOF + TARGET) * w, zero)
        store(work, (spare_at + dof) * w, load(work, (dv_at + dof) * w, witness))
    for r in range(count):
        more = load(work, (more_at + r) * w, witness)
        store(work, (p_at + r) * w, load(work, (p_at + r) * w, witness) + more)
        for k in range(dof_first[r], dof_first[r + 1]):
            at = (dof_at + dof_list[k] * DOF + TARGET) * w
            u = load(work, (reduced_at + r * nv + dof_list[k]) * w, witness)
            store(work, at, load(work, at, witness) + more * u)
    for body in range(1, bodies + 1):
        for k in range(6):
            jump = load(work, (body * BODY + JUMP + k) * w, witness)
            store(work, (body * BODY + FORCE + k) * w, jump)
    respond(ints, floats, dofs, bodies, loaded, work, dof_at, dv_at, witness)
    for body in range(1, bodies + 1):
        for k in range(6):
            at = (body * BODY + JUMP + k) * w
            jump = load(work, (body * BODY + FORCE + k) * w, witness)
            store(work, at, jump + load(work, at, witness))
    for dof in range(nv):
        change = load(work, (spare_at + dof) * w, witness)
        store(work, (dv_at + dof) * w, change + load(work, (dv_at + dof) * w, witness))


@built_in
def _lack(
    rows, capture, e_t, e, mu, thrown, slow, work, w_at, before_at, p_at, more_at, w, lane
):  # fmt: skip
    """Write ΔP of one lane by one Newton step in the mode that P tells; whether that is enough.

    Sticking: ξ = 0. Sliding against s: ξ_n = 0 and ξ_t along s, with P_t = −μ P_n s.
    """
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
