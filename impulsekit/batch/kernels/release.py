"""The second part of an impact with Poisson's restitution: at least e times the first's impulse.

As ``released`` and ``bounded_friction`` of ``impact.laws``, for kernels.
"""

from __future__ import annotations

import math

from ...laws.status import Status
from ..codes import AGAIN
from .coulomb import coulomb
from .jit import built_in

__all__ = ["released"]

# A tangential inertia this much smaller than its terms is a zero.
NULL = 1e-12
# Nearer to parting than this, digits decide.
NEAR = 1e-13
_SOLVED = int(Status.SOLVED)


@built_in
def released(t11, t12, t22, n1, n2, nn, b1, b2, bn, mu, floor, scale, found, roots):
    """(P_t1, P_t2, P_n, code) of Coulomb's law with P_n ≥ floor; see ``coulomb``.

    Args:
        floor: above 0 [N s].
    """
    p1, p2 = 0.0, 0.0
    if mu > 0.0:
        p1, p2 = _bounded(t11, t12, t22, -(b1 + n1 * floor), -(b2 + n2 * floor), mu * floor)
    velocity = bn + n1 * p1 + n2 * p2 + nn * floor
    if velocity > NEAR * scale:
        return p1, p2, floor, _SOLVED
    if velocity > -NEAR * scale:
        return 0.0, 0.0, 0.0, AGAIN
    p1, p2, pn, code = coulomb(
        t11, t12, t22, n1, n2, nn, b1, b2, bn, mu, scale, found, roots
    )  # fmt: skip
    if not pn > floor:
        return 0.0, 0.0, 0.0, AGAIN
    return p1, p2, pn, code


@built_in
def _bounded(t11, t12, t22, r1, r2, bound):
    """P_t of least ½ P_tᵀ W_tt P_t − P_t·r within a bound on |P_t|."""
    trace, regular = t11 + t22, max(t11 * t22 - t12 * t12, 0.0)
    if not trace > 0.0:
        return 0.0, 0.0
    if regular > NULL * t11 * t22:
        p1, p2 = (t22 * r1 - t12 * r2) / regular, (t11 * r2 - t12 * r1) / regular
    else:
        # Of rank one, and r in its range.
        p1, p2 = r1 / trace, r2 / trace
    length = math.sqrt(r1 * r1 + r2 * r2)
    if math.sqrt(p1 * p1 + p2 * p2) <= bound or length == 0.0:
        return p1, p2
    # On the edge: |(W_tt + k)⁻¹ r| = bound. Its inverse is concave in k, so that Newton
    # from a k that is too small climbs to the root and never passes it.
    mean, half = 0.5 * (t11 + t22), 0.5 * (t11 - t22)
    spread = math.sqrt(half * half + t12 * t12)
    k = max(length / bound - mean - spread, 1e-15 * (mean + spread))
    for _ in range(100):
        k1, k2 = t11 + k, t22 + k
        det = k * (k + trace) + regular
        p1, p2 = (k2 * r1 - t12 * r2) / det, (k1 * r2 - t12 * r1) / det
        size = math.sqrt(p1 * p1 + p2 * p2)
        if size <= bound * (1.0 + 1e-15):
            break
        slope = (k2 * p1 * p1 - 2.0 * t12 * p1 * p2 + k1 * p2 * p2) / det
        step = size * size * (size - bound) / (bound * slope)
        if step <= 1e-16 * k:
            break
        k += step
    return p1, p2
