"""What contact laws are given, and what they answer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import NotFiniteError, RangeError, ShapeError
from ...laws.single import newtons_shift
from ...laws.status import Status

__all__ = [
    "ContactProblem",
    "ContactSolution",
    "Turning",
    "arrays_of",
    "check_problem",
    "in_order",
    "rows_of_contacts",
]

_Arrays = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


# How many times as fast as all that makes up the points' motion a blow alone may throw them.
THROWN = 3.0
# What moves this slowly against that has come to rest, and is not measured by its rounding.
RESTS = 1e-10


@dataclass(frozen=True, eq=False)
class Turning:
    """The contacts that resist rolling and spin.

    Attributes:
        of: (k,) which contact each is.
        rolling, torsion: (k,) the largest moments across and about the normal, over P_n [m].
    """

    of: np.ndarray
    rolling: np.ndarray
    torsion: np.ndarray


def rows_of_contacts(chosen: np.ndarray) -> np.ndarray:
    """(3k,) the rows of k contacts."""
    rows: np.ndarray = (3 * chosen[:, None] + np.arange(3)).ravel()
    return rows


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """Contacts at one instant, in contact space.

    Each contact has three rows: two tangents, then the normal, which points from what is
    touched to what touches, so that approaching is u_n < 0. u⁺ = u_free + W P.

    Attributes:
        delassus: (3n, 3n) W = J M⁻¹ Jᵀ [1/kg], symmetric and positive semidefinite,
            bilateral constraints eliminated.
        velocity_before: (3n,) u⁻ [m/s].
        velocity_free: (3n,) u⁻ and what known impulses at the same instant add to it.
        restitution: (n,) e in [0, 1].
        friction: (n,) µ ≥ 0. Where it is 0 the tangent rows are not used.
        tangential_restitution: (n,) e_t in [−1, 1]: friction aims at u_t⁺ = −e_t u_t⁻.
        stiffness: (n,) k of each, for the law "lzb"; None where no law asks for it.
        adhesion: (n,) the largest pull A [N s]; None where none holds.
        turning: contacts that resist rolling and spin; None where none does. After the rows of
            all contacts then come three for each of them, of the relative angular velocity
            across the normal and about it [rad/s]; W and the velocities are of 3 (n + k) rows.
        numbers: (n,) what each contact is called in messages; None for its place.
    """

    delassus: np.ndarray
    velocity_before: np.ndarray
    velocity_free: np.ndarray
    restitution: np.ndarray
    friction: np.ndarray
    tangential_restitution: np.ndarray
    stiffness: np.ndarray | None = None
    adhesion: np.ndarray | None = None
    turning: Turning | None = None
    numbers: np.ndarray | None = None

    def number_of(self, contact: int) -> int:
        """What the contact at this place is called in messages."""
        return contact if self.numbers is None else int(self.numbers[contact])

    def newtons_shift(self) -> np.ndarray:
        """What Newton's law adds to u⁺ [m/s]: e_t u_t⁻ and e min(u_n⁻, 0); no row of turning."""
        before, n = self.velocity_before, len(self.friction)
        shift = np.zeros_like(before)
        if self.tangential_restitution.any():
            for k in (0, 1):
                shift[k : 3 * n : 3] = self.tangential_restitution * before[k : 3 * n : 3]
        normals = zip(self.restitution.tolist(), before[2 : 3 * n : 3].tolist(), strict=True)
        shift[2 : 3 * n : 3] = [newtons_shift(e, u) for e, u in normals]
        return shift

    def of_contacts(self, chosen: np.ndarray) -> ContactProblem:
        """The problem of some contacts, or of all in another order, without adhesion and turning.

        Args:
            chosen: (k,) their numbers.
        """
        rows = rows_of_contacts(chosen)
        return ContactProblem(
            np.ascontiguousarray(self.delassus[np.ix_(rows, rows)]),
            self.velocity_before[rows],
            self.velocity_free[rows],
            self.restitution[chosen],
            self.friction[chosen],
            self.tangential_restitution[chosen],
            None if self.stiffness is None else self.stiffness[chosen],
            numbers=np.array([self.number_of(i) for i in chosen.tolist()]),
        )

    def fastest(self, after: np.ndarray) -> float:
        """The largest of u⁻, u_free and u⁺ [m/s]: what rests and is struck has the second alone."""
        speeds = (self.velocity_before, self.velocity_free, after)
        return max(float(np.abs(u).max(initial=0.0)) for u in speeds)


@dataclass(frozen=True, eq=False)
class ContactSolution:
    """The impulses of contacts.

    Attributes:
        impulse: (3n,) P [N s].
        velocity_after: (3n,) u⁺ [m/s].
        status: how the answer is to be taken; look at ``status.valid`` first.
        residual: what is left of the law's own equations, relative to the velocities.
        unique: (n,) whether the impulse of each contact is determined; None where all are.
        velocity_start: (3n,) the velocity from which the works count: u⁻ for Newton's law
            with slip at the end and all contacts at once, where all impulses of the
            instant act together; u_free otherwise, where known impulses act first.
        normal_work, friction_work: (n,) the work of the impulse of each contact [J];
            P·(u_start + u⁺)/2, or its integral along the impact. Their sum is the
            kinetic energy that the contacts add.
        iterations: of the solver, 0 for a closed form; the hits of a sequence.
        tied: whether the order of the entries said which of two contacts is hit first.
        friction: (n,) the µ that each contact had in the end, where it is more than one number.

    With ``turning`` all arrays go on with its rows: moments [N m s], angular velocities [rad/s],
    and their work as that of friction.
    """

    impulse: np.ndarray
    velocity_after: np.ndarray
    status: Status
    residual: float
    unique: np.ndarray | None
    velocity_start: np.ndarray
    normal_work: np.ndarray
    friction_work: np.ndarray
    iterations: int = 0
    tied: bool = False
    friction: np.ndarray | None = None


def check_problem(problem: ContactProblem) -> None:
    """Refuse what no law can work on.

    Raises:
        ShapeError, NotFiniteError, RangeError.
    """
    n = len(problem.friction)
    rows = 3 * n + (0 if problem.turning is None else 3 * len(problem.turning.of))
    if rows == 3 * n and _is_sound(problem, n):
        return
    for name, shape in (
        ("delassus", (rows, rows)),
        ("velocity_before", (rows,)),
        ("velocity_free", (rows,)),
        ("restitution", (n,)),
        ("friction", (n,)),
        ("tangential_restitution", (n,)),
    ):
        array = getattr(problem, name)
        if array.shape != shape:
            raise ShapeError.of(f"contacts: {name}", shape, array.shape)
        if not np.isfinite(array).all():
            where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
            raise NotFiniteError.of(f"contacts: {name}", where, array[where])
    for name, low, high, allowed in (
        ("restitution", 0.0, 1.0, "0 to 1"),
        ("friction", 0.0, np.inf, "0 or more"),
        ("tangential_restitution", -1.0, 1.0, "-1 to 1"),
    ):
        array = getattr(problem, name)
        wrong = (array < low) | (array > high)
        if wrong.any():
            raise RangeError.of(f"contacts: {name}", float(array[wrong][0]), allowed)


def _is_sound(problem: ContactProblem, n: int) -> bool:
    """Whether nothing is wrong with a problem; False also where it takes a closer look."""
    before, free, delassus = problem.velocity_before, problem.velocity_free, problem.delassus
    if delassus.shape != (3 * n, 3 * n) or not before.shape == free.shape == (3 * n,):
        return False
    flat = delassus.reshape(-1)
    # One number that is not finite makes a scalar product so, too.
    if not math.isfinite(before.dot(free) + flat.dot(flat)):
        return False
    e, mu, e_t = problem.restitution, problem.friction, problem.tangential_restitution
    if not e.shape == mu.shape == e_t.shape == (n,):
        return False
    es, mus, ets = e.tolist(), mu.tolist(), e_t.tolist()
    # A sum that is finite has no NaN, of which min and max would know nothing.
    return (
        math.isfinite(sum(es) + sum(mus) + sum(ets))
        and min(es, default=0.0) >= 0.0
        and max(es, default=0.0) <= 1.0
        and min(mus, default=0.0) >= 0.0
        and min(ets, default=0.0) >= -1.0
        and max(ets, default=0.0) <= 1.0
    )


def is_thrown(free: np.ndarray, before: np.ndarray, jacobian: np.ndarray, dv: np.ndarray) -> bool:
    """Whether a blow alone would throw points so fast that free + W P has lost digits.

    Args:
        free, before: (3n,) their velocities with the blow alone, and before it.
        jacobian: (3n, nv).
        dv: (nv,) Δv.
    """
    thrown = np.abs(free).max()
    terms = max(np.abs(jacobian).dot(np.abs(dv)).max(), np.abs(before).max())
    return bool(RESTS * thrown < terms < thrown / THROWN)


def in_order(array: np.ndarray) -> np.ndarray:
    """The array as compiled code takes it: in order, and such that may be written to."""
    flags = array.flags
    return array if flags.c_contiguous and flags.writeable else array.copy()


def arrays_of(problem: ContactProblem) -> _Arrays:
    """W, u⁻, u_free, µ, e and e_t as compiled laws of several contacts take them."""
    return (
        in_order(problem.delassus),
        in_order(problem.velocity_before),
        in_order(problem.velocity_free),
        in_order(problem.friction),
        in_order(problem.restitution),
        in_order(problem.tangential_restitution),
    )
