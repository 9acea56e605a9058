"""Newton on the modes of several contacts: parts, sticks or slides.

The natural map of 0 ≤ P_n − f ⊥ ξ_n ≥ 0 with Coulomb's friction (Alart & Curnier 1991) is
P_n − f = max(0, P_n − f − ρ ξ_n), P_t = proj(P_t − ρ ξ_t) onto |P_t| ≤ µ P_n; f is 0, or what an
expansion asks for at least. Its branches are the modes. A sticking contact has three unknowns,
a sliding one two, P_n and the direction s of slip: P_t = −µ P_n s, s⊥·ξ_t = 0. Newton on these,
modes seen anew at each step, until none changes.
"""

from __future__ import annotations

import math

import numpy as np

from ..tolerances import EPS
from .borrowed import borrowed, borrowing
from .compiled import entry
from .dense import gauss
from .rank import gauss_of_rank
from .tolerances import BAR
from .words import YES
from .workspace import Sizes, Workspace, workspace

__all__ = [
    "BALANCED", "DEEP", "DEPENDENT", "FINE", "MOST_STEPS", "NULL", "RIDGE", "SLIDES",
    "SUMMED", "add_stiffness", "assemble", "height_of", "largest_term", "map_naturally", "polish",
    "residual_of", "sizes_of", "write_onto_modes",
]  # fmt: skip

# Below this residual, Newton ends after a few steps that increase it.
NEARLY_SOLVED = 1e-11
# Steps from nearby at most. An integer of numpy, here and where it is an argument elsewhere:
# for another literal numba would compile all that takes it once more.
MOST_STEPS: int = np.int64(12)  # type: ignore[assignment]
# Against singular W, relative: moves only what the velocities do not notice.
RIDGE = 1e-9
# Nearer than this the ridge is left out: what is redundant would drift by rounding over it, out
# of its cones and back. Pivots below this share are then none.
NEAR = 1e-3
DEPENDENT = 1e-10
# A residual of rounding, at which further steps gain nothing. Where the terms of W P are many times
# the velocities, some ulps of these are that, too.
FINE = 4e-15
SUMMED = 4.0 * EPS
# From here on one step more is for the last digits.
DEEP = 1e-13
# How often the residual may rise, where contacts on the edge of their cones change modes.
RISES = 3
# A row of W with this share of the largest on its diagonal moves nothing.
NULL = 1e-14
# Contacts whose masses differ by less than this are much alike.
ALIKE_MASSES = 1e-2
# How many times the velocities W P may be before its rounding counts: beyond it an impulse that
# solves nothing could be so large that what it leaves drowns in its own rounding.
BALANCED = 1e3
# Parts; sticks; slides; the same two with P_n held at f.
PARTS, STICKS, SLIDES, STICKS_AT_FLOOR, SLIDES_AT_FLOOR = 0, 1, 2, 3, 4


@borrowing
def sizes_of(work: Workspace, n: int, scale: float) -> Sizes:
    """What counts as nothing.

    Args:
        work: W and b.
        n: how many contacts.
        scale: the size of the velocities where they were larger before [m/s].
    """
    largest, lightest, heaviest = 0.0, 0.0, math.inf
    for i in range(n):
        # The mobility of a contact is the same whichever way its tangents point.
        own = 0.0
        for k in range(3 * i, 3 * i + 3):
            scale = max(scale, abs(work.b[k]))
            largest = max(largest, work.W[k, k])
            own += work.W[k, k]
        lightest, heaviest = max(lightest, own), min(heaviest, own)
    # Where no impulse moves anything any size will do.
    least = NULL * largest if largest > 0.0 else 1.0
    return Sizes(scale, largest, least, heaviest > ALIKE_MASSES * lightest)


def _examples() -> tuple[object, ...]:
    return workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), MOST_STEPS, 0.0


# Called from some twenty places, none of which is to have all of it compiled in.
@entry(_examples, seconds=1.5, apart=True)
def polish(work: Workspace, n: int, sizes: Sizes, most: int, ridge: float) -> float:
    """Bring P (3n,) from nearby to rounding level; the residual.

    Args:
        work: the problem, with P to begin with.
        n: how many contacts.
        sizes: what counts as nothing.
        most: steps; of several as many again where they were spent on the modes and the last digits
            are still to come.
        ridge: relative; 0 where W is known to be regular and every row to move something.
    """
    work = borrowed(work)
    P, best = work.P, work.best
    size = 3 * n
    for j in range(size):
        best[j] = P[j]
    bar = math.inf
    risen, left, again = 0, most, most > 1
    while left >= 0:
        residual = residual_of(work, n, sizes)
        if not residual < math.inf:
            break
        if residual < bar:
            last = bar < DEEP
            bar = residual
            for j in range(size):
                best[j] = P[j]
            # Deep enough; one step more is only for the last digits.
            if last and bar <= FINE:
                break
        elif bar < NEARLY_SOLVED:
            risen += 1
            rounding = SUMMED * largest_term(work.W, P, size) / sizes.scale
            if risen > RISES or bar <= max(FINE, rounding):
                break
        if left == 0 and again and DEEP < bar <= BAR:
            left, again = most, False
        if left > 0 and not stepped(work, n, sizes, ridge, ridge > 0.0 and residual < NEAR):
            break
        left -= 1
    for j in range(size):
        P[j] = best[j]
    return bar


@borrowing
def residual_of(work: Workspace, n: int, sizes: Sizes) -> float:
    """The natural map's distance from its fixed point, relative; writes ξ, modes and slips."""
    _form(work, n)
    for k in range(3 * n):
        if not abs(work.xi[k]) < math.inf:
            return math.inf
    return map_naturally(work, n, sizes, YES)


@borrowing
def largest_term(W: np.ndarray, P: np.ndarray, size: int) -> float:
    """The largest Σ_j |W_ij P_j| [m/s] of the leading rows: what the rounding of W P goes by."""
    most = 0.0
    for r in range(size):
        total = 0.0
        for c in range(size):
            total += abs(W[r, c] * P[c])
        most = max(most, total)
    return most


@borrowing
def height_of(work: Workspace, n: int) -> float:
    """½ PᵀW P + b·P [J]: of several answers the one where it is least is nearest to sticking."""
    height = 0.0
    for r in range(3 * n):
        total = work.b[r]
        for c in range(3 * n):
            total += 0.5 * work.W[r, c] * work.P[c]
        height += work.P[r] * total
    return height


@borrowing
def _form(work: Workspace, n: int) -> None:
    """ξ = W P + b, by columns, which lie as the rows do: many entries at once."""
    W, b, P, xi = work.W, work.b, work.P, work.xi
    for k in range(3 * n):
        xi[k] = b[k]
    for j in range(3 * n):
        if P[j] != 0.0:
            for k in range(3 * n):
                xi[k] += W[j, k] * P[j]


@borrowing
def map_naturally(work: Workspace, n: int, sizes: Sizes, formed: bool) -> float:
    """The residual of P and ξ as they stand, with modes and slips.

    Args:
        formed: whether ξ was formed as W P + b, and has the rounding of that.
    """
    W, mu, floor, P, xi = work.W, work.mu, work.floor, work.P, work.xi
    mode, slip = work.mode, work.slip
    worst = 0.0
    size = sizes.scale
    largest_load = BALANCED * sizes.scale
    for i in range(n):
        k = 3 * i
        normal_rate = max(W[k + 2, k + 2], sizes.least)
        rate = max(W[k, k] + W[k + 1, k + 1], sizes.least)
        load = normal_rate * (P[k + 2] - floor[i])
        pushing = load > xi[k + 2]
        worst = max(worst, abs(xi[k + 2] if pushing else load))
        # Impulses in balance leave their own rounding where W P is formed.
        if formed:
            own = normal_rate * P[k + 2]
            size = max(size, min(own, largest_load))
            if own > largest_load:
                # Of impulses without bound nothing is known.
                worst = max(worst, EPS * own)
        if not pushing and floor[i] == 0.0:
            mode[i] = PARTS
            worst = max(worst, rate * (abs(P[k]) + abs(P[k + 1])))
            continue
        q1, q2 = P[k] - xi[k] / rate, P[k + 1] - xi[k + 1] / rate
        length = math.sqrt(q1 * q1 + q2 * q2)
        bound = mu[i] * P[k + 2] if P[k + 2] > 0.0 else 0.0
        if length > bound:
            q1, q2 = q1 / length, q2 / length
            mode[i] = SLIDES if pushing else SLIDES_AT_FLOOR
            slip[i, 0], slip[i, 1] = -q1, -q2
            d1, d2 = P[k] - bound * q1, P[k + 1] - bound * q2
            worst = max(worst, rate * math.sqrt(d1 * d1 + d2 * d2))
        else:
            mode[i] = STICKS if pushing else STICKS_AT_FLOOR
            worst = max(worst, math.sqrt(xi[k] * xi[k] + xi[k + 1] * xi[k + 1]))
    return worst / size if size > 0.0 else 0.0


@borrowing
def stepped(work: Workspace, n: int, sizes: Sizes, ridge: float, near: bool) -> bool:
    """One Newton step on the modes; False where the system is singular."""
    m = write_onto_modes(work, n)
    if m == 0:
        return True
    _form(work, n)
    assemble(work, m)
    matrix, x = work.matrix, work.x
    if not near and ridge > 0.0:
        for r in range(m):
            # Each unknown its own: beside a gram's contact a tonne's must not drown.
            size = abs(matrix[r, r])
            own = size if size > sizes.least and not sizes.alike else sizes.largest
            work.moved[r] = ridge * own
        _even_tangents(work, m)
        for r in range(m):
            matrix[r, r] += work.moved[r]
    add_stiffness(work, n)
    if near:
        gauss_of_rank(matrix, m, x, DEPENDENT, work.moved, work.xi)
    elif not gauss(matrix, m, x):
        return False
    _move(work, n, m)
    return True


@borrowing
def _even_tangents(work: Workspace, m: int) -> None:
    """Both tangents of a contact that sticks get one ridge: their directions decide nothing."""
    for r in range(m - 1):
        i = work.owner[r]
        k = 3 * i
        if work.mode[i] in (SLIDES, SLIDES_AT_FLOOR) or work.owner[r + 1] != i:
            continue
        if work.way[r, k] == 1.0 and work.way[r + 1, k + 1] == 1.0:
            mean = 0.5 * (work.moved[r] + work.moved[r + 1])
            work.moved[r], work.moved[r + 1] = mean, mean


@borrowing
def write_onto_modes(work: Workspace, n: int) -> int:
    """Write P onto its modes, and the way and aim of its change; the number of unknowns."""
    mu, floor, P = work.mu, work.floor, work.P
    mode, slip, way, aim, owner = work.mode, work.slip, work.way, work.aim, work.owner
    size = 3 * n
    m = int(np.int64(0))
    for k in range(size):
        for j in range(size):
            way[k, j] = 0.0
            aim[k, j] = 0.0
    for i in range(n):
        k = 3 * i
        if mode[i] == PARTS:
            P[k], P[k + 1], P[k + 2] = 0.0, 0.0, 0.0
            continue
        pushing = mode[i] <= SLIDES
        pn = max(P[k + 2], floor[i]) if pushing else floor[i]
        P[k + 2] = pn
        if mu[i] == 0.0:
            P[k], P[k + 1] = 0.0, 0.0
            if pushing:
                way[m, k + 2] = 1.0
                aim[m, k + 2] = 1.0
                owner[m] = i
                m += 1
        elif mode[i] == SLIDES or mode[i] == SLIDES_AT_FLOOR:
            s1, s2 = slip[i, 0], slip[i, 1]
            P[k], P[k + 1] = -mu[i] * pn * s1, -mu[i] * pn * s2
            if pushing:
                way[m, k], way[m, k + 1], way[m, k + 2] = -mu[i] * s1, -mu[i] * s2, 1.0
                aim[m, k + 2] = 1.0
                owner[m] = i
                m += 1
            way[m, k], way[m, k + 1] = s2, -s1
            aim[m, k], aim[m, k + 1] = s2, -s1
            owner[m] = i
            m += 1
        else:
            for j in range(3 if pushing else 2):
                way[m, k + j] = 1.0
                aim[m, k + j] = 1.0
                owner[m] = i
                m += 1
    return m


@borrowing
def assemble(work: Workspace, m: int) -> None:
    """Write Aimᵀ W Way x = Aimᵀ ξ, the system of the change of P."""
    W, xi, way, aim, matrix = work.W, work.xi, work.way, work.aim, work.matrix
    owner, moves = work.owner, work.moved
    size = 0
    for r in range(m):
        # The few entries of a row of each belong to one contact.
        i = 3 * owner[r]
        size = max(size, i + 3)
        work.x[r] = aim[r, i] * xi[i] + aim[r, i + 1] * xi[i + 1] + aim[r, i + 2] * xi[i + 2]
    for c in range(m):
        j = 3 * owner[c]
        w0, w1, w2 = way[c, j], way[c, j + 1], way[c, j + 2]
        # By rows of W, which lie as its columns do: many entries at once.
        for k in range(size):
            moves[k] = W[j, k] * w0 + W[j + 1, k] * w1 + W[j + 2, k] * w2
        for r in range(m):
            i = 3 * owner[r]
            matrix[r, c] = (
                aim[r, i] * moves[i] + aim[r, i + 1] * moves[i + 1] + aim[r, i + 2] * moves[i + 2]
            )


@borrowing
def add_stiffness(work: Workspace, n: int) -> None:
    """As slip turns, so does what is across it."""
    mu, P, xi, mode, slip, matrix = work.mu, work.P, work.xi, work.mode, work.slip, work.matrix
    c = 0
    for i in range(n):
        if mode[i] == PARTS:
            continue
        pushing = mode[i] <= SLIDES
        if mu[i] == 0.0:
            c += pushing
        elif mode[i] == SLIDES or mode[i] == SLIDES_AT_FLOOR:
            c += pushing
            bound = mu[i] * P[3 * i + 2]
            along = slip[i, 0] * xi[3 * i] + slip[i, 1] * xi[3 * i + 1]
            if bound > 0.0 and along > 0.0:
                matrix[c, c] += along / bound
            c += 1
        else:
            c += 3 if pushing else 2


@borrowing
def _move(work: Workspace, n: int, m: int) -> None:
    """P by the step, slip back on the edge of its cone in the direction that it has turned to."""
    mu, floor, P, mode, slip = work.mu, work.floor, work.P, work.mode, work.slip
    way, x, bounds = work.way, work.x, work.moved
    for i in range(n):
        bounds[i] = mu[i] * P[3 * i + 2]
    for c in range(m):
        for k in range(3 * work.owner[c], 3 * work.owner[c] + 3):
            P[k] -= way[c, k] * x[c]
    for i in range(n):
        if (mode[i] == SLIDES or mode[i] == SLIDES_AT_FLOOR) and mu[i] > 0.0:
            k = 3 * i
            s1, s2 = slip[i, 0], slip[i, 1]
            across = s2 * P[k] - s1 * P[k + 1]
            turn = math.atan(across / bounds[i]) if bounds[i] > 0.0 else 0.0
            cosine, sine = mu[i] * math.cos(turn), mu[i] * math.sin(turn)
            pn = max(floor[i], P[k + 2])
            P[k] = pn * (sine * s2 - cosine * s1)
            P[k + 1] = -pn * (cosine * s2 + sine * s1)
