"""Articulated inertias, from the tips inwards.

A = [M H; Hᵀ I] is the articulated inertia of a body with all that hangs on it
(Featherstone 1983), about the origin of its joint, in world axes. A degree of freedom
along s takes U Uᵀ/D from it, U = A s, D = s·U; what is left goes to the parent. A joint
of several degrees of freedom is taken as several joints with bodies without mass or
extent between them.
"""

from __future__ import annotations

from .algebra import (
    cross,
    dot,
    full,
    nine,
    product,
    put_nine,
    put_six,
    put_triple,
    six,
    symmetric_times,
    times,
    transposed_times,
    triple,
)
from .jit import built_in
from .lanes import width
from .layout import (
    ACCUMULATED,
    BODY,
    BODY_FLOATS,
    BODY_INTS,
    DOF,
    DOF_INTS,
    INVERSE,
    LOAD_FLOATS,
    LOAD_INTS,
    OFFSET,
)
from .memory import collect, load, same, store

__all__ = ["factor", "weigh"]


@built_in
def factor(ints, floats, dofs, count, work, dof_at, loads_at, witness):
    """Write U and 1/D of every degree of freedom, given rotations and offsets.

    ``loads_at`` is where the inertias stand that vary.
    """
    w = width(witness)
    for body in range(count, 0, -1):
        at = body * BODY_INTS
        parent, first, size = ints[at], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        vary = ints[at + 7]
        if vary >= 0:
            first_load = (loads_at + vary * LOAD_FLOATS) * w
            mass = load(work, first_load, witness)
            moment = triple(work, first_load + w, w, witness)
            about = six(work, first_load + 4 * w, w, witness)
        else:
            mass, moment, about = _constants(floats, body * BODY_FLOATS + 12, witness)
        m, h, i = _own(mass, moment, about, nine(work, row, w, witness), witness)
        a = row + ACCUMULATED * w
        if ints[at + 5]:
            m, h, i = _joined(work, a, w, m, h, i, witness)
        for dof in range(first + size - 1, first - 1, -1):
            d = (dof_at + dof * DOF) * w
            axis = triple(work, row + dofs[dof * DOF_INTS + 1] * w, 3 * w, witness)
            if dofs[dof * DOF_INTS] == 1:
                u, v = times(h, axis), symmetric_times(i, axis)
                inverse = 1.0 / dot(axis, v)
            else:
                u, v = symmetric_times(m, axis), transposed_times(h, axis)
                inverse = 1.0 / dot(axis, u)
            put_triple(work, d, w, u)
            put_triple(work, d + 3 * w, w, v)
            store(work, d + INVERSE * w, inverse)
            if parent > 0 or dof > first:
                m, h, i = _freed(m, h, i, u, v, inverse)
        if parent == 0:
            continue
        h, i = _carried(m, h, i, triple(work, row + OFFSET * w, w, witness))
        a = (parent * BODY + ACCUMULATED) * w
        if not ints[at + 6]:
            m, h, i = _joined(work, a, w, m, h, i, witness)
        put_six(work, a, w, m)
        put_nine(work, a + 6 * w, w, h)
        put_six(work, a + 15 * w, w, i)


@built_in
def _constants(floats, f, witness):
    """Mass, first moment and inertia of a body as they stand in its table."""
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


@built_in
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


@built_in
def _own(mass, moment, j, r, witness):
    """The inertia of a body alone, turned to world axes: m 1, −m [c]×, R J Rᵀ."""
    zero = same(0.0, witness)
    x, y, z = times(r, moment)
    k = product(r, full(j))
    first, second, third = (r[0], r[1], r[2]), (r[3], r[4], r[5]), (r[6], r[7], r[8])
    along = (k[0], k[1], k[2])
    across = (k[3], k[4], k[5])
    return (
        (mass, zero, zero, mass, zero, mass),
        (zero, z, -y, -z, zero, x, y, -x, zero),
        (
            dot(along, first),
            dot(along, second),
            dot(along, third),
            dot(across, second),
            dot(across, third),
            dot((k[6], k[7], k[8]), third),
        ),
    )


@built_in
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


@built_in
def _freed(m, h, i, u, v, inverse):
    """A − U Uᵀ/D."""
    a, b, c = u[0] * inverse, u[1] * inverse, u[2] * inverse
    d, e, f = v[0] * inverse, v[1] * inverse, v[2] * inverse
    return (
        (
            m[0] - a * u[0],
            m[1] - a * u[1],
            m[2] - a * u[2],
            m[3] - b * u[1],
            m[4] - b * u[2],
            m[5] - c * u[2],
        ),
        (
            h[0] - a * v[0],
            h[1] - a * v[1],
            h[2] - a * v[2],
            h[3] - b * v[0],
            h[4] - b * v[1],
            h[5] - b * v[2],
            h[6] - c * v[0],
            h[7] - c * v[1],
            h[8] - c * v[2],
        ),
        (
            i[0] - d * v[0],
            i[1] - d * v[1],
            i[2] - d * v[2],
            i[3] - e * v[1],
            i[4] - e * v[2],
            i[5] - f * v[2],
        ),
    )


@built_in
def _carried(m, h, i, r):
    """H and I about a point at −r: G = H − M [r]×, I + [r]× G + ([r]× H)ᵀ."""
    n = full(m)
    # Rows of M [r]× are m × r, columns of [r]× G are r × g.
    a = cross((n[0], n[1], n[2]), r)
    b = cross((n[3], n[4], n[5]), r)
    c = cross((n[6], n[7], n[8]), r)
    g = (
        h[0] - a[0],
        h[1] - a[1],
        h[2] - a[2],
        h[3] - b[0],
        h[4] - b[1],
        h[5] - b[2],
        h[6] - c[0],
        h[7] - c[1],
        h[8] - c[2],
    )
    x, y, z = r
    return g, (
        i[0] + (y * g[6] - z * g[3]) + (y * h[6] - z * h[3]),
        i[1] + (y * g[7] - z * g[4]) + (z * h[0] - x * h[6]),
        i[2] + (y * g[8] - z * g[5]) + (x * h[3] - y * h[0]),
        i[3] + (z * g[1] - x * g[7]) + (z * h[1] - x * h[7]),
        i[4] + (z * g[2] - x * g[8]) + (x * h[4] - y * h[1]),
        i[5] + (x * g[5] - y * g[2]) + (x * h[5] - y * h[2]),
    )
