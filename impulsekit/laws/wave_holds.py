"""Forces that keep contacts of a ``Wave`` still: those that stick, and those that are held."""

from __future__ import annotations

import math

from .borrowed import borrowing
from .dense import factorize, solve_factorized
from .tolerances import SINGULAR
from .wave_state import FAINT, HELD, LEANS, SLIPS, STICKS, Wave

__all__ = ["acceleration", "direction", "hold"]

# How much redundant rows that are held give way, relative to W.
GIVES_WAY = 1e-3
# A contact of redundant rows gives way at most this many times as much as the strongest: what it
# then is given beyond its cone is rounding.
WEAKEST = 1e15
# It is taken out again until this is left of the accelerations, or so often.
HELD_STILL, MOST_AGAIN = 1e-14, 40


@borrowing
def acceleration(w: Wave, row: int) -> float:
    """du/dt of a row under the forces that are there."""
    total = 0.0
    for k in range(len(w.free)):
        total += w.W[row, k] * w.force[k]
    return total


@borrowing
def direction(w: Wave, i: int) -> tuple[float, float]:
    """The direction of slip of contact i."""
    t = w.tangent[i]
    u1, u2 = float(w.u[t]), float(w.u[t + 1])
    speed = math.sqrt(u1 * u1 + u2 * u2)
    # Beyond the end of slip it goes on as it was, so that the end can be found from both sides.
    if w.slip[i] == LEANS or speed <= FAINT or u1 * w.way[i, 0] + u2 * w.way[i, 1] <= 0.0:
        return float(w.way[i, 0]), float(w.way[i, 1])
    return u1 / speed, u2 / speed


@borrowing
def hold(w: Wave) -> None:
    """Add forces in ``w.rows`` so that their velocities keep, beside the forces that are there.

    Redundant rows share by least squares: each gives way a little, and what that leaves of the
    equations is taken out again.
    """
    solved = int(w.solved[0])
    _fill(w, solved)
    most = 0.0
    for a in range(solved):
        most = max(most, abs(w.matrix[a, a]))
    if solved == 0 or not most > 0.0:
        return
    regular = factorize(w.matrix, solved, w.order)
    for a in range(solved):
        regular = regular and abs(w.matrix[a, a]) > SINGULAR * most
    w.redundant[0] = 0 if regular else 1
    if regular:
        _keep_still(w, solved)
        return
    for weighed in (True, False):
        _fill(w, solved)
        for a in range(solved):
            w.matrix[a, a] += GIVES_WAY * most
        if weighed:
            _weigh(w, solved, GIVES_WAY * most)
        if factorize(w.matrix, solved, w.order) and _keep_still(w, solved):
            return


@borrowing
def _weigh(w: Wave, solved: int, give: float) -> None:
    """Let tangents give way the more, the less their cones hold."""
    strongest = 0.0
    for i in range(len(w.kappa)):
        if w.slip[i] == STICKS:
            strongest = max(strongest, _cone(w, i))
    for i in range(len(w.kappa)):
        if w.slip[i] != STICKS or strongest == 0.0:
            continue
        cone, a = _cone(w, i), 0
        weight = min(strongest / cone, WEAKEST) if cone > 0.0 else WEAKEST
        while w.rows[a] != w.tangent[i]:
            a += 1
        for k in range(2):
            w.matrix[a + k, a + k] += give * (weight - 1.0)


@borrowing
def _cone(w: Wave, i: int) -> float:
    """What a contact is to take of the friction that is shared."""
    force = w.load[i] if w.mode[i] == HELD else w.force[w.normal[i]]
    return float(w.mu[i] * force / w.share[i])


@borrowing
def _keep_still(w: Wave, solved: int) -> bool:
    """Add the forces; whether they keep the rows still."""
    for again in range(MOST_AGAIN):
        # What the forces so far leave of these rows' accelerations.
        left, size = 0.0, 0.0
        for a in range(solved):
            total = 0.0
            row = w.rows[a]
            for k in range(len(w.free)):
                part = w.W[row, k] * w.force[k]
                total -= part
                size = max(size, abs(part))
            w.right[a] = total
            left = max(left, abs(total))
        if again > 0 and left <= HELD_STILL * size:
            return True
        solve_factorized(w.matrix, solved, w.order, w.right)
        for a in range(solved):
            w.force[w.rows[a]] += w.right[a]
        _rub_on_held(w)
    return False


@borrowing
def _fill(w: Wave, solved: int) -> None:
    """W of the rows that are solved; what slides on a held contact rubs with the force sought."""
    for a in range(solved):
        for b in range(solved):
            w.matrix[a, b] = w.W[w.rows[a], w.rows[b]]
    for i in range(len(w.kappa)):
        if w.mode[i] == HELD and w.slip[i] in (SLIPS, LEANS):
            s1, s2 = direction(w, i)
            t, b = w.tangent[i], 0
            while w.rows[b] != w.normal[i]:
                b += 1
            for a in range(solved):
                row = w.rows[a]
                w.matrix[a, b] -= w.mu[i] * (s1 * w.W[row, t] + s2 * w.W[row, t + 1])


@borrowing
def _rub_on_held(w: Wave) -> None:
    for i in range(len(w.kappa)):
        if w.mode[i] == HELD and w.slip[i] in (SLIPS, LEANS):
            s1, s2 = direction(w, i)
            t, force = w.tangent[i], w.force[w.normal[i]]
            w.force[t], w.force[t + 1] = -w.mu[i] * force * s1, -w.mu[i] * force * s2
