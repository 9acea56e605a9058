"""Kinetics by Kane's equations: Chang & Huston 1995, eqs. (7) to (33), in order.

Everything is made of the partial velocities v_k^l and partial angular velocities ω_k^l,
the rows of v_klm and ω_klm (:mod:`impulsekit.reference.kinematics`). N bodies k, n
generalized speeds y_l, world axes m; SI units throughout.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from impulsekit.errors import ContradictionError, SingularMassError
from impulsekit.reference.arithmetic import Arithmetic, Array
from impulsekit.reference.kinematics import Kinematics, PartialRates
from impulsekit.reference.rotation import cross


def generalized_active_force(at: Kinematics, forces: Array, couples: Array) -> Array:
    """Return F_l = Σ_k v_k^l·F_k + ω_k^l·M_k (Chang & Huston 1995, eqs. 7-10).

    Args:
        forces: (N, 3) N, the resultant F_k on each mass centre.
        couples: (N, 3) N m, the couple M_k on each body.

    Returns:
        (n,) F_l.
    """
    return _on_speeds(at.linear, forces) + _on_speeds(at.angular, couples)


def generalized_inertia_force(
    at: Kinematics, rates: PartialRates, y: Array, acceleration: Array
) -> Array:
    """Return F*_l = Σ_k v_k^l·F*_k + ω_k^l·M*_k (Chang & Huston 1995, eqs. 11-16), with

        F*_k = −m_k a_k,    M*_k = −I_k·α_k − ω_k x (I_k·ω_k).

    Args:
        rates: v̇_klm and ω̇_klm at y.
        y: (n,) generalized speeds.
        acceleration: (n,) ẏ.

    Returns:
        (n,) F*_l.
    """
    over = ([1], [0])
    _, spin = at.velocities(y)
    linear = np.tensordot(at.linear, acceleration, axes=over)  # eqs. (3), (4)
    linear += np.tensordot(rates.linear, y, axes=over)
    angular = np.tensordot(at.angular, acceleration, axes=over)
    angular += np.tensordot(rates.angular, y, axes=over)
    inertia_force = -at.masses[:, None] * linear
    gyroscopic = cross(spin, _turned(at.inertias, spin))
    inertia_couple = -_turned(at.inertias, angular) - gyroscopic
    on_bodies = generalized_active_force(at, inertia_force, inertia_couple)
    return on_bodies - at.armature * acceleration


def accelerations(
    numbers: Arithmetic,
    at: Kinematics,
    rates: PartialRates,
    y: Array,
    active_force: Array,
    on_singular: Callable[[int], Exception],
) -> Array:
    """Return ẏ from Kane's equations F_l + F*_l = 0 (Chang & Huston 1995, eq. 17).

    F*_l is −a_lp ẏ_p plus what it is at ẏ = 0.

    Args:
        active_force: (n,) F_l.
        on_singular: as in :meth:`Arithmetic.solve_symmetric`.

    Returns:
        (n,) ẏ.
    """
    at_rest = generalized_inertia_force(at, rates, y, numbers.zeros(len(y)))
    return numbers.solve_symmetric(generalized_masses(at), active_force + at_rest, on_singular)


def generalized_impulse(at: Kinematics, impulses: Array, couples: Array) -> Array:
    """Return I_l = Σ_k ( v_k^l·∫F_k dt + ω_k^l·∫M_k dt ) (Chang & Huston 1995, eq. 18).

    The configuration stands still during the impact, so the partial velocities leave the
    integral.

    Args:
        impulses: (N, 3) N s, ∫F_k dt on each mass centre.
        couples: (N, 3) N m s, ∫M_k dt on each body.

    Returns:
        (n,) I_l.
    """
    return generalized_active_force(at, impulses, couples)


def generalized_momentum(at: Kinematics, y: Array) -> Array:
    """Return P_l = Σ_k ( m_k v_k^l·v_k + ω_k^l·I_k·ω_k ), (n,) (Chang & Huston 1995, eq. 19).

    A rotor in a joint adds its armature times the joint's speed.
    """
    linear, angular = momenta(at, y)
    return _on_speeds(at.linear, linear) + _on_speeds(at.angular, angular) + at.armature * y


def momenta(at: Kinematics, y: Array) -> tuple[Array, Array]:
    """Return (N, 3) m_k v_k and (N, 3) I_k·ω_k of the bodies, without rotors."""
    linear, spin = at.velocities(y)
    return at.masses[:, None] * linear, _turned(at.inertias, spin)


def generalized_masses(at: Kinematics) -> Array:
    """Return a_lp = Σ_k ( m_k v_klm v_kpm + I_kmn ω_klm ω_kpn ) (Chang & Huston 1995, eq. 30).

    Rotors in joints add their armature to the diagonal.

    Returns:
        (n, n), symmetric.
    """
    over = ([0, 2], [0, 2])
    masses = np.tensordot(at.linear, at.masses[:, None, None] * at.linear, axes=over)
    masses = masses + np.tensordot(at.angular, at.angular @ at.inertias, axes=over)
    own = range(len(masses))
    masses[own, own] = masses[own, own] + at.armature
    return masses


def solve_for_speeds(
    numbers: Arithmetic,
    masses: Array,
    impulse: Array,
    on_singular: Callable[[int], Exception],
) -> Array:
    """Return Δy from the impact equations a_lp Δy_p = I_l (Chang & Huston 1995, eqs. 31-33)."""
    return numbers.solve_symmetric(masses, impulse, on_singular)


def impulses_of_rows(
    numbers: Arithmetic,
    masses: Array,
    matrix: Array,
    missing: Array,
    size: Any,
    names: Sequence[str],
    on_singular: Callable[[int], Exception],
) -> Array:
    """Return impulses λ of constraint rows that make matrix @ Δy come out as ``missing``.

    A a⁻¹ Aᵀ λ = missing. Rows may repeat each other: the shortest λ is given then.

    Args:
        masses: (n, n) a_lp.
        matrix: (r, n) A.
        missing: (r,) the change that each row still wants.
        size: how large the velocities are from which ``missing`` was taken.

    Raises:
        ContradictionError: rows that demand different things of the same motion.
    """
    response = numbers.solve_symmetric(masses, matrix.T, on_singular)
    return consistent_solution(numbers, matrix @ response, missing, size, names)


def consistent_solution(
    numbers: Arithmetic, matrix: Array, right: Array, size: Any, names: Sequence[str]
) -> Array:
    """Return the shortest λ with W λ = right, for a W that may have lost rank.

    Rows count as at odds where they leave more than √epsilon of ``size``.

    Raises:
        ContradictionError: there is none.
    """
    solution, rank = numbers.solve_minimum_norm(matrix, right)
    if rank == len(right):
        return solution
    left_over = right - matrix @ solution
    allowed = numbers.sqrt(numbers.epsilon) * size
    at_odds = tuple(
        name for name, entry in zip(names, left_over, strict=True) if abs(entry) > allowed
    )
    if at_odds:
        raise ContradictionError(
            "these constraint rows cannot hold together: " + "; ".join(at_odds), rows=at_odds
        )
    return solution


def singular_at(speed_names: Sequence[str]) -> Callable[[int], Exception]:
    """Return the error for generalized masses that cannot be inverted."""

    def error(pivot: int) -> Exception:
        name = speed_names[pivot]
        return SingularMassError(
            f"the generalized masses are singular: {name} can change without any inertia "
            "resisting, given the others",
            joints=(name,),
        )

    return error


def _on_speeds(partial: Array, vectors: Array) -> Array:
    """Return Σ_k partial_klm vectors_km, (n,)."""
    return np.tensordot(partial, vectors, axes=([0, 2], [0, 1]))


def _turned(inertias: Array, vectors: Array) -> Array:
    """Return I_k·vector_k for each body, (N, 3)."""
    return (inertias @ vectors[:, :, None])[:, :, 0]
