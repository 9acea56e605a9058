"""Newton on the modes of contacts: parting, sticking, sliding.

The natural map of Coulomb's law (Alart & Curnier 1991): P_n − f = max(0, P_n − f − ρ ξ_n),
P_t = proj(P_t − ρ ξ_t) onto |P_t| ≤ µ P_n. Its branches are the modes; on each it is
smooth, and Newton's steps go from branch to branch until none changes.
"""

from __future__ import annotations

import numpy as np

__all__ = ["Modes", "unique_contacts"]

# Against singular W: moves only what the velocities do not notice.
RIDGE = 1e-9
MOST_STEPS = 12
# A fall this deep is rounding level: further steps gain nothing.
DEEP = 1e-14
NULL = 1e-14
DEPENDENT = 1e-10


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
        diagonal = delassus.diagonal()
        self.largest = float(diagonal.max())
        masses = diagonal.reshape(-1, 3)
        # 1/ρ [1/kg]; rows that move nothing get any.
        self.normal_rate = np.maximum(masses[:, 2], NULL * self.largest)
        self.tangent_rate = np.maximum(masses[:, 0] + masses[:, 1], NULL * self.largest)

    def residual(self, impulse: np.ndarray) -> float:
        """The natural map's distance from its fixed point, relative to the velocities."""
        return self._seen(impulse)[0]

    def _seen(self, impulse: np.ndarray) -> tuple[float, np.ndarray]:
        """The residual, and (n,) which contacts push."""
        xi = (self.delassus.dot(impulse) + self.shifted).reshape(-1, 3)
        P = impulse.reshape(-1, 3)
        error = np.empty_like(xi)
        pn = P[:, 2]
        load = self.normal_rate * (pn if self.floor is None else pn - self.floor)
        pushing = load > xi[:, 2]
        error[:, 2] = np.minimum(load, xi[:, 2])
        q = P[:, :2] - xi[:, :2] / self.tangent_rate[:, None]
        size = np.sqrt(q[:, 0] * q[:, 0] + q[:, 1] * q[:, 1])
        bound = self.friction * np.maximum(pn, 0.0)
        shrink = np.minimum(1.0, bound / np.maximum(size, 1e-300))
        error[:, :2] = (P[:, :2] - q * shrink[:, None]) * self.tangent_rate[:, None]
        scale = max(self.scale, float((self.normal_rate * pn).max()))
        residual = float(np.abs(error).max()) / scale if scale else 0.0
        return residual, pushing

    def polish(self, impulse: np.ndarray) -> tuple[np.ndarray, float]:
        """P and its residual, from one nearby. The best found where Newton does not get there."""
        best, least = impulse, np.inf
        for step in range(MOST_STEPS + 1):
            residual, pushing = self._seen(impulse)
            if not residual < np.inf:
                break
            if residual < least:
                gain = residual / least
                best, least = impulse, residual
                if least < DEEP or (least < 1e-12 and gain > 0.01):
                    break
            elif least < 1e-12:
                break
            if step < MOST_STEPS:
                impulse = self._stepped(impulse, pushing)
        return best, least

    def _stepped(self, impulse: np.ndarray, pushing: np.ndarray) -> np.ndarray:
        """P after one Newton step on the modes seen."""
        from scipy.linalg.lapack import dgesv

        n = len(pushing)
        live = pushing if self.floor is None else pushing | (self.floor > 0.0)
        result = np.zeros_like(impulse)
        contacts = np.flatnonzero(live)
        if not len(contacts):
            return result
        k = len(contacts)
        whole = k == n
        rows = np.arange(3 * n) if whole else (3 * contacts[:, None] + np.arange(3)).ravel()
        matrix = self.delassus.copy() if whole else self.delassus[rows[:, None], rows]
        P = impulse.reshape(-1, 3)[contacts]
        mu, rate = self.friction[contacts], self.tangent_rate[contacts]
        # Contacts let go carry nothing from here on.
        right = matrix.dot(P.ravel()) + self.shifted[rows]
        right3 = right.reshape(-1, 3)
        aim = P[:, :2] - right3[:, :2] / rate[:, None]
        size = np.sqrt(aim[:, 0] ** 2 + aim[:, 1] ** 2)
        sliding = np.flatnonzero(size > mu * np.maximum(P[:, 2], 0.0))
        if len(sliding):
            self._slide_rows(matrix, right3, sliding, P, mu, rate, aim, size)
        if self.floor is not None:
            held = np.flatnonzero(~pushing[contacts])
            for i in held.tolist():
                matrix[3 * i + 2] = 0.0
                matrix[3 * i + 2, 3 * i + 2] = self.normal_rate[contacts[i]]
                right3[i, 2] = matrix[3 * i + 2, 3 * i + 2] * (P[i, 2] - self.floor[contacts[i]])
        matrix[np.arange(3 * k), np.arange(3 * k)] += RIDGE * self.largest
        _, _, change, failed = dgesv(matrix, right)
        if failed:
            return np.full_like(impulse, np.nan)
        found = (P.ravel() - change).reshape(-1, 3)
        least = 0.0 if self.floor is None else self.floor[contacts]
        np.maximum(found[:, 2], least, out=found[:, 2])
        result[rows] = found.ravel()
        return result

    def _slide_rows(
        self,
        matrix: np.ndarray,
        right3: np.ndarray,
        sliding: np.ndarray,
        P: np.ndarray,
        mu: np.ndarray,
        rate: np.ndarray,
        aim: np.ndarray,
        size: np.ndarray,
    ) -> None:
        """(P_t − µ P_n q/|q|)/ρ = 0, q = P_t − ρ ξ_t, in place of ξ_t = 0."""
        rate, bound = rate[sliding], mu[sliding] * np.maximum(P[sliding, 2], 0.0)
        s = aim[sliding] / size[sliding, None]
        right3[sliding, :2] = (P[sliding, :2] - bound[:, None] * s) * rate[:, None]
        # How q/|q| turns: (I − s sᵀ)/|q|.
        turn = -s[:, :, None] * s[:, None, :]
        turn[:, 0, 0] += 1.0
        turn[:, 1, 1] += 1.0
        turn *= (bound / size[sliding])[:, None, None]
        columns = matrix.shape[1]
        tangents = 3 * sliding[:, None] + np.arange(2)
        rows = turn @ matrix[tangents.ravel()].reshape(-1, 2, columns)
        fixed = np.arange(len(sliding))
        own = -turn
        own[:, 0, 0] += 1.0
        own[:, 1, 1] += 1.0
        own *= rate[:, None, None]
        for a in (0, 1):
            for c in (0, 1):
                rows[fixed, a, tangents[:, c]] += own[:, a, c]
            rows[fixed, a, 3 * sliding + 2] -= mu[sliding] * s[:, a] * rate
        matrix[tangents.ravel()] = rows.reshape(-1, columns)


def unique_contacts(modes: Modes, impulse: np.ndarray) -> np.ndarray | None:
    """(n,) whether the impulse of each contact is determined within its mode; None if all are.

    Sticking leaves three entries free, sliding the normal one; what moves no velocity
    among these can be added or taken away.
    """
    from scipy.linalg.lapack import dpstrf

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
    _, _, rank, failed = dpstrf(reduced, tol=DEPENDENT, lower=1)
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
