"""Articulated inertias on their way from a body to its parent: turned, then shifted.

A = [M H; Hᵀ I]. After a joint about z has been freed, A z is 0: the last column of H and
all of I but its first two rows and columns are nothing, and are not computed with.
"""

from __future__ import annotations

from .algebra import cross, dot, full, product, times
from .jit import inlined
from .layout import ABOUT_X, ABOUT_Z, TURN
from .memory import load

__all__ = ["shifted", "turned_about_z", "turned_freely"]


@inlined
def turned_about_z(turns, floats, f, work, row, w, m, h, i, zero, witness):
    """M (6), H (9) and I (6) in the axes of the parent, from those of a body that turns about z.

    Args:
        turns: the integer of the body that says which turns are not nothing.
        f, row: where the floats and the row of the body begin.
        m, h, i: M (6), the first two columns of H (row by row) and xx, xy, yy of I.
    """
    c, s = load(work, row + TURN * w, witness), load(work, row + (TURN + 1) * w, witness)
    m = _symmetric(m, c, s)
    a, b = c * h[0] - s * h[2], c * h[1] - s * h[3]
    d, e = s * h[0] + c * h[2], s * h[1] + c * h[3]
    xx, xy = c * a - s * b, s * a + c * b
    yx, yy = c * d - s * e, s * d + c * e
    zx, zy = c * h[4] - s * h[5], s * h[4] + c * h[5]
    a, b = c * i[0] - s * i[1], c * i[1] - s * i[2]
    d, e = s * i[0] + c * i[1], s * i[1] + c * i[2]
    ixx, ixy, iyy = c * a - s * b, s * a + c * b, s * d + c * e
    if turns & ABOUT_X:
        ca, sa = floats[f + 2], floats[f + 3]
        # About x is about z with y, z, x for x, y, z.
        n = _symmetric((m[3], m[4], m[1], m[5], m[2], m[0]), ca, sa)
        m = (n[5], n[2], n[4], n[0], n[1], n[3])
        a, b = ca * yx - sa * zx, ca * yy - sa * zy
        d, e = sa * yx + ca * zx, sa * yy + ca * zy
        h = (xx, ca * xy, sa * xy, a, ca * b, sa * b, d, ca * e, sa * e)
        b, d = ca * iyy, sa * iyy
        i = (ixx, ca * ixy, sa * ixy, ca * b, sa * b, sa * d)
    else:
        h = (xx, xy, zero, yx, yy, zero, zx, zy, zero)
        i = (ixx, ixy, zero, iyy, zero, zero)
    if turns & ABOUT_Z:
        cb, sb = floats[f], floats[f + 1]
        m, h, i = _symmetric(m, cb, sb), _square(h, cb, sb), _symmetric(i, cb, sb)
    return m, h, i


@inlined
def _symmetric(m, c, s):
    """R M Rᵀ, R about z."""
    a, b = c * m[0] - s * m[1], c * m[1] - s * m[3]
    d, e = s * m[0] + c * m[1], s * m[1] + c * m[3]
    return (
        c * a - s * b,
        s * a + c * b,
        c * m[2] - s * m[4],
        s * d + c * e,
        s * m[2] + c * m[4],
        m[5],
    )


@inlined
def _square(h, c, s):
    """R H Rᵀ, R about z."""
    a0, a1, a2 = c * h[0] - s * h[3], c * h[1] - s * h[4], c * h[2] - s * h[5]
    b0, b1, b2 = s * h[0] + c * h[3], s * h[1] + c * h[4], s * h[2] + c * h[5]
    return (
        c * a0 - s * a1,
        s * a0 + c * a1,
        a2,
        c * b0 - s * b1,
        s * b0 + c * b1,
        b2,
        c * h[6] - s * h[7],
        s * h[6] + c * h[7],
        h[8],
    )


@inlined
def turned_freely(r, m, h, i):
    """R M Rᵀ, R H Rᵀ and R I Rᵀ."""
    turned = product(r, h)
    h = (
        times(r, (turned[0], turned[1], turned[2]))
        + times(r, (turned[3], turned[4], turned[5]))
        + times(r, (turned[6], turned[7], turned[8]))
    )
    return _both_sides(r, m), h, _both_sides(r, i)


@inlined
def _both_sides(r, m):
    k = product(r, full(m))
    first, second, third = (r[0], r[1], r[2]), (r[3], r[4], r[5]), (r[6], r[7], r[8])
    along, across = (k[0], k[1], k[2]), (k[3], k[4], k[5])
    return (
        dot(along, first),
        dot(along, second),
        dot(along, third),
        dot(across, second),
        dot(across, third),
        dot((k[6], k[7], k[8]), third),
    )


@inlined
def shifted(m, h, i, r):
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
