"""Several contacts of one state, as ``impact.laws`` solves them, for kernels.

Without friction the contacts that push are found by swapping all wrong ones at once. With
friction a few rounds of projection come near, and Newton on the modes of the contacts
(``impact.laws.modes``) goes to rounding level. The bars are those of the solver of
single states, to which the code AGAIN leaves what fails here.
"""

from __future__ import annotations

import math

import numpy as np

from ..codes import AGAIN, RowStatus
from .coulomb import coulomb
from .dense import cholesky, eliminate, gauss, rank_by_pivots
from .jit import built_in
from .splitting import split

__all__ = ["frictional", "frictionless"]

BAR = 1e-10
RIDGE = 1e-9
DEEP = 1e-13
NULL = 1e-14
# Residuals of rounding; what stays above is left to the solver of single states, which refines.
FINE = 4e-15
# So are contacts of which one is this much more mobile than another.
ALIKE = 1e-3
AT_REST = 1e-12
# Rounds of sweeps (above 0) and of splitting (below).
SWEEPS = (3, 10, 30, -100, -200, -400, -800, 200)
ROUNDS = len(SWEEPS)
_SOLVED, _NOT_UNIQUE = int(RowStatus.SOLVED), int(RowStatus.NOT_UNIQUE)


@built_in
def frictionless(W, b, n, scale, dependent, P):
    """P (3n,) of n contacts that only push; the code."""
    tiny = AT_REST * scale
    pushing = np.zeros(n, dtype=np.bool_)
    wrong = np.zeros(n, dtype=np.bool_)
    approaching = False
    for k in range(3 * n):
        P[k] = 0.0
    for i in range(n):
        pushing[i] = b[3 * i + 2] < -tiny
        approaching = approaching or pushing[i]
    if not approaching:
        for i in range(n):
            if b[3 * i + 2] < -FINE * scale:
                return AGAIN
        return _SOLVED
    lightest, heaviest = 0.0, math.inf
    for i in range(n):
        lightest = max(lightest, W[3 * i + 2, 3 * i + 2])
        heaviest = min(heaviest, W[3 * i + 2, 3 * i + 2])
    if heaviest < ALIKE * lightest:
        return AGAIN
    block, lower = np.empty((n, n)), np.empty((n, n))
    x = np.empty(n)
    chosen = np.empty(n, dtype=np.int64)
    fewest = n + 1
    for _ in range(10):
        m = np.int64(0)
        for i in range(n):
            if pushing[i]:
                chosen[m] = i
                m += 1
        for i in range(m):
            for j in range(m):
                block[i, j] = W[3 * chosen[i] + 2, 3 * chosen[j] + 2]
            x[i] = -b[3 * chosen[i] + 2]
        if not cholesky(block, m, lower) > dependent:
            return AGAIN
        eliminate(lower, m, x)
        for i in range(n):
            P[3 * i + 2] = 0.0
        for i in range(m):
            P[3 * chosen[i] + 2] = x[i]
        number = 0
        slowest = math.inf
        for i in range(n):
            if pushing[i]:
                wrong[i] = P[3 * i + 2] < 0.0
            else:
                u = b[3 * i + 2]
                for j in range(m):
                    u += W[3 * i + 2, 3 * chosen[j] + 2] * x[j]
                wrong[i] = u < -tiny
                slowest = min(slowest, u)
            number += wrong[i]
        if number == 0:
            return _SOLVED if slowest > tiny else AGAIN
        if number >= fewest:
            return AGAIN
        fewest = number
        for i in range(n):
            pushing[i] = pushing[i] != wrong[i]
    return AGAIN


@built_in
def _seen(W, b, mu, n, scale, least, P, xi, mode, slip):
    """The residual of the natural map; mode (0 parts, 1 sticks, 2 slides) and slip of each."""
    worst = 0.0
    size = scale
    for k in range(3 * n):
        total = b[k]
        for j in range(3 * n):
            total += W[k, j] * P[j]
        xi[k] = total
    for i in range(n):
        k = 3 * i
        normal_rate = max(W[k + 2, k + 2], least)
        rate = max(W[k, k] + W[k + 1, k + 1], least)
        load = normal_rate * P[k + 2]
        pushing = load > xi[k + 2]
        worst = max(worst, abs(xi[k + 2] if pushing else load))
        size = max(size, load)
        if not pushing:
            mode[i] = 0
            worst = max(worst, rate * (abs(P[k]) + abs(P[k + 1])))
            continue
        q1, q2 = P[k] - xi[k] / rate, P[k + 1] - xi[k + 1] / rate
        length = math.sqrt(q1 * q1 + q2 * q2)
        bound = mu[i] * P[k + 2] if P[k + 2] > 0.0 else 0.0
        if length > bound:
            q1, q2 = q1 / length, q2 / length
            mode[i] = 2
            slip[i, 0], slip[i, 1] = -q1, -q2
            d1, d2 = P[k] - bound * q1, P[k + 1] - bound * q2
            worst = max(worst, rate * math.sqrt(d1 * d1 + d2 * d2))
        else:
            mode[i] = 1
            worst = max(worst, math.sqrt(xi[k] * xi[k] + xi[k + 1] * xi[k + 1]))
        if worst != worst:
            return math.inf
    return worst / size if size > 0.0 else 0.0


@built_in
def _stepped(W, b, mu, n, largest, P, xi, mode, slip, way, aim, matrix, x, moved):
    """One Newton step on the modes; False where the system is singular."""
    size = 3 * n
    m = np.int64(0)
    for k in range(size):
        for j in range(size):
            way[k, j] = 0.0
            aim[k, j] = 0.0
    for i in range(n):
        k = 3 * i
        if mode[i] == 0:
            P[k], P[k + 1], P[k + 2] = 0.0, 0.0, 0.0
            continue
        pn = max(P[k + 2], 0.0)
        P[k + 2] = pn
        if mu[i] == 0.0:
            P[k], P[k + 1] = 0.0, 0.0
            way[m, k + 2] = 1.0
            aim[m, k + 2] = 1.0
            m += 1
        elif mode[i] == 2:
            s1, s2 = slip[i, 0], slip[i, 1]
            P[k], P[k + 1] = -mu[i] * pn * s1, -mu[i] * pn * s2
            way[m, k], way[m, k + 1], way[m, k + 2] = -mu[i] * s1, -mu[i] * s2, 1.0
            aim[m, k + 2] = 1.0
            way[m + 1, k], way[m + 1, k + 1] = s2, -s1
            aim[m + 1, k], aim[m + 1, k + 1] = s2, -s1
            m += 2
        else:
            for j in range(3):
                way[m + j, k + j] = 1.0
                aim[m + j, k + j] = 1.0
            m += 3
    if m == 0:
        return True
    for k in range(size):
        total = b[k]
        for j in range(size):
            total += W[k, j] * P[j]
        xi[k] = total
    for c in range(m):
        # W times the way, whose few entries belong to one contact.
        for k in range(size):
            moved[k] = 0.0
        for j in range(size):
            if way[c, j] != 0.0:
                for k in range(size):
                    moved[k] += W[k, j] * way[c, j]
        for r in range(m):
            total = 0.0
            for k in range(size):
                if aim[r, k] != 0.0:
                    total += aim[r, k] * moved[k]
            matrix[r, c] = total
    for r in range(m):
        total = 0.0
        for k in range(size):
            if aim[r, k] != 0.0:
                total += aim[r, k] * xi[k]
        x[r] = total
        matrix[r, r] += RIDGE * largest
    c = 0
    for i in range(n):
        if mode[i] == 0:
            continue
        if mu[i] == 0.0:
            c += 1
        elif mode[i] == 2:
            bound = mu[i] * P[3 * i + 2]
            along = slip[i, 0] * xi[3 * i] + slip[i, 1] * xi[3 * i + 1]
            if bound > 0.0 and along > 0.0:
                matrix[c + 1, c + 1] += along / bound
            c += 2
        else:
            c += 3
    if not gauss(matrix, m, x):
        return False
    bounds = moved
    for i in range(n):
        bounds[i] = mu[i] * P[3 * i + 2]
    for c in range(m):
        for k in range(size):
            if way[c, k] != 0.0:
                P[k] -= way[c, k] * x[c]
    for i in range(n):
        if mode[i] == 2 and mu[i] > 0.0:
            k = 3 * i
            s1, s2 = slip[i, 0], slip[i, 1]
            across = s2 * P[k] - s1 * P[k + 1]
            turn = math.atan(across / bounds[i]) if bounds[i] > 0.0 else 0.0
            cosine, sine = mu[i] * math.cos(turn), mu[i] * math.sin(turn)
            pn = max(0.0, P[k + 2])
            P[k] = pn * (sine * s2 - cosine * s1)
            P[k + 1] = -pn * (cosine * s2 + sine * s1)
    return True


@built_in
def _swept(W, b, mu, n, scale, P, sweeps, found, roots):
    """Contact after contact in closed form; one that needs a second look keeps what it has."""
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
            p1, p2, pn, code = coulomb(
                W[k, k], W[k, k + 1], W[k + 1, k + 1], W[k, k + 2], W[k + 1, k + 2],
                W[k + 2, k + 2], u1, u2, un, mu[i], scale, found, roots,
            )  # fmt: skip
            if code == AGAIN and not pn > 0.0:
                continue
            largest = max(largest, W[k + 2, k + 2] * abs(pn - P[k + 2]))
            P[k], P[k + 1], P[k + 2] = p1, p2, pn
        if largest <= 1e-13 * scale:
            return


@built_in
def _is_redundant(W, mu, n, dependent, largest, P, matrix, way):
    """Whether load can be shifted between contacts without moving anything."""
    size = 3 * n
    most = 0.0
    for i in range(n):
        most = max(most, P[3 * i + 2])
    m = np.int64(0)
    for i in range(n):
        k = 3 * i
        if not P[k + 2] > 1e-13 * most:
            continue
        if math.sqrt(P[k] ** 2 + P[k + 1] ** 2) > mu[i] * P[k + 2] * (1.0 - 1e-9):
            for j in range(size):
                way[m, j] = 0.0
            for j in range(k, k + 3):
                way[m, j] = P[j] / P[k + 2]
            m += 1
        else:
            for row in range(k, k + 3):
                if W[row, row] > NULL * largest:
                    for j in range(size):
                        way[m, j] = 0.0
                    way[m, row] = 1.0
                    m += 1
    for r in range(m):
        for c in range(r + 1):
            total = 0.0
            for k in range(size):
                if way[r, k] != 0.0:
                    for j in range(size):
                        if way[c, j] != 0.0:
                            total += way[r, k] * W[k, j] * way[c, j]
            matrix[r, c] = total
            matrix[c, r] = total
    for r in range(m):
        way[0, r] = 1.0 / math.sqrt(max(matrix[r, r], NULL * largest))
    for r in range(m):
        for c in range(m):
            matrix[r, c] *= way[0, r] * way[0, c]
    return rank_by_pivots(matrix, m, dependent) < m


@built_in
def frictional(
    W, b, mu, n, dependent, P, best, xi, mode, slip, way, aim, matrix, x, moved,
    split_y, split_z, found, roots,
):  # fmt: skip
    """P (3n,) of n contacts with friction; the code. W and b of smooth tangents are cleared."""
    size = 3 * n
    for i in range(n):
        if mu[i] == 0.0:
            for k in (3 * i, 3 * i + 1):
                b[k] = 0.0
                for j in range(size):
                    W[k, j] = 0.0
                    W[j, k] = 0.0
    scale = 0.0
    largest = 0.0
    slowest = math.inf
    for k in range(size):
        scale = max(scale, abs(b[k]))
        largest = max(largest, W[k, k])
        P[k] = 0.0
        if k % 3 == 2:
            slowest = min(slowest, b[k])
    if slowest >= -1e-15 * scale:
        return _SOLVED
    for i in range(n):
        if max(W[3 * i, 3 * i], W[3 * i + 1, 3 * i + 1], W[3 * i + 2, 3 * i + 2]) < ALIKE * largest:
            return AGAIN
    least = NULL * largest
    rate = 0.05 * largest
    for j in range(size):
        split_y[j], split_z[j] = 0.0, 0.0
    for k in range(ROUNDS):
        if SWEEPS[k] > 0:
            _swept(W, b, mu, n, scale, P, SWEEPS[k], found, roots)
        else:
            rate = split(W, b, mu, n, split_y, split_z, -SWEEPS[k], rate, way, aim, x, moved)
            for j in range(size):
                P[j] = split_y[j]
        for j in range(size):
            best[j] = P[j]
        bar = math.inf
        for step in range(13):
            residual = _seen(W, b, mu, n, scale, least, P, xi, mode, slip)
            if not residual < math.inf:
                break
            if residual < bar:
                last = bar < DEEP
                bar = residual
                if bar <= BAR:
                    for j in range(size):
                        best[j] = P[j]
                # Deep enough; one step more is only for the last digits.
                if last and bar <= FINE:
                    break
            elif bar < 1e-11:
                break
            if step < 12 and not _stepped(
                W, b, mu, n, largest, P, xi, mode, slip, way, aim, matrix, x, moved
            ):
                break
        for j in range(size):
            P[j] = best[j]
        if bar <= BAR:
            if bar > 10.0 * FINE:
                return AGAIN
            redundant = _is_redundant(W, mu, n, dependent, largest, P, matrix, way)
            return _NOT_UNIQUE if redundant else _SOLVED
    return AGAIN
