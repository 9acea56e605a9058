"""Newton on the modes of several contacts: parts, sticks or slides (``impact.laws.modes``)."""

from __future__ import annotations

import math

import numpy as np

from .dense import gauss
from .jit import built_in

__all__ = ["residual_of", "stepped"]

RIDGE = 1e-9


@built_in
def residual_of(W, b, mu, n, scale, least, P, xi, mode, slip):
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
def stepped(W, b, mu, n, largest, P, xi, mode, slip, way, aim, matrix, x, moved):
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
