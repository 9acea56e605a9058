"""Coming near the impulses of contacts with friction, from where Newton goes on."""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import compiled, entry
from .coulomb import coulomb, released
from .modes import FINE, MOST_STEPS, NULL, RIDGE, polish, residual_of
from .progress import Block
from .splitting import split
from .status import Status
from .tolerances import SETTLED
from .workspace import Sizes, Workspace, workspace

__all__ = [
    "ALL_ROUNDS",
    "NO_ROUND",
    "approach_in_rounds",
    "approach_regularized",
    "block_at",
    "sweep",
]

# Rounds of sweeps (above 0) and of splitting (below), which knows no order of the contacts: where
# several answers obey the law, the same is to be found however the contacts are numbered.
SWEEPS = (-30, -20, -40, -80, -160, -400, 10, 30, -800, 200)
# The first of these, and one behind the last.
NO_ROUND: int = np.int64(0)  # type: ignore[assignment]
ALL_ROUNDS: int = np.int64(len(SWEEPS))  # type: ignore[assignment]
# How much splitting minds the cones in its first round, in units of the contacts' own mobilities,
# and from then on at most: of the size of the geometric mean of W's largest and least eigenvalues
# where feet of a robot slip.
RATE, SLOWER = 0.05, 1e-3
# By what factor a step of splitting is longer from its second round on: fewer steps.
RELAXED = 1.6
# Behind the first round of splitting Newton starts where the residual is below this: from farther
# it mostly fails, or ends at another answer than the one that is near.
CALM = 1e-4
# The proximal point: ε at first, at least and at most, as a share of each contact's mobility.
PROXIMAL_FIRST, LEAST, MOST = 0.1, 1e-6, 1.0
# Contacts that move next to nothing count as moving this share of what the lightest does.
LIGHTEST_MOVED = 1e-14
# ε halves at each step that gets there: from PROXIMAL_FIRST to LEAST in some twenty.
PROXIMAL_STEPS = 80
# What a proximal step's own residual must come down to.
STEP_BAR = 1e-9
_NONE, _MANY = int(Status.NO_SOLUTION), int(Status.MANY_SOLUTIONS)


@borrowing
def approach_in_rounds(
    work: Workspace, n: int, sizes: Sizes, first: int, last: int, bar: float
) -> float:
    """Rounds ``first`` to ``last`` of sweeps and splitting, Newton after each; the residual.

    Args:
        work: the problem. Round 0 starts from nothing, the others from P and
            what the last ones left in y and z.
        n: how many contacts.
        sizes: what counts as nothing.
        first, last: rounds.
        bar: the residual to come down to.
    """
    P, unit = work.P, work.unit
    if first == 0:
        for i in range(n):
            own = mobility_of(work.W, 3 * i)
            unit[i] = 1.0 / math.sqrt(max(own, NULL * sizes.largest))
        for k in range(3 * n):
            P[k], work.y[k], work.z[k] = 0.0, 0.0, 0.0
    rate = RATE
    residual = math.inf
    for k in range(first, last):
        if SWEEPS[k] > 0:
            sweep(work, n, sizes.scale, SWEEPS[k])
        else:
            rate = split(work, n, -SWEEPS[k], rate, 1.0 if k == 0 else RELAXED)
            if k == 0:
                rate = min(rate, SLOWER)
            for j in range(3 * n):
                P[j] = unit[j // 3] * work.y[j]
        if k > 0 and SWEEPS[k] < 0 and residual_of(work, n, sizes) > CALM:
            continue
        residual = polish(work, n, sizes, MOST_STEPS, RIDGE)
        if residual <= bar:
            break
    return residual


def _examples() -> tuple[object, ...]:
    return workspace(1), 1, 1.0, 1


@entry(_examples, seconds=2.5, apart=True)
def sweep(work: Workspace, n: int, scale: float, sweeps: int) -> bool:
    """Contact after contact in closed form; one that needs a second look keeps what it has.

    Whether nothing changed in the end.
    """
    work = borrowed(work)
    W, b, mu, floor, P = work.W, work.b, work.mu, work.floor, work.P
    size = 3 * n
    for _ in range(sweeps):
        largest = 0.0
        for i in range(n):
            k = 3 * i
            u1, u2, un = b[k], b[k + 1], b[k + 2]
            for j in range(size):
                if j < k or j > k + 2:
                    u1 += W[k, j] * P[j]
                    u2 += W[k + 1, j] * P[j]
                    un += W[k + 2, j] * P[j]
            block = block_at(W, k)
            if floor[i] > 0.0:
                (p1, p2, pn), code = released(block, (u1, u2, un), mu[i], floor[i], scale)
            else:
                (p1, p2, pn), code = coulomb(block, u1, u2, un, mu[i], scale)
            if code in (_MANY, _NONE) and not pn > 0.0:
                continue
            largest = max(largest, W[k + 2, k + 2] * abs(pn - P[k + 2]))
            P[k], P[k + 1], P[k + 2] = p1, p2, pn
        if largest <= SETTLED * scale:
            return True
    return False


@borrowing
def block_at(W: np.ndarray, k: int) -> Block:
    """W of the contact whose rows begin at k with itself, as the law of one contact takes it."""
    return W[k, k], W[k, k + 1], W[k + 1, k + 1], W[k, k + 2], W[k + 1, k + 2], W[k + 2, k + 2]


@borrowing
def mobility_of(W: np.ndarray, k: int) -> float:
    """How much the contact whose rows begin at k moves at most: in its plane or across [1/kg].

    The same whichever way its tangents point, so that the same answer is found however they do.
    """
    mean, half = 0.5 * (W[k, k] + W[k + 1, k + 1]), 0.5 * (W[k, k] - W[k + 1, k + 1])
    across: float = mean + math.sqrt(half * half + W[k, k + 1] ** 2)
    return max(across, float(W[k + 2, k + 2]))


@compiled
def approach_regularized(work: Workspace, n: int, sizes: Sizes, bar: float) -> float:
    """Newton through nearby problems that are regular; the residual of P, the best found.

    W + εI with b − εP_k has its solution near P_k, and a fixed point P_{k+1} = P_k solves the
    problem itself (Rockafellar 1976, the proximal point method). ε falls while Newton gets
    there, and grows where it does not.

    Args:
        work: the problem, with P to begin with.
        n: how many contacts.
        sizes: what counts as nothing.
        bar: the residual to come down to.
    """
    size = 3 * n
    near = workspace(n)
    best = work.P[:size].copy()
    share, least = PROXIMAL_FIRST, math.inf
    for i in range(n):
        near.mu[i], near.floor[i] = work.mu[i], work.floor[i]
    for _ in range(PROXIMAL_STEPS):
        for r in range(size):
            i = 3 * (r // 3)
            # Each contact by its own mass, whichever way its tangents point.
            own = work.W[i, i] + work.W[i + 1, i + 1] + work.W[i + 2, i + 2]
            epsilon = share * max(own, LIGHTEST_MOVED * sizes.largest)
            for c in range(size):
                near.W[r, c] = work.W[r, c]
            near.W[r, r] += epsilon
            near.P[r] = work.P[r]
            near.b[r] = work.b[r] - epsilon * work.P[r]
        if polish(near, n, sizes, MOST_STEPS, RIDGE) > STEP_BAR:
            share = min(4.0 * share, MOST)
            continue
        share = max(0.5 * share, LEAST)
        for k in range(size):
            work.P[k] = near.P[k]
        residual = residual_of(work, n, sizes)
        if residual < least:
            least = residual
            for k in range(size):
                best[k] = work.P[k]
            if least <= bar:
                break
    for k in range(size):
        work.P[k] = best[k]
    if FINE < least <= bar:
        # From here Newton on the problem itself may reach rounding level.
        return polish(work, n, sizes, MOST_STEPS, RIDGE)
    return residual_of(work, n, sizes)
