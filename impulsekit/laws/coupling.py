"""Whether friction is too weak against the inertia it feeds back on to leave a choice of v⁺.

Two proofs, each sufficient. **Monotony.** Of two solutions P, P' of 0 ≤ P_n − f ⊥ ξ_n ≥ 0 with
Coulomb friction, ξ = W P + b, the laws of the contacts give for p = P − P' (De Saxcé & Feng 1998)

    pᵀ W p ≤ −Σ µ_i (|ξ_t,i| − |ξ'_t,i|) p_n,i ≤ Σ µ_i |(W p)_t,i| |p_n,i|
           ≤ ½ Σ µ_i (α |(W p)_t,i|² + p_n,i²/α)   for every α > 0,

so that p = 0 where W − ½ Σ µ_i (α W T_i T_iᵀ W + n_i n_iᵀ/α) is positive definite for some α.

**Contraction**, which allows redundant tangents. With the bound µ N on friction given, Coulomb's
law is a convex problem (Tresca's) with one P_n. N ↦ P_n(N) has in each mode the derivative
dP_n = Ŵ⁻¹ C y, where C = W_nt, Ŵ = W_nn − C W_tt⁺ Cᵀ (or more, where contacts slide), and y is made
of dN along the slip and what sticking answers, so that yᵀ W_tt y ≤ Σ (µ dN s)ᵀ W_tt (µ dN s). In
the norm of Ŵ therefore |dP_n| ≤ L |dN| with

    L² = λ_max(C W_tt⁺ Cᵀ, Ŵ) · λ_max(µ W_tt µ) / λ_min(Ŵ).

Where L < 1 the map contracts and P_n = N has one solution (Banach), in the plane and in space.
"""

from __future__ import annotations

import numpy as np

from .borrowed import borrowing
from .compiled import compiled, entry
from .dense import cholesky, lower_solve
from .tolerances import CLEAR

__all__ = ["friction_feedback", "friction_is_weak", "is_monotone"]

# Of a feedback below 1, or a matrix above 0, by less than this, rounding decides.
SURE = 1e-6
# The α that are tried, W being scaled to a mean diagonal of 1: 3.3 is best at µ = 0.3, 1 at µ = 1.
ALPHAS = (2.2, 1.5, 3.3, 1.0, 0.7)
# Eigenvalues below this share of the largest are those of rows that move nothing.
NO_MOBILITY = 1e-11


@entry(lambda: (np.eye(6), np.ones(2)), seconds=2.0, apart=True)
def friction_feedback(W: np.ndarray, mu: np.ndarray) -> float:
    """L, or less where that is not below 1; infinite where normals depend on the tangents.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        mu: (n,) friction.
    """
    n = len(mu)
    rubbing = 0
    for i in range(n):
        if mu[i] > 0.0:
            rubbing += 1
    normal, tangent = np.empty((n, n)), np.zeros((2 * rubbing, 2 * rubbing))
    cross, lower = np.zeros((n, 2 * rubbing)), np.empty((n, n))
    unit, rows, own = np.ones(n), np.empty(2 * rubbing, np.int64), np.empty(2 * rubbing, np.int64)
    m = 0
    for i in range(n):
        if not W[3 * i + 2, 3 * i + 2] > 0.0:
            return np.inf
        unit[i] = 1.0 / np.sqrt(W[3 * i + 2, 3 * i + 2])
        if mu[i] > 0.0:
            rows[m], rows[m + 1], own[m], own[m + 1] = 3 * i, 3 * i + 1, i, i
            m += 2
    for i in range(n):
        for j in range(n):
            normal[i, j] = W[3 * i + 2, 3 * j + 2] * unit[i] * unit[j]
    if m == 0:
        return 0.0
    # With C W_tt⁺ Cᵀ taken off, its least eigenvalue is smaller still.
    if not cholesky(normal, n, lower) > NO_MOBILITY:
        return np.inf
    for i in range(n):
        for c in range(m):
            cross[i, c] = W[3 * i + 2, rows[c]] * unit[i] * unit[own[c]]
    for r in range(m):
        for c in range(m):
            tangent[r, c] = W[rows[r], rows[c]] * unit[own[r]] * unit[own[c]]
    half = _half_of(cross, tangent)
    coupled = np.dot(half, half.T)
    most, heaviest = 0.0, 0.0
    for r in range(m):
        heaviest = max(heaviest, mu[own[r]] ** 2 * tangent[r, r])
    for i in range(n):
        for j in range(n):
            normal[i, j] -= coupled[i, j]
    lightest = _least_pivot(normal, n, lower)
    for i in range(n):
        most = max(most, coupled[i, i] / normal[i, i] if normal[i, i] > 0.0 else 0.0)
    # Diagonals and pivots are bounds of eigenvalues.
    if most * heaviest >= lightest:
        return float(np.sqrt(most * heaviest / lightest)) if lightest > 0.0 else np.inf
    return _feedback_by_eigenvalues(normal, half, tangent, mu, own)


def _feedback_examples() -> tuple[object, ...]:
    return np.eye(2), np.ones((2, 4)), np.eye(4), np.ones(2), np.ones(4, np.int64)


@entry(_feedback_examples, seconds=1.5, apart=True)
def _feedback_by_eigenvalues(
    normal: np.ndarray, half: np.ndarray, tangent: np.ndarray, mu: np.ndarray, own: np.ndarray
) -> float:
    """L, where diagonals and pivots do not tell whether it is below 1.

    Args:
        normal: (n, n) Ŵ.
        half: (n, m) H with H Hᵀ = C W_tt⁺ Cᵀ.
        tangent: (m, m) W_tt, used up.
        mu: (n,) friction.
        own: (m,) the contact of each tangent.
    """
    n, m = half.shape
    sizes, axes = np.linalg.eigh(normal)
    if not sizes[0] > NO_MOBILITY * max(sizes[n - 1], 1.0):
        return np.inf
    # λ_max(C W_tt⁺ Cᵀ, Ŵ), in the eigenvectors of Ŵ.
    turned = np.dot(axes.T.copy(), half)
    for i in range(n):
        for k in range(m):
            turned[i, k] /= np.sqrt(sizes[i])
    feedback = np.linalg.eigvalsh(np.dot(turned, turned.T))[n - 1]
    for r in range(m):
        for c in range(m):
            tangent[r, c] *= mu[own[r]] * mu[own[c]]
    bound = np.linalg.eigvalsh(tangent)[m - 1]
    return float(np.sqrt(max(feedback, 0.0) * bound / sizes[0]))


@compiled
def _half_of(cross: np.ndarray, tangent: np.ndarray) -> np.ndarray:
    """(n, m) H with H Hᵀ = C W_tt⁺ Cᵀ: by Cholesky where W_tt is regular, else by eigenvalues."""
    n, m = cross.shape
    half, lower = cross.copy(), np.empty((m, m))
    if cholesky(tangent, m, lower) > CLEAR:
        for i in range(n):
            lower_solve(lower, m, half[i])
    else:
        _halve_by_eigenvalues(cross, tangent, half)
    return half


@entry(lambda: (np.ones((2, 4)), np.eye(4), np.ones((2, 4))), seconds=1.0, apart=True)
def _halve_by_eigenvalues(cross: np.ndarray, tangent: np.ndarray, half: np.ndarray) -> bool:
    """Write H by eigenvalues; whether any tangent moves."""
    n, m = cross.shape
    values, vectors = np.linalg.eigh(tangent)
    for k in range(m):
        for i in range(n):
            total = 0.0
            if values[k] > NO_MOBILITY * values[m - 1]:
                for c in range(m):
                    total += cross[i, c] * vectors[c, k]
                total /= np.sqrt(values[k])
            half[i, k] = total
    return bool(values[m - 1] > 0.0)


@compiled
def _least_pivot(matrix: np.ndarray, n: int, lower: np.ndarray) -> float:
    """The least pivot of Cholesky, which no eigenvalue need be as large as; 0 if not definite."""
    if not cholesky(matrix, n, lower) > 0.0:
        return 0.0
    least = np.inf
    for i in range(n):
        least = min(least, lower[i, i] ** 2)
    return least


@entry(lambda: (np.eye(6), np.ones(2)), seconds=2.0, apart=True)
def is_monotone(W: np.ndarray, mu: np.ndarray) -> bool:
    """Whether the first proof holds; never where W is singular.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        mu: (n,) friction.
    """
    n = len(mu)
    size = 0
    for i in range(n):
        size += 3 if mu[i] > 0.0 else 1
    rows, contact = np.empty(size, np.int64), np.empty(size, np.int64)
    unit = np.empty(n)
    k = 0
    for i in range(n):
        first = k
        total = 0.0
        for r in range(0 if mu[i] > 0.0 else 2, 3):
            rows[k], contact[k] = 3 * i + r, i
            total += W[3 * i + r, 3 * i + r]
            k += 1
        if not total > 0.0:
            return False
        unit[i] = np.sqrt((k - first) / total)
    own, rubbed = np.empty((size, size)), np.empty((size, size))
    for r in range(size):
        for c in range(size):
            own[r, c] = W[rows[r], rows[c]] * unit[contact[r]] * unit[contact[c]]
            slides = rows[c] % 3 < 2
            rubbed[r, c] = own[r, c] * mu[contact[c]] if slides else 0.0
    # What is positive definite has no entry on its diagonal that is not, which is soon known.
    promising, falls = int(np.int64(0)), np.zeros(size)
    for r in range(size):
        for c in range(size):
            falls[r] += 0.5 * rubbed[r, c] * own[r, c]
    for k in range(len(ALPHAS)):
        if _stays_positive(own, falls, mu, rows, contact, ALPHAS[k]):
            promising |= 1 << k
    if promising == 0:
        return False
    lower, matrix = np.empty((size, size)), own.copy()
    for r in range(size):
        matrix[r, r] -= SURE
    # What is taken off for friction leaves less still.
    if not cholesky(matrix, size, lower) > 0.0:
        return False
    product = np.dot(rubbed, own)
    for k in range(len(ALPHAS)):
        if (promising >> k) & 1 == 0:
            continue
        alpha = ALPHAS[k]
        matrix = own - 0.5 * alpha * product
        for r in range(size):
            matrix[r, r] -= SURE
            if rows[r] % 3 == 2:
                matrix[r, r] -= 0.5 * mu[contact[r]] / alpha
        if cholesky(matrix, size, lower) > 0.0:
            return True
    return False


@borrowing
def _stays_positive(
    own: np.ndarray,
    falls: np.ndarray,
    mu: np.ndarray,
    rows: np.ndarray,
    contact: np.ndarray,
    alpha: float,
) -> bool:
    """Whether the diagonal of the first proof's matrix does, ``falls`` being taken off α times."""
    for r in range(len(own)):
        total = own[r, r] - alpha * falls[r]
        if rows[r] % 3 == 2:
            total -= 0.5 * mu[contact[r]] / alpha
        if not total > 0.0:
            return False
    return True


@compiled
def friction_is_weak(W, mu):  # type: ignore[no-untyped-def]
    """Whether one of the two proofs says that v⁺ is the only one."""
    return is_monotone(W, mu) or friction_feedback(W, mu) < 1.0 - SURE
