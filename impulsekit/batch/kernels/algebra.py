"""Vectors (x, y, z), matrices (nine, row by row) and symmetric ones (xx, xy, xz, yy, yz, zz).

Tuples of values, in registers, and as they stand in the work array, ``step`` apart.
"""

from __future__ import annotations

from ...geometry import vectors
from .jit import inlined
from .memory import load, store

__all__ = [
    "add_triple",
    "cross",
    "dot",
    "full",
    "minus",
    "nine",
    "plus",
    "product",
    "put_nine",
    "put_six",
    "put_triple",
    "row_times",
    "six",
    "symmetric_times",
    "times",
    "transposed_times",
    "triple",
]

# As for single numbers, on lanes.
cross, dot = inlined(vectors.cross), inlined(vectors.dot)


@inlined
def triple(work, at, step, witness):
    """Three values."""
    return (
        load(work, at, witness),
        load(work, at + step, witness),
        load(work, at + 2 * step, witness),
    )


@inlined
def six(work, at, step, witness):
    """Six values."""
    return triple(work, at, step, witness) + triple(work, at + 3 * step, step, witness)


@inlined
def nine(work, at, step, witness):
    """Nine values."""
    return six(work, at, step, witness) + triple(work, at + 6 * step, step, witness)


@inlined
def put_triple(work, at, step, a):
    """Write three values."""
    store(work, at, a[0])
    store(work, at + step, a[1])
    store(work, at + 2 * step, a[2])


@inlined
def put_six(work, at, step, a):
    """Write six values."""
    put_triple(work, at, step, (a[0], a[1], a[2]))
    put_triple(work, at + 3 * step, step, (a[3], a[4], a[5]))


@inlined
def put_nine(work, at, step, a):
    """Write nine values."""
    put_six(work, at, step, (a[0], a[1], a[2], a[3], a[4], a[5]))
    put_triple(work, at + 6 * step, step, (a[6], a[7], a[8]))


@inlined
def add_triple(work, at, step, a, witness):
    """Add to three values."""
    put_triple(work, at, step, plus(triple(work, at, step, witness), a))


@inlined
def plus(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inlined
def minus(a, factor, b):
    """a − factor b."""
    return (a[0] - factor * b[0], a[1] - factor * b[1], a[2] - factor * b[2])


@inlined
def times(m, a):
    """M a."""
    return (
        m[0] * a[0] + m[1] * a[1] + m[2] * a[2],
        m[3] * a[0] + m[4] * a[1] + m[5] * a[2],
        m[6] * a[0] + m[7] * a[1] + m[8] * a[2],
    )


@inlined
def transposed_times(m, a):
    """Mᵀ a."""
    return (
        m[0] * a[0] + m[3] * a[1] + m[6] * a[2],
        m[1] * a[0] + m[4] * a[1] + m[7] * a[2],
        m[2] * a[0] + m[5] * a[1] + m[8] * a[2],
    )


@inlined
def symmetric_times(m, a):
    """M a, M symmetric."""
    return (
        m[0] * a[0] + m[1] * a[1] + m[2] * a[2],
        m[1] * a[0] + m[3] * a[1] + m[4] * a[2],
        m[2] * a[0] + m[4] * a[1] + m[5] * a[2],
    )


@inlined
def row_times(a, m):
    """aᵀ M."""
    return transposed_times(m, a)


@inlined
def product(a, b):
    """A B."""
    return (
        row_times((a[0], a[1], a[2]), b)
        + row_times((a[3], a[4], a[5]), b)
        + row_times((a[6], a[7], a[8]), b)
    )


@inlined
def full(m):
    """The nine entries of a symmetric matrix."""
    return (m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5])
