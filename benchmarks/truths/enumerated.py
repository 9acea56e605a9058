"""Contacts of bodies in a plane: all v⁺ that Newton's or Poisson's law allows, in fractions.

Each of n contacts parts, sticks, or slides one way or the other: 4ⁿ systems of linear equations.
In Poisson's release a contact holds more than it has to give back, or just that; either way it
sticks or slides: 6ⁿ. Doubles rule out what is far from obeying the law; the rest is solved by
elimination without rounding. A system that is singular is left out: where it has solutions, the
load is shared, and the extreme shares, with a contact unloaded or on the edge of its cone,
belong to other modes, as inequalities are closed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

STICKS, UP, DOWN, FREE = range(4)
Row = list[Fraction]
Mode = tuple[bool, int]
"""Whether a contact is loaded by no more than its floor, and what it does along its line."""

# Modes of larger condition, or off the law by less than FAR of all speeds, are left to fractions.
BADLY_CONDITIONED, FAR = 1e8, 1e-5


@dataclass(frozen=True, eq=False)
class PlaneProblem:
    """Contacts between bodies in a plane.

    Attributes:
        rows: (2n, nv) tangent and normal of each contact.
        inverse_masses: (nv,) the diagonal of M⁻¹.
        before: (nv,) v⁻.
        friction, restitution: (n,).
        terms: (2n, nv) the size of the terms that each row adds up, where they cancel; the rows'
            own size where they do not.
    """

    rows: Sequence[Sequence[float]]
    inverse_masses: Sequence[float]
    before: Sequence[float]
    friction: Sequence[float]
    restitution: Sequence[float]
    terms: Sequence[Sequence[float]] | None = None


@dataclass(frozen=True, eq=False)
class After:
    """One v⁺ that a law allows.

    Attributes:
        velocity: (nv,).
        gains: whether kinetic energy grows.
        slack: (nv,) by how much relative changes of size 1 of the data move it, to first order.
    """

    velocity: np.ndarray
    gains: bool
    slack: np.ndarray


@dataclass(frozen=True, eq=False)
class _Answer:
    """P of one mode, and its slack."""

    P: Row
    slack: np.ndarray


class _Data:
    """The Delassus matrix of a problem, exactly and in doubles, and the size of its terms."""

    def __init__(self, problem: PlaneProblem) -> None:
        self.rows = [[Fraction(x) for x in row] for row in problem.rows]
        self.inverse = [Fraction(x) for x in problem.inverse_masses]
        self.v = [Fraction(x) for x in problem.before]
        self.mu = [Fraction(x) for x in problem.friction]
        self.u = [_dot(row, self.v) for row in self.rows]
        moved = [[a * m for a, m in zip(row, self.inverse, strict=True)] for row in self.rows]
        self.W = [[_dot(one, other) for other in self.rows] for one in moved]
        rows = np.abs(np.array(problem.rows, dtype=float))
        terms = rows if problem.terms is None else np.array(problem.terms, dtype=float)
        inverse = np.array(problem.inverse_masses, dtype=float)
        self.moved, self.terms_moved = rows * inverse, terms * inverse
        self.W_doubles = np.array(self.W, dtype=float)
        half = 1.5 * self.moved @ terms.T
        self.W_size = half + half.T
        self.u_size = 2.0 * terms @ np.abs(np.array(problem.before, dtype=float))


def whole_answers(problem: PlaneProblem, restitution: str) -> list[After]:
    """All v⁺ that differ.

    Args:
        problem: the contacts.
        restitution: "newton" or "poisson".
    """
    data = _Data(problem)
    none = [Fraction(0)] * len(data.mu)
    e = [Fraction(x) for x in problem.restitution]
    answers: list[_Answer] = []
    if restitution == "newton":
        b = list(data.u)
        for i, share in enumerate(e):
            b[2 * i + 1] += share * min(b[2 * i + 1], Fraction(0))
        answers = _coulomb(data, b, 2.0 * data.u_size, none, np.zeros(len(e)))
    else:
        for pressed in _coulomb(data, data.u, data.u_size, none, np.zeros(len(e))):
            if not any(e):
                answers.append(pressed)
                continue
            b = [x + _dot(row, pressed.P) for x, row in zip(data.u, data.W, strict=True)]
            size = data.u_size + data.W_size @ np.abs(_doubles(pressed.P))
            size += np.abs(data.W_doubles) @ pressed.slack
            floor = [share * P for share, P in zip(e, pressed.P[1::2], strict=True)]
            floor_slack = np.array(problem.restitution, dtype=float) * pressed.slack[1::2]
            answers += [
                _Answer([p + q for p, q in zip(pressed.P, back.P, strict=True)],
                        pressed.slack + back.slack)
                for back in _coulomb(data, b, size, floor, floor_slack)
            ]  # fmt: skip
    return _that_differ(data, answers)


def _that_differ(data: _Data, answers: list[_Answer]) -> list[After]:
    found: dict[tuple[Fraction, ...], After] = {}
    for answer in answers:
        P = answer.P
        after = tuple(
            speed + m * sum((p * row[k] for p, row in zip(P, data.rows, strict=True)), Fraction(0))
            for k, (speed, m) in enumerate(zip(data.v, data.inverse, strict=True))
        )
        slack = data.moved.T @ answer.slack + 3.0 * data.terms_moved.T @ np.abs(_doubles(P))
        slack += np.abs(_doubles(data.v))
        # Where two modes meet, the one of least slack tells how well it is determined.
        if after in found and slack.max() >= found[after].slack.max():
            continue
        gain = sum(p * (2 * u + _dot(row, P)) for p, u, row in zip(P, data.u, data.W, strict=True))
        found[after] = After(_doubles(after), gain > 0, slack)
    return list(found.values())


def _coulomb(
    data: _Data, b: Row, b_size: np.ndarray, floor: Row, floor_slack: np.ndarray
) -> list[_Answer]:
    """All P with 0 ≤ P_n − floor ⊥ ξ_n ≥ 0 and Coulomb's law along each line, ξ = b + W P."""
    modes = list(itertools.product(*(_modes(m, f) for m, f in zip(data.mu, floor, strict=True))))
    matrices, right, likely = _in_doubles(data, modes, b, floor)
    found = []
    for k in np.flatnonzero(likely):
        P = _impulse(data, b, modes[k], floor)
        if P is None or not _obeys(data, b, modes[k], floor, P):
            continue
        size = b_size + data.W_size @ np.abs(_doubles(P))
        for i, (held, slip) in enumerate(modes[k]):
            if held:
                size[2 * i + 1] = floor_slack[i] + abs(right[k, 2 * i + 1])
            if slip in (UP, DOWN, FREE):
                size[2 * i] = 2.0 * float(data.mu[i]) * abs(float(P[2 * i + 1]))
        found.append(_Answer(P, np.abs(np.linalg.pinv(matrices[k])) @ size))
    return found


def _modes(mu: Fraction, floor: Fraction) -> tuple[Mode, ...]:
    ways = (STICKS, UP, DOWN) if mu else (FREE,)
    held = ways if floor else (FREE,)
    return tuple((True, way) for way in held) + tuple((False, way) for way in ways)


def _in_doubles(
    data: _Data, modes: Sequence[Sequence[Mode]], b: Row, floor: Row
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Equations (m, 2n, 2n), (m, 2n) of all modes, and which may be answers."""
    W, speeds = data.W_doubles, _doubles(b)
    mu, least = _doubles(data.mu), _doubles(floor)
    held = np.array([[one[0] for one in mode] for mode in modes])
    slip = np.array([[one[1] for one in mode] for mode in modes])
    matrices = np.tile(W, (len(modes), 1, 1))
    right = np.tile(-speeds, (len(modes), 1))
    for i in range(len(mu)):
        t, n = 2 * i, 2 * i + 1
        rubs = slip[:, i] != STICKS
        matrices[rubs, t], right[rubs, t] = 0.0, 0.0
        matrices[rubs, t, t] = 1.0
        matrices[rubs, t, n] = np.select([slip[rubs, i] == UP, slip[rubs, i] == DOWN],
                                         [mu[i], -mu[i]], 0.0)  # fmt: skip
        down = held[:, i]
        matrices[down, n], right[down, n] = 0.0, least[i]
        matrices[down, n, n] = 1.0
    # Impulses in units that make W's diagonal one.
    unit = 1.0 / np.sqrt(W.diagonal())
    scaled = matrices * unit
    scaled = scaled / np.abs(scaled).max(axis=2, keepdims=True)
    values = np.linalg.svd(scaled, compute_uv=False)
    unsure = values[:, 0] > BADLY_CONDITIONED * values[:, -1]
    likely = unsure.copy()
    sure = np.flatnonzero(~unsure)
    P = np.linalg.solve(matrices[sure], right[sure, :, None])[:, :, 0]
    xi = P @ W.T + speeds
    off = np.zeros(len(sure))
    scale = np.abs(speeds).max() + np.abs(P * W.diagonal()).max(axis=1)
    for i in range(len(mu)):
        t, n = 2 * i, 2 * i + 1
        way = slip[sure, i]
        off = np.maximum(off, np.where(held[sure, i], -xi[:, n], (least[i] - P[:, n]) * W[n, n]))
        beyond = (np.abs(P[:, t]) - mu[i] * P[:, n]) * W[t, t]
        across = np.select([way == STICKS, way == UP, way == DOWN], [beyond, -xi[:, t], xi[:, t]])
        off = np.maximum(off, across)
    likely[sure] = off <= FAR * scale
    return matrices, right, likely


def _impulse(data: _Data, b: Row, modes: Sequence[Mode], floor: Row) -> Row | None:
    """P of these modes; None where the equations are singular."""
    size = len(b)
    matrix: list[Row] = []
    for i, (held, slip) in enumerate(modes):
        t, n = 2 * i, 2 * i + 1
        tangent, normal = [Fraction(0)] * (size + 1), [Fraction(0)] * (size + 1)
        if slip == STICKS:
            tangent[:] = [*data.W[t], -b[t]]
        else:
            tangent[t] = Fraction(1)
            tangent[n] = {UP: data.mu[i], DOWN: -data.mu[i], FREE: Fraction(0)}[slip]
        if held:
            normal[n], normal[size] = Fraction(1), floor[i]
        else:
            normal[:] = [*data.W[n], -b[n]]
        matrix += [tangent, normal]
    return _solved(matrix)


def _solved(matrix: Sequence[Row]) -> Row | None:
    """x of A x = b from the rows of (A, b), by elimination in integers; None where A is singular.

    Whatever is divided leaves no rest (Bareiss, E. H. (1968), "Sylvester's identity and multistep
    integer-preserving Gaussian elimination").
    """
    size = len(matrix)
    whole = [_whole(row) for row in matrix]
    head = 1
    for k in range(size):
        pivot = next((r for r in range(k, size) if whole[r][k]), None)
        if pivot is None:
            return None
        whole[k], whole[pivot] = whole[pivot], whole[k]
        row, before, head = whole[k], head, whole[k][k]
        for r in range(size):
            if r != k:
                other = whole[r]
                share = other[k]
                whole[r] = [
                    (head * x - share * y) // before for x, y in zip(other, row, strict=True)
                ]
    return [Fraction(row[size], head) for row in whole]


def _whole(row: Row) -> list[int]:
    """The numbers of a row times their least common denominator."""
    scale = math.lcm(*(x.denominator for x in row))
    return [x.numerator * (scale // x.denominator) for x in row]


def _obeys(data: _Data, b: Row, modes: Sequence[Mode], floor: Row, P: Row) -> bool:
    """Whether P obeys the inequalities of its modes."""
    for i, (held, way) in enumerate(modes):
        t, n = 2 * i, 2 * i + 1
        if held and _dot(data.W[n], P) + b[n] < 0:
            return False
        if P[n] < floor[i]:
            return False
        if way == STICKS and abs(P[t]) > data.mu[i] * P[n]:
            return False
        slip = _dot(data.W[t], P) + b[t]
        if (way == UP and slip < 0) or (way == DOWN and slip > 0):
            return False
    return True


def _doubles(values: Sequence[Fraction]) -> np.ndarray:
    return np.array([float(x) for x in values])


def _dot(one: Sequence[Fraction], other: Sequence[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(one, other, strict=True)), Fraction(0))
