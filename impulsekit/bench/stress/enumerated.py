"""Contacts of bodies in a plane: all v⁺ that Newton's law allows, by exact fractions.

Each of n contacts parts, sticks, or slides one way or the other: 4ⁿ systems of linear equations,
solved by elimination without rounding. A system that is singular is left out: where it has
solutions, the load is shared, and the extreme shares, with a contact unloaded or on the edge of
its cone, belong to other modes, as inequalities are closed.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

__all__ = ["PlaneProblem", "all_after"]

PARTS, STICKS, UP, DOWN = range(4)
Row = list[Fraction]


@dataclass(frozen=True, eq=False)
class PlaneProblem:
    """Contacts between bodies in a plane.

    Attributes:
        rows: (2n, nv) tangent and normal of each contact.
        inverse_masses: (nv,) the diagonal of M⁻¹.
        before: (nv,) v⁻.
        friction, restitution: (n,).
    """

    rows: Sequence[Sequence[float]]
    inverse_masses: Sequence[float]
    before: Sequence[float]
    friction: Sequence[float]
    restitution: Sequence[float]


def all_after(problem: PlaneProblem) -> list[tuple[np.ndarray, bool]]:
    """(nv,) all v⁺ that differ, and whether each gains kinetic energy."""
    rows = [[Fraction(x) for x in row] for row in problem.rows]
    inverse = [Fraction(x) for x in problem.inverse_masses]
    v = [Fraction(x) for x in problem.before]
    mu = [Fraction(x) for x in problem.friction]
    size = len(rows)
    u = [_dot(row, v) for row in rows]
    W = [
        [sum((a * m * b for a, m, b in zip(one, inverse, other, strict=True)), Fraction(0))
         for other in rows]
        for one in rows
    ]  # fmt: skip
    b = list(u)
    for i, e in enumerate(problem.restitution):
        b[2 * i + 1] += Fraction(e) * min(u[2 * i + 1], Fraction(0))
    choices = [(PARTS, STICKS, UP, DOWN) if m else (PARTS, UP) for m in mu]
    found: list[tuple[tuple[Fraction, ...], bool]] = []
    for modes in itertools.product(*choices):
        P = _impulse(W, b, mu, modes)
        if P is None or not _obeys(W, b, mu, modes, P):
            continue
        after = tuple(
            speed + m * sum((P[r] * rows[r][k] for r in range(size)), Fraction(0))
            for k, (speed, m) in enumerate(zip(v, inverse, strict=True))
        )
        if all(after != other for other, _ in found):
            gain = sum(P[r] * (2 * u[r] + _dot(W[r], P)) for r in range(size))
            found.append((after, gain > 0))
    return [(np.array([float(x) for x in after]), gains) for after, gains in found]


def _impulse(W: list[Row], b: Row, mu: Row, modes: Sequence[int]) -> Row | None:
    """P of these modes; None where the equations are singular."""
    size = len(b)
    matrix: list[Row] = []
    for i, mode in enumerate(modes):
        t, n = 2 * i, 2 * i + 1
        tangent, normal = [Fraction(0)] * (size + 1), [Fraction(0)] * (size + 1)
        normal[:] = [*W[n], -b[n]]
        if mode == STICKS:
            tangent[:] = [*W[t], -b[t]]
        else:
            tangent[t] = Fraction(1)
            if mode == PARTS:
                normal = [Fraction(0)] * (size + 1)
                normal[n] = Fraction(1)
            else:
                tangent[n] = mu[i] if mode == UP else -mu[i]
        matrix += [tangent, normal]
    for k in range(size):
        pivot = next((r for r in range(k, size) if matrix[r][k]), None)
        if pivot is None:
            return None
        matrix[k], matrix[pivot] = matrix[pivot], matrix[k]
        head = matrix[k][k]
        matrix[k] = [x / head for x in matrix[k]]
        for r in range(size):
            share = matrix[r][k]
            if r != k and share:
                matrix[r] = [x - share * y for x, y in zip(matrix[r], matrix[k], strict=True)]
    return [row[size] for row in matrix]


def _obeys(W: list[Row], b: Row, mu: Row, modes: Sequence[int], P: Row) -> bool:
    """Whether P obeys the inequalities of its modes."""
    for i, mode in enumerate(modes):
        t, n = 2 * i, 2 * i + 1
        if mode == PARTS:
            if _dot(W[n], P) + b[n] < 0:
                return False
            continue
        if P[n] < 0:
            return False
        slip = _dot(W[t], P) + b[t]
        if mode == STICKS:
            if abs(P[t]) > mu[i] * P[n]:
                return False
        elif mu[i] and (slip < 0 if mode == UP else slip > 0):
            return False
    return True


def _dot(one: Sequence[Fraction], other: Sequence[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(one, other, strict=True)), Fraction(0))
