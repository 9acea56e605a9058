"""How far one impact along its path has come, as ``impact.laws.path.Progress``, for kernels.

One array of PROGRESS numbers: velocities [m/s], impulses [N s], works [J].
"""

from __future__ import annotations

import math

from .jit import built_in
from .words import NEWTON, POISSON

__all__ = [
    "COMPRESSING",
    "FALLS",
    "FRICTION",
    "NORMAL",
    "P1",
    "P2",
    "PRESSED",
    "PROGRESS",
    "REGAINED",
    "SPENT",
    "U1",
    "U2",
    "UN",
    "P",
    "is_over",
    "left_to_go",
]

# Relative velocity, impulse; work of friction; impulse and work of compression, work of
# restitution; 1 in compression, else 0; 1 where slip pressed the contact further in; at the
# end, all work of the normal impulse.
U1, U2, UN, P1, P2, P, FRICTION, PRESSED, SPENT, REGAINED, COMPRESSING, FALLS, NORMAL = range(13)
PROGRESS = 13


@built_in
def left_to_go(now, law, e, target):
    """What ends the phase at hand, in u_n, in p and in work; infinite where it is not asked."""
    if now[COMPRESSING] > 0.0:
        return -now[UN], math.inf, math.inf
    if law == NEWTON:
        return target - now[UN], math.inf, math.inf
    if law == POISSON:
        return math.inf, (1.0 + e) * now[PRESSED] - now[P], math.inf
    return math.inf, math.inf, -e * e * now[SPENT] - now[REGAINED]


@built_in
def is_over(now, law, e, target, scale):
    """Go over from compression to restitution, or tell that the impact is over."""
    if now[COMPRESSING] == 0.0:
        return True
    now[COMPRESSING] = 0.0
    now[UN] = 0.0
    return e == 0.0 or (law == NEWTON and target <= 1e-15 * scale)
