"""Articulated inertias, from the tips inwards.

A = [M H; Hᵀ I] is the articulated inertia of a body with all that hangs on it
(Featherstone 1983), about the origin of its joint, in the body's own axes. A degree of
freedom along s takes U Uᵀ/D from it, U = A s, D = s·U + armature; what is left goes to the
parent. s is an axis there, so that U is a column of A and s·U an entry. A joint of several
degrees of freedom is taken as several joints with bodies without mass or extent between them.
"""

from __future__ import annotations

from .algebra import nine, put_nine, put_six, put_triple, six, triple
from .handing import shifted, turned_about_z, turned_freely
from .jit import inlined
from .kinematics import offset_of
from .lanes import width
from .layout import (
    ACCUMULATED,
    BODY,
    BODY_FLOATS,
    BODY_INTS,
    CIRCLE,
    DOF,
    DOF_INTS,
    FREE,
    INVERSE,
    LOAD_FLOATS,
    LOAD_INTS,
    QUATERNION,
    TURN,
)
from .memory import collect, load, same, store

__all__ = ["factor", "weigh", "weights_of"]


@inlined
def factor(ints, floats, dofs, armature, count, work, dof_at, loads_at, witness):
    """Write U and 1/D of every degree of freedom, given how the bodies stand.

    ``armature`` has an entry per degree of freedom; ``loads_at`` is where the inertias stand
    that vary.
    """
    w = width(witness)
    zero = same(0.0, witness)
    for body in range(count, 0, -1):
        at = body * BODY_INTS
        parent, kind, first, size = ints[at], ints[at + 1], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        f = body * BODY_FLOATS
        mass, (x, y, z), i = weights_of(ints, floats, body, work, loads_at, witness)
        # Of a body alone: m 1, −m [c]×, J.
        m = (mass, zero, zero, mass, zero, mass)
        h = (zero, z, -y, -z, zero, x, y, -x, zero)
        a = row + ACCUMULATED * w
        if ints[at + 5]:
            m, h, i = _joined(work, a, w, m, h, i, witness)
        if kind <= CIRCLE:
            d = (dof_at + first * DOF) * w
            inverse = 1.0 / i[5]
            put_six(work, d, w, (h[2], h[5], h[8], i[2], i[4], i[5]))
            store(work, d + INVERSE * w, inverse)
            if parent == 0:
                continue
            m, two, three = _freed(m, h, i, inverse)
            m, h, i = turned_about_z(
                ints[at + 8], floats, f, work, row, w, m, two, three, zero, witness
            )
        else:
            _put(work, a, w, m, h, i)
            _free_all(kind, dofs, armature, first, size, work, a, dof_at, witness)
            if parent == 0:
                continue
            m, h, i = turned_freely(
                nine(work, row + TURN * w, w, witness), *_taken(work, a, w, witness)
            )
        h, i = shifted(m, h, i, offset_of(kind, floats, f, work, row, w, witness))
        a = (parent * BODY + ACCUMULATED) * w
        if not ints[at + 6]:
            m, h, i = _joined(work, a, w, m, h, i, witness)
        put_six(work, a, w, m)
        put_nine(work, a + 6 * w, w, h)
        put_six(work, a + 15 * w, w, i)


@inlined
def weights_of(ints, floats, body, work, loads_at, witness):
    """Mass, first moment and inertia of a body, from its table or those that vary."""
    w = width(witness)
    vary, f = ints[body * BODY_INTS + 7], body * BODY_FLOATS + 12
    if vary >= 0:
        at = (loads_at + vary * LOAD_FLOATS) * w
        moment = triple(work, at + w, w, witness)
        return load(work, at, witness), moment, six(work, at + 4 * w, w, witness)
    return (
        same(floats[f], witness),
        (
            same(floats[f + 1], witness),
            same(floats[f + 2], witness),
            same(floats[f + 3], witness),
        ),
        (
            same(floats[f + 4], witness),
            same(floats[f + 5], witness),
            same(floats[f + 6], witness),
            same(floats[f + 7], witness),
            same(floats[f + 8], witness),
            same(floats[f + 9], witness),
        ),
    )


@inlined
def weigh(ints, floats, load_ints, load_floats, count, given, at, stride, work, to, witness):
    """Write the inertias that vary: the body's own and (factor − 1) times that of its links.

    Args:
        load_ints, load_floats: the tables of these links.
        count: of the bodies.
        given: flat; the factors of the first state begin at ``at``, those of the next
            ``stride`` further on.
    """
    w = width(witness)
    for body in range(1, count + 1):
        vary = ints[body * BODY_INTS + 7]
        if vary >= 0:
            for k in range(LOAD_FLOATS):
                own = same(floats[body * BODY_FLOATS + 12 + k], witness)
                store(work, (to + vary * LOAD_FLOATS + k) * w, own)
    for link in range(len(load_ints) // LOAD_INTS):
        vary, column = load_ints[link * LOAD_INTS], load_ints[link * LOAD_INTS + 1]
        more = collect(given, at + column, stride, witness) - 1.0
        for k in range(LOAD_FLOATS):
            here = (to + vary * LOAD_FLOATS + k) * w
            part = more * load_floats[link * LOAD_FLOATS + k]
            store(work, here, load(work, here, witness) + part)


@inlined
def _joined(work, at, w, m, h, i, witness):
    """An inertia and the one that stands in the work array."""
    n = six(work, at, w, witness)
    g = nine(work, at + 6 * w, w, witness)
    j = six(work, at + 15 * w, w, witness)
    return (
        (m[0] + n[0], m[1] + n[1], m[2] + n[2], m[3] + n[3], m[4] + n[4], m[5] + n[5]),
        (
            h[0] + g[0],
            h[1] + g[1],
            h[2] + g[2],
            h[3] + g[3],
            h[4] + g[4],
            h[5] + g[5],
            h[6] + g[6],
            h[7] + g[7],
            h[8] + g[8],
        ),
        (i[0] + j[0], i[1] + j[1], i[2] + j[2], i[3] + j[3], i[4] + j[4], i[5] + j[5]),
    )


@inlined
def _freed(m, h, i, inverse):
    """A − U Uᵀ/D for the turn about z: M, two columns of H, xx, xy, yy of I; all else is 0."""
    a, b, c = h[2] * inverse, h[5] * inverse, h[8] * inverse
    d, e = i[2] * inverse, i[4] * inverse
    return (
        (
            m[0] - a * h[2],
            m[1] - a * h[5],
            m[2] - a * h[8],
            m[3] - b * h[5],
            m[4] - b * h[8],
            m[5] - c * h[8],
        ),
        (
            h[0] - a * i[2],
            h[1] - a * i[4],
            h[3] - b * i[2],
            h[4] - b * i[4],
            h[6] - c * i[2],
            h[7] - c * i[4],
        ),
        (i[0] - d * i[2], i[1] - d * i[4], i[3] - e * i[4]),
    )


@inlined
def _put(work, at, w, m, h, i):
    """Write the lower triangle of A, row by row."""
    put_triple(work, at, w, (m[0], m[1], m[3]))
    put_triple(work, at + 3 * w, w, (m[2], m[4], m[5]))
    for_x, for_y = (h[0], h[3], h[6], i[0]), (h[1], h[4], h[7], i[1], i[3])
    put_triple(work, at + 6 * w, w, (for_x[0], for_x[1], for_x[2]))
    store(work, at + 9 * w, for_x[3])
    put_triple(work, at + 10 * w, w, (for_y[0], for_y[1], for_y[2]))
    store(work, at + 13 * w, for_y[3])
    store(work, at + 14 * w, for_y[4])
    put_triple(work, at + 15 * w, w, (h[2], h[5], h[8]))
    put_triple(work, at + 18 * w, w, (i[2], i[4], i[5]))


@inlined
def _taken(work, at, w, witness):
    """M, H, I from the lower triangle of A."""
    m = six(work, at, w, witness)
    x = triple(work, at + 6 * w, w, witness)
    y = triple(work, at + 10 * w, w, witness)
    z = triple(work, at + 15 * w, w, witness)
    i = triple(work, at + 18 * w, w, witness)
    xx = load(work, at + 9 * w, witness)
    xy, yy = load(work, at + 13 * w, witness), load(work, at + 14 * w, witness)
    return (
        (m[0], m[1], m[3], m[2], m[4], m[5]),
        (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]),
        (xx, xy, i[0], yy, i[1], i[2]),
    )


@inlined
def _free_all(kind, dofs, armature, first, size, work, a, dof_at, witness):
    """Free a joint's degrees of freedom, the last one first; A is a lower triangle in ``work``.

    Along what has been freed A is left as U a/D, zero without an armature a.
    """
    w = width(witness)
    geared = False
    for dof in range(first, first + size):
        geared = geared or armature[dof] != 0.0
    for dof in range(first + size - 1, first - 1, -1):
        d = (dof_at + dof * DOF) * w
        k = 3 * dofs[dof * DOF_INTS] + dofs[dof * DOF_INTS + 1]
        for j in range(6):
            low, high = min(j, k), max(j, k)
            entry = a + (high * (high + 1) // 2 + low) * w
            store(work, d + j * w, load(work, entry, witness))
        inverse = 1.0 / (load(work, d + k * w, witness) + armature[dof])
        store(work, d + INVERSE * w, inverse)
        left = inverse * armature[dof]
        for j in range(6):
            low, high = min(j, k), max(j, k)
            entry = a + (high * (high + 1) // 2 + low) * w
            store(work, entry, load(work, d + j * w, witness) * left)
        # Freed from the last to the first, all behind one is nothing.
        last = k if kind in (FREE, QUATERNION) and not geared else 6
        for j in range(last):
            share = load(work, d + j * w, witness) * inverse
            for n in range(j + 1):
                entry = a + (j * (j + 1) // 2 + n) * w
                if j != k and n != k:
                    less = load(work, entry, witness) - share * load(work, d + n * w, witness)
                    store(work, entry, less)
