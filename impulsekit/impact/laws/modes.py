"""Newton on the modes of contacts: parting, sticking, sliding.

The natural map of Coulomb's law (Alart & Curnier 1991): P_n − f = max(0, P_n − f − ρ ξ_n),
P_t = proj(P_t − ρ ξ_t) onto |P_t| ≤ µ P_n. Its branches are the modes. A sticking contact
has three unknowns, a sliding one two, P_n and the direction s of slip: P_t = −µ P_n s,
s⊥·ξ_t = 0. Newton on these, modes seen anew at each step, until none changes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .. import lapack

__all__ = ["Modes", "System", "unique_contacts"]

# Against singular W: moves only what the velocities do not notice.
RIDGE = 1e-9
MOST_STEPS = 12
# Rounding level: further steps gain nothing.
DEEP = 5e-16
NULL = 1e-14
# Contacts whose masses differ by less than this are much alike.
ALIKE = 1e-2
DEPENDENT = 1e-10


class System(NamedTuple):
    """The equations of a Newton step: (Aimᵀ W Way + stiffness) x = right, P = found − Way x.

    Attributes:
        found: (3n,) P brought onto its modes [N s].
        way: (3n, m) the directions of P.
        aim: (3n, m) the velocities to be brought to zero.
        stiffness: (m,) of the slip's direction, on the diagonal.
        right: (m,) what these velocities are [m/s].
        turning: of each sliding contact its row, column, s and µ P_n.
    """

    found: np.ndarray
    way: np.ndarray
    aim: np.ndarray
    stiffness: np.ndarray
    right: np.ndarray
    turning: list[tuple[int, int, float, float, float]]


class Modes:
    """A frictional problem, its residual, and Newton on it.

    Attributes:
        scale: the size of the velocities [m/s].
    """

    def __init__(
        self,
        delassus: np.ndarray,
        shifted: np.ndarray,
        friction: np.ndarray,
        floor: np.ndarray | None,
    ) -> None:
        self.delassus, self.shifted, self.friction = delassus, shifted, friction
        self.floor = floor
        self.scale = float(np.abs(shifted).max())
        diagonal = delassus.diagonal().tolist()
        self.largest = max(diagonal)
        least = NULL * self.largest
        self._alike = min(map(max, zip(*[iter(diagonal)] * 3, strict=True))) > ALIKE * self.largest
        floors = [0.0] * len(friction) if floor is None else floor.tolist()
        # By contact: µ, f, 1/ρ of the normal and of the tangents [1/kg]; rows that move
        # nothing get any.
        self._contacts = [
            (
                mu,
                f,
                max(diagonal[3 * i + 2], least),
                max(diagonal[3 * i] + diagonal[3 * i + 1], least),
            )
            for i, (mu, f) in enumerate(zip(friction.tolist(), floors, strict=True))
        ]

    def residual(self, impulse: np.ndarray) -> float:
        """The natural map's distance from its fixed point, relative to the velocities."""
        return self._seen(impulse)[0]

    def linearized(self, impulse: np.ndarray, velocity: np.ndarray) -> tuple[float, System | None]:
        """The residual with velocities known better than W P + b, and the equations of a step.

        Args:
            impulse: (3n,) P [N s], a solution but for rounding.
            velocity: (3n,) ξ that it makes [m/s].
        """
        residual, modes = self._seen(impulse, velocity)
        if not residual < math.inf:
            return residual, None
        return residual, self._system(impulse, modes, velocity)

    def _seen(
        self, impulse: np.ndarray, velocity: np.ndarray | None = None
    ) -> tuple[float, list[tuple[int, bool, float, float]]]:
        """The residual; of each contact that carries: index, P_n > f, and s (0, 0: it sticks)."""
        formed = velocity is None
        if velocity is None:
            velocity = self.delassus.dot(impulse) + self.shifted
        xi = velocity.tolist()
        P = impulse.tolist()
        worst, scale = 0.0, self.scale
        modes = []
        for i, (mu, floor, normal_rate, rate) in enumerate(self._contacts):
            p1, p2, pn = P[3 * i : 3 * i + 3]
            x1, x2, xn = xi[3 * i : 3 * i + 3]
            load = normal_rate * (pn - floor)
            pushing = load > xn
            error = abs(xn if pushing else load)
            if error > worst:
                worst = error
            # Impulses in balance leave their own rounding where W P is formed.
            if formed and normal_rate * pn > scale:
                scale = normal_rate * pn
            if not pushing and not floor:
                error = rate * (abs(p1) + abs(p2))
                if error > worst:
                    worst = error
                continue
            q1, q2 = p1 - x1 / rate, p2 - x2 / rate
            size = math.sqrt(q1 * q1 + q2 * q2)
            bound = mu * pn if pn > 0.0 else 0.0
            if size > bound:
                q1, q2 = q1 / size, q2 / size
                modes.append((i, pushing, -q1, -q2))
                error = rate * math.hypot(p1 - bound * q1, p2 - bound * q2)
            else:
                modes.append((i, pushing, 0.0, 0.0))
                error = math.sqrt(x1 * x1 + x2 * x2)
            if error > worst:
                worst = error
            elif error != error:
                return math.inf, modes
        return (worst / scale if scale else 0.0), modes

    def polish(self, impulse: np.ndarray) -> tuple[np.ndarray, float]:
        """P and its residual, from one nearby. The best found where Newton does not get there."""
        best, least = impulse, math.inf
        for step in range(MOST_STEPS + 1):
            residual, modes = self._seen(impulse)
            if not residual < math.inf:
                break
            if residual < least:
                best, least = impulse, residual
                if least < DEEP:
                    break
            elif least < 1e-11:
                break
            if step < MOST_STEPS:
                impulse = self._stepped(impulse, modes)
        return best, least

    def _system(
        self,
        impulse: np.ndarray,
        modes: list[tuple[int, bool, float, float]],
        velocity: np.ndarray | None = None,
    ) -> System:
        """The equations of a Newton step on the modes seen."""
        start = [0.0] * len(impulse)
        P = impulse.tolist()
        # Entries (row, column, value) of the directions of P and of what they must bring to 0.
        rows: list[int] = []
        columns: list[int] = []
        ways: list[float] = []
        aims: list[float] = []
        turning: list[tuple[int, int, float, float, float]] = []
        m = 0
        for i, pushing, s1, s2 in modes:
            mu, floor, _, _ = self._contacts[i]
            at = 3 * i
            pn = (P[at + 2] if P[at + 2] > floor else floor) if pushing else floor
            start[at + 2] = pn
            if not mu:
                if pushing:
                    rows.append(at + 2)
                    columns.append(m)
                    ways.append(1.0)
                    aims.append(1.0)
                    m += 1
            elif s1 or s2:
                start[at], start[at + 1] = -mu * pn * s1, -mu * pn * s2
                if pushing:
                    rows += (at, at + 1, at + 2)
                    columns += (m, m, m)
                    ways += (-mu * s1, -mu * s2, 1.0)
                    aims += (0.0, 0.0, 1.0)
                    m += 1
                rows += (at, at + 1)
                columns += (m, m)
                ways += (s2, -s1)
                aims += (s2, -s1)
                turning.append((at, m, s1, s2, mu * pn))
                m += 1
            else:
                start[at], start[at + 1] = P[at], P[at + 1]
                count = 3 if pushing else 2
                rows += (at, at + 1, at + 2)[:count]
                columns += (m, m + 1, m + 2)[:count]
                ways += (1.0, 1.0, 1.0)[:count]
                aims += (1.0, 1.0, 1.0)[:count]
                m += count
        found = np.array(start)
        if velocity is None:
            xi = self.delassus.dot(found) + self.shifted
        else:
            xi = velocity + self.delassus.dot(found - impulse)
        where = (rows, columns)
        way = np.zeros((len(start), m))
        way[where] = ways
        aim = np.zeros((len(start), m))
        aim[where] = aims
        stiffness = np.zeros(m)
        for at, column, s1, s2, bound in turning:
            # As s turns, so does what is across it.
            along = s1 * xi[at] + s2 * xi[at + 1]
            if bound > 0.0 and along > 0.0:
                stiffness[column] = along / bound
        return System(found, way, aim, stiffness, aim.T.dot(xi), turning)

    def _stepped(
        self, impulse: np.ndarray, modes: list[tuple[int, bool, float, float]]
    ) -> np.ndarray:
        """P after one Newton step on the modes seen."""
        found, way, aim, stiffness, right, turning = self._system(impulse, modes)
        m = len(right)
        if not m:
            return found
        matrix = aim.T.dot(self.delassus.dot(way))
        diagonal = matrix.ravel()[:: m + 1]
        if self._alike:
            diagonal += stiffness + RIDGE * self.largest
        else:
            # Each unknown its own ridge: beside a gram's contact a tonne's must not drown.
            sizes = np.abs(diagonal)
            sizes = np.where(sizes > NULL * self.largest, sizes, self.largest)
            diagonal += stiffness + RIDGE * sizes
        _, _, change, failed = lapack.dgesv(matrix, right)
        if failed:
            return np.full_like(impulse, np.nan)
        found -= way.dot(change)
        for at, _, s1, s2, bound in turning:
            # Back onto the edge of the cone, in the direction that s has turned to.
            mu, floor, _, _ = self._contacts[at // 3]
            across = s2 * found[at] - s1 * found[at + 1]
            turn = math.atan(across / bound) if bound > 0.0 else 0.0
            c, s = mu * math.cos(turn), mu * math.sin(turn)
            pn = max(floor, found[at + 2])
            found[at], found[at + 1] = pn * (s * s2 - c * s1), -pn * (c * s2 + s * s1)
        return found


def unique_contacts(modes: Modes, impulse: np.ndarray) -> np.ndarray | None:
    """(n,) whether the impulse of each contact is determined within its mode; None if all are.

    Sticking leaves three entries free, sliding the normal one; what moves no velocity
    among these can be added or taken away.
    """
    P = impulse.reshape(-1, 3)
    mu = modes.friction
    contacts = np.flatnonzero(P[:, 2] > 1e-13 * P[:, 2].max())
    size = np.sqrt(P[:, 0] ** 2 + P[:, 1] ** 2)
    on_edge = size > mu * P[:, 2] * (1.0 - 1e-9)
    n = len(P)
    columns: list[int] = []
    owner: list[int] = []
    diagonal = modes.delassus.diagonal()
    directions = np.zeros((3 * n, 3 * len(contacts)))
    for i in contacts.tolist():
        if on_edge[i]:
            column = len(columns)
            columns.append(column)
            owner.append(i)
            directions[3 * i : 3 * i + 3, column] = P[i] / P[i, 2]
        else:
            for row in range(3 * i, 3 * i + 3):
                if diagonal[row] > NULL * modes.largest:
                    directions[row, len(columns)] = 1.0
                    columns.append(len(columns))
                    owner.append(i)
    B = directions[:, : len(columns)]
    reduced = B.T @ modes.delassus @ B
    scale = 1.0 / np.sqrt(np.maximum(reduced.diagonal(), NULL * modes.largest))
    reduced = reduced * scale * scale[:, None]
    _, _, rank, failed = lapack.dpstrf(reduced, tol=DEPENDENT, lower=1)
    if not failed and rank == len(columns):
        return None
    values, vectors = np.linalg.eigh(reduced)
    null = vectors[:, values <= DEPENDENT * values[-1]]
    part = (null**2).sum(axis=1) > 1e-9
    if not part.any():
        return None
    unique = np.ones(n, dtype=bool)
    unique[np.array(owner)[part]] = False
    return unique
