"""Any number of contacts without friction: 0 ≤ P ⊥ W P + b ≥ 0, solved exactly.

W is symmetric and positive semidefinite, of any rank. First the contacts that would
approach are taken to push, and those that come out wrong are swapped, all at once. Where
that finds nothing, principal pivoting goes there in finitely many steps (Keller 1973, "The
general quadratic optimization problem"): one approaching contact at a time is pressed until
it approaches no more, contacts that would come to pull being let go on the way. Where
contacts are redundant, the P of least norm is taken, which does not depend on their order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import lapack

__all__ = ["Frictionless", "solve_frictionless"]

# Squares of sines of angles between rows, below which they are dependent.
DEPENDENT = 1e-12
# Velocities this small against the others are zero.
AT_REST = 1e-12


@dataclass(frozen=True, eq=False)
class Frictionless:
    """The normal impulses of contacts without friction.

    Attributes:
        impulse: (n,) P [N s].
        feasible: whether there is an answer.
        unique: (n,) whether each impulse is determined; None where all are.
        iterations: pivots.
    """

    impulse: np.ndarray
    feasible: bool
    unique: np.ndarray | None
    iterations: int


def solve_frictionless(delassus: np.ndarray, shifted: np.ndarray, scale: float) -> Frictionless:
    """P with 0 ≤ P ⊥ W P + b ≥ 0.

    Args:
        delassus: (n, n) W [1/kg], positive semidefinite.
        shifted: (n,) b [m/s].
        scale: the size of the velocities, for what counts as zero [m/s].
    """
    n = len(shifted)
    tiny = AT_REST * scale
    if shifted.min() >= -tiny:
        return Frictionless(np.zeros(n), True, None, 0)
    guess = _exchange(delassus, shifted, tiny)
    if guess is not None:
        return guess
    guess = _all_pushing(delassus, shifted, tiny)
    if guess is not None:
        return guess
    impulse, feasible, count = _pivot(delassus, shifted, tiny)
    if not feasible:
        return Frictionless(impulse, False, None, count)
    return _least(delassus, shifted, impulse, tiny, count)


def _exchange(delassus: np.ndarray, shifted: np.ndarray, tiny: float) -> Frictionless | None:
    """The answer if swapping all wrong contacts at once finds it and it is clearly unique.

    (Júdice & Pires 1994, block principal pivoting; it may cycle, hence only a try.)
    """
    n = len(shifted)
    pushing = shifted < -tiny
    fewest: int = n + 1
    for count in range(10):
        chosen = np.flatnonzero(pushing)
        whole = len(chosen) == n
        block = delassus if whole else delassus[chosen[:, None], chosen]
        factor, solved, failed = lapack.dposv(
            block, -(shifted if whole else shifted[chosen]), lower=1
        )
        if failed or (factor.diagonal() ** 2 < 1e-9 * block.diagonal()).any():
            return None
        if whole:
            impulse, wrong = solved, solved < 0.0
        else:
            impulse = np.zeros(n)
            impulse[chosen] = solved
            velocity = delassus.dot(impulse) + shifted
            velocity[chosen] = np.inf
            wrong = (impulse < 0.0) | (velocity < -tiny)
        number = int(np.count_nonzero(wrong))
        if number == 0:
            # Contacts that just touch may share the load: they need a closer look.
            if whole or velocity.min() > tiny:
                return Frictionless(impulse, True, None, count)
            return None
        if number >= fewest:
            return None
        fewest = number
        pushing = pushing ^ wrong
    return None


def _all_pushing(delassus: np.ndarray, shifted: np.ndarray, tiny: float) -> Frictionless | None:
    """The answer if all contacts share the load, redundant ones among them: of least norm."""
    if not (shifted < -tiny).all():
        return None
    least, _, null = _least_norm(delassus, -shifted)
    left = np.abs(delassus.dot(least) + shifted).max()
    # Not less than 0 by rounding either: that takes a closer look.
    if not null.shape[1] or not (least > 0.0).all() or not left <= tiny:
        return None
    return _told(least, np.arange(len(shifted)), null, 0)


def _pivot(delassus: np.ndarray, shifted: np.ndarray, tiny: float) -> tuple[np.ndarray, bool, int]:
    """Some P, whether it is an answer, and how many pivots it took."""
    n = len(shifted)
    impulse = np.zeros(n)
    velocity = shifted.copy()
    diagonal = delassus.diagonal()
    pushing: list[int] = []
    # Keller's method ends; the limit is for rounding in degenerate corners.
    for count in range(20 * n + 20):
        waiting = velocity.copy()
        waiting[pushing] = 0.0
        entering = int(waiting.argmin())
        # Large impulses in balance leave their own rounding.
        rest = max(tiny, 10.0 * AT_REST * float((diagonal * impulse).max()))
        if waiting[entering] >= -rest:
            return impulse, True, count
        while velocity[entering] < 0.0:
            direction = np.zeros(n)
            direction[entering] = 1.0
            if pushing:
                block = delassus[np.ix_(pushing, pushing)]
                direction[pushing] = -np.linalg.solve(block, delassus[pushing, entering])
            change = delassus @ direction
            curvature = change[entering]
            free = curvature > DEPENDENT * diagonal[entering]
            step = -velocity[entering] / curvature if free else np.inf
            leaving = -1
            for i in pushing:
                if direction[i] < 0.0 and -impulse[i] / direction[i] < step:
                    step, leaving = -impulse[i] / direction[i], i
            if not np.isfinite(step):
                return impulse, False, count
            impulse += step * direction
            if leaving >= 0:
                pushing.remove(leaving)
                impulse[leaving] = 0.0
                velocity = delassus @ impulse + shifted
                continue
            pushing.append(entering)
            # Afresh, so that rounding does not pile up from pivot to pivot.
            impulse[pushing] = np.linalg.solve(
                delassus[np.ix_(pushing, pushing)], -shifted[pushing]
            )
            np.maximum(impulse, 0.0, out=impulse)
            velocity = delassus @ impulse + shifted
            break
    return impulse, False, 20 * n + 20


def _least(
    delassus: np.ndarray, shifted: np.ndarray, impulse: np.ndarray, tiny: float, count: int
) -> Frictionless:
    """The answer of least norm among all, given one."""
    velocity = delassus @ impulse + shifted
    # What pushes touches, whatever rounding leaves of its velocity.
    touching = np.flatnonzero((velocity <= 10.0 * tiny) | (impulse > 0.0))
    if not len(touching):
        return Frictionless(impulse, True, None, count)
    least, basis, null = _least_norm(delassus[touching[:, None], touching], -shifted[touching])
    if not null.shape[1]:
        return Frictionless(impulse, True, None, count)
    size = np.abs(least).max(initial=0.0)
    if least.min() < -1e-13 * size:
        least = _least_pushing(least, basis, null)
    result = np.zeros_like(impulse)
    result[touching] = np.maximum(least, 0.0)
    error = np.minimum(delassus.diagonal() * result, delassus @ result + shifted)
    if np.abs(error).max() > 100.0 * tiny:
        # Rows almost dependent: the pivots' answer is the better one.
        result = impulse
    return _told(result, touching, null, count)


def _least_norm(
    matrix: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n,) x of least norm with matrix x = wanted, bases of the range and of the null space."""
    values, vectors, failed = lapack.dsyevd(matrix)
    if failed:
        values, vectors = np.linalg.eigh(matrix)
    # They come in order.
    first = int(np.count_nonzero(values <= DEPENDENT * values[-1]))
    null, basis, values = vectors[:, :first], vectors[:, first:], values[first:]
    least = basis.dot(wanted.dot(basis) / values)
    # What rounding has left, once more.
    least += basis.dot((wanted - matrix.dot(least)).dot(basis) / values)
    return least, basis, null


def _told(impulse: np.ndarray, touching: np.ndarray, null: np.ndarray, count: int) -> Frictionless:
    """The answer, with what is not determined in it."""
    free = _free_to_shift(impulse[touching], null)
    if not free.any():
        return Frictionless(impulse, True, None, count)
    unique = np.ones(len(impulse), dtype=bool)
    unique[touching[free]] = False
    return Frictionless(impulse, True, unique, count)


def _least_pushing(least: np.ndarray, basis: np.ndarray, null: np.ndarray) -> np.ndarray:
    """P ≥ 0 of least norm that does what ``least`` does: P = P_least + N z, |z| least.

    A least distance problem, by way of nonnegative least squares (Lawson & Hanson 1974).
    """
    from scipy.optimize import nnls

    size = np.abs(least).max()
    system = np.vstack([null.T, -least / size])
    weights, _ = nnls(system, np.r_[np.zeros(null.shape[1]), 1.0])
    left = system @ weights
    left[-1] -= 1.0
    if left[-1] == 0.0:
        return least
    rough = least / size - null @ (left[:-1] / left[-1])
    # The active set is known now; the same once more, free of the rounding of that way.
    kept = rough > 1e-9
    result = np.zeros_like(least)
    result[kept] = np.linalg.lstsq(basis[kept].T, basis.T @ least, rcond=1e-11)[0]
    return result


def _free_to_shift(impulse: np.ndarray, null: np.ndarray) -> np.ndarray:
    """(n,) whether load can be shifted to or from each contact along the null directions."""
    involved = (null**2).sum(axis=1) > 1e-9
    pushing = impulse > 1e-12 * impulse.max(initial=0.0)
    if (pushing | ~involved).all():
        return involved
    from scipy.optimize import linprog

    # Contacts without load can only gain: each is asked how far it can go.
    bounds = [
        (-1.0, 1.0) if push or not part else (0.0, 1.0)
        for push, part in zip(pushing.tolist(), involved.tolist(), strict=True)
    ]
    free = np.zeros(len(impulse), dtype=bool)
    projector = np.eye(len(impulse)) - null @ null.T
    for i in np.flatnonzero(involved).tolist():
        for sign in (1.0, -1.0) if pushing[i] else (1.0,):
            cost = np.zeros(len(impulse))
            cost[i] = -sign
            answer = linprog(cost, A_eq=projector, b_eq=np.zeros(len(impulse)), bounds=bounds)
            if answer.status == 0 and -answer.fun > 1e-6:
                free[i] = True
                break
    return free
