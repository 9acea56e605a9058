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

__all__ = ["DEPENDENT", "NULL", "RIDGE", "Mode", "Modes", "System"]

# Against singular W: moves only what the velocities do not notice.
RIDGE = 1e-9
MOST_STEPS = 12
# Rounding level: further steps gain nothing.
DEEP = 5e-16
NULL = 1e-14
# How many times the velocities W P may be before its rounding counts: beyond it an impulse that
# solves nothing could be so large that what it leaves drowns in its own rounding.
BALANCED = 1e3
# Contacts whose masses differ by less than this are much alike.
ALIKE = 1e-2
# Pivots below this, the diagonal being 1, are of dependent rows.
DEPENDENT = 1e-10

# Of a contact that carries: its index, whether P_n > f, and s (0, 0: it sticks).
Mode = tuple[int, bool, float, float]


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
        delassus, shifted, friction, floor: W, b, µ and f, of the problem.
        scale: the size of the velocities [m/s]; what is given counts where ξ begins smaller.
        diagonal, largest: of W.
        alike: whether no contact's mass is much larger than another's.
    """

    def __init__(
        self,
        delassus: np.ndarray,
        shifted: np.ndarray,
        friction: np.ndarray,
        floor: np.ndarray | None,
        scale: float = 0.0,
    ) -> None:
        self.delassus, self.shifted, self.friction = delassus, shifted, friction
        self.floor = floor
        self.scale = max(scale, *map(abs, shifted.tolist()))
        self.diagonal = diagonal = delassus.diagonal().tolist()
        self.largest = max(diagonal)
        # Where nothing moves at all, any will do.
        least = NULL * self.largest or 1.0
        self.alike = min(map(max, zip(*[iter(diagonal)] * 3, strict=True))) > ALIKE * self.largest
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
        return self.seen(impulse)[0]

    def linearized(self, impulse: np.ndarray, velocity: np.ndarray) -> tuple[float, System | None]:
        """The residual with velocities known better than W P + b, and the equations of a step.

        Args:
            impulse: (3n,) P [N s], a solution but for rounding.
            velocity: (3n,) ξ that it makes [m/s].
        """
        residual, modes = self.seen(impulse, velocity)
        if not residual < math.inf:
            return residual, None
        return residual, self._system(impulse, modes, velocity)

    def seen(
        self, impulse: np.ndarray, velocity: np.ndarray | None = None
    ) -> tuple[float, list[Mode]]:
        """The residual; of each contact that carries: index, P_n > f, and s (0, 0: it sticks)."""
        formed = velocity is None
        if velocity is None:
            velocity = self.delassus.dot(impulse) + self.shifted
        xi = velocity.tolist()
        P = impulse.tolist()
        worst, scale, most = 0.0, self.scale, BALANCED * self.scale
        modes: list[Mode] = []
        for i, (mu, floor, normal_rate, rate) in enumerate(self._contacts):
            p1, p2, pn = P[3 * i : 3 * i + 3]
            x1, x2, xn = xi[3 * i : 3 * i + 3]
            load = normal_rate * (pn - floor)
            if load != load or xn != xn:
                return math.inf, modes
            pushing = load > xn
            error = abs(xn if pushing else load)
            if error > worst:
                worst = error
            # Impulses in balance leave their own rounding where W P is formed.
            if formed and normal_rate * pn > scale:
                scale = min(normal_rate * pn, most)
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

    def polish(
        self, impulse: np.ndarray, most: int = MOST_STEPS, ridge: float = RIDGE
    ) -> tuple[np.ndarray, float]:
        """P and its residual, from one nearby. The best found where Newton does not get there.

        Args:
            impulse: (3n,) where to begin [N s].
            most: steps.
            ridge: relative; 0 where W is known to be regular and every row to move something.
        """
        best, least = impulse, math.inf
        for step in range(most + 1):
            residual, modes = self.seen(impulse)
            if not residual < math.inf:
                break
            if residual < least:
                best, least = impulse, residual
                if least < DEEP:
                    break
            elif least < 1e-11:
                break
            if step < most:
                impulse = self._stepped(impulse, modes, ridge)
        return best, least

    def _system(
        self, impulse: np.ndarray, modes: list[Mode], velocity: np.ndarray | None = None
    ) -> System:
        """The equations of a Newton step on the modes seen."""
        size = len(impulse)
        start = [0.0] * size
        P = impulse.tolist()
        # Of each unknown a row: the direction of P, and the velocity that it must bring to 0.
        way = np.zeros((size, size))
        entries = way.reshape(-1)
        turning: list[tuple[int, int, float, float, float]] = []
        pressed: list[int] = []
        m = 0
        for i, pushing, s1, s2 in modes:
            mu, floor, _, _ = self._contacts[i]
            at = 3 * i
            pn = (P[at + 2] if P[at + 2] > floor else floor) if pushing else floor
            start[at + 2] = pn
            # Where the entries of this contact's rows begin.
            first = m * size + at
            if not mu:
                if pushing:
                    entries[first + 2] = 1.0
                    m += 1
            elif s1 or s2:
                start[at], start[at + 1] = -mu * pn * s1, -mu * pn * s2
                if pushing:
                    entries[first], entries[first + 1] = -mu * s1, -mu * s2
                    entries[first + 2] = 1.0
                    pressed.append(first)
                    first += size
                    m += 1
                entries[first], entries[first + 1] = s2, -s1
                turning.append((at, m, s1, s2, mu * pn))
                m += 1
            else:
                start[at], start[at + 1] = P[at], P[at + 1]
                entries[first] = entries[first + size + 1] = 1.0
                m += 2
                if pushing:
                    entries[first + 2 * size + 2] = 1.0
                    m += 1
        way = way[:m]
        aim = way
        if pressed:
            aim = way.copy()
            entries = aim.reshape(-1)
            for first in pressed:
                entries[first] = entries[first + 1] = 0.0
        found = np.array(start)
        if velocity is None:
            xi = self.delassus.dot(found) + self.shifted
        else:
            xi = velocity + self.delassus.dot(found - impulse)
        stiffness = np.zeros(m)
        for at, column, s1, s2, bound in turning:
            # As s turns, so does what is across it.
            along = s1 * xi[at].item() + s2 * xi[at + 1].item()
            if bound > 0.0 and along > 0.0:
                stiffness[column] = along / bound
        return System(found, way.T, aim.T, stiffness, aim.dot(xi), turning)

    def _stepped(self, impulse: np.ndarray, modes: list[Mode], ridge: float) -> np.ndarray:
        """P after one Newton step on the modes seen."""
        found, way, aim, stiffness, right, turning = self._system(impulse, modes)
        m = len(right)
        if not m:
            return found
        # Made transposed, which is the order that LAPACK reads; W is symmetric.
        matrix = way.T.dot(self.delassus.dot(aim))
        diagonal = matrix.reshape(-1)[:: m + 1]
        if ridge:
            if self.alike:
                diagonal += ridge * self.largest
            else:
                # Each unknown its own: beside a gram's contact a tonne's must not drown.
                sizes = np.abs(diagonal)
                diagonal += ridge * np.where(sizes > NULL * self.largest, sizes, self.largest)
        diagonal += stiffness
        _, _, change, failed = lapack.dgesv(matrix.T, right, overwrite_a=1)
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
