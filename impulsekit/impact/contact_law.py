"""The law of contact in contact space: problems and answers, solved in the core.

No robot and no scene stand here: W, velocities and coefficients are given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from .._core import Contacts, FrictionKind, Order, Slip, Table, Verdict
from .._core import Friction as CoreFriction
from .._core import Law as CoreLaw
from .._core import Restitution as CoreRestitution
from .._core import find_others as core_others
from .._core import solve_contacts as core_contacts
from ..errors import InputError, NotFiniteError, RangeError, ShapeError
from ..scene.coefficients import EllipticFriction, FrictionTable, StaticKinetic, friction_at
from ..scene.law import Law
from .status import BY_CODE, Status

__all__ = [
    "ContactProblem", "ContactSolution", "Finding", "Turning", "core_friction", "core_law",
    "find_others", "solve_contacts",
]  # fmt: skip


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
        stiffness: (n,) k of each, for the law "lzb" and slip "compliant"; None where no law asks
            for it, or contacts that give way along their tangents are equally stiff.
        stiffness_ratio: (n,) tangential over normal stiffness, for slip "compliant"; else None.
        tangential_damping: (n,) D of the tangential springs; None where none is damped.
        adhesion: (n,) the largest pull A [N s]; None where none holds.
        turning: contacts that resist rolling and spin; None where none does. After the rows of
            all contacts then come three for each of them, of the relative angular velocity
            across the normal and about it [rad/s]; W and the velocities are of 3 (n + k) rows.
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
    stiffness_ratio: np.ndarray | None = None
    tangential_damping: np.ndarray | None = None

    def contacts(self, models: Sequence[CoreFriction] = ()) -> Contacts:
        """Return the coefficients as the core takes them; ``models``: of friction beside µ."""
        given: dict[str, Any] = {
            "restitution": self.restitution,
            "friction": self.friction,
            "tangential": self.tangential_restitution,
            "stiffness": self.stiffness,
            "stiffness_ratio": self.stiffness_ratio,
            "tangential_damping": self.tangential_damping,
            "adhesion": self.adhesion,
        }
        if self.turning is not None:
            given |= {"rolling": self.turning.rolling, "torsion": self.turning.torsion}
        fields = {name: _plain(array) for name, array in given.items() if array is not None}
        if self.turning is not None:
            fields["turning_of"] = np.ascontiguousarray(self.turning.of, dtype=np.int32)
        return Contacts(models=list(models), **fields)


@dataclass(frozen=True, eq=False)
class ContactSolution:
    """The impulses of contacts.

    Attributes:
        impulse: (3n,) P [N s].
        velocity_after: (3n,) u⁺ [m/s].
        status: how the answer is to be taken; look at ``status.valid`` first.
        residual: of the law's natural map, relative to the velocities and the terms of W P.
        unique: (n,) whether the impulse of each contact is determined; None where all are.
        velocity_start: (3n,) the velocity from which the works count: u⁻ for Newton's law
            with slip at the end and all contacts at once, where all impulses of the
            instant act together; u_free otherwise, where known impulses act first.
        normal_work, friction_work: (n,) the work of the impulse of each contact [J];
            P·(u_start + u⁺)/2, or its integral along the impact. Their sum is the
            kinetic energy that the contacts add.
        iterations: of the solver; the hits of a sequence.
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

    @classmethod
    def of(cls, found: Any) -> ContactSolution:
        """Return what the core found."""
        unique, friction = found.unique, found.friction
        return cls(
            found.impulse,
            found.after,
            BY_CODE[found.status],
            found.residual,
            None if unique.all() else unique,
            found.start,
            found.normal_work,
            found.friction_work,
            found.iterations,
            found.tied,
            friction if len(friction) else None,
        )


def _plain(array: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(array, dtype=float)


def core_law(law: Law) -> CoreLaw:
    """Return the law as the core takes it."""
    return CoreLaw(
        restitution=CoreRestitution[law.restitution],
        slip=Slip[law.slip],
        order=Order[law.order],
        exponent=law.exponent,
    )


def core_friction(model: Any, axis: np.ndarray | None = None) -> CoreFriction:
    """Return friction that is more than numbers as the core takes it.

    Args:
        model: of a contact.
        axis: of an ellipse (2,) its first axis in the contact's tangents, else None.
    """
    if isinstance(model, EllipticFriction):
        axis = np.array([1.0, 0.0]) if axis is None else np.ascontiguousarray(axis, dtype=float)
        kind = FrictionKind.elliptic
        return CoreFriction(kind=kind, first=model.first, second=model.second, axis=axis)
    if isinstance(model, StaticKinetic):
        kind = FrictionKind.static_kinetic
        return CoreFriction(kind=kind, first=model.static, second=model.kinetic)
    if isinstance(model, FrictionTable):
        table = Table(list(model.speeds), list(model.values))
        return CoreFriction(kind=FrictionKind.by_speed, table=table)
    if callable(model):
        function = partial(friction_at, model)
        return CoreFriction(kind=FrictionKind.by_speed, function=function)
    return CoreFriction(first=float(model))


def solve_contacts(
    problem: ContactProblem, law: Law, models: Sequence[tuple[Any, Any]] = ()
) -> ContactSolution:
    """Return the impulses of all contacts of one instant.

    With Newton's law and slip at the end, ξ = u⁺ + e∘min(u⁻, 0) for normals and
    ξ_t = u_t⁺ + e_t u_t⁻ for tangents obey 0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, and
    P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0 (Moreau 1988; Glocker 2001). The other laws are
    told by ``Law``. A contact that parts gets no impulse, and none pulls.

    Args:
        problem: W, velocities and coefficients.
        law: how restitution, slip and order are understood.
        models: where some friction is more than numbers, of each contact that, and of an ellipse
            (2,) its first axis in the contact's tangents, else None.

    Raises:
        InputError: law and coefficients cannot go together, or several frictional
            contacts that act on each other act at once under slip="path".
        ShapeError, NotFiniteError, RangeError: what is wrong with the problem.

    Example:
        >>> import numpy as np
        >>> from impulsekit.scene.law import Law
        >>> drop = np.array([0.0, 0.0, -2.0])  # a ball of 0.5 kg
        >>> W = np.diag([7.0, 7.0, 2.0])
        >>> one = np.ones(1)
        >>> ball = ContactProblem(W, drop, drop, 0.5 * one, 0.3 * one, 0 * one)
        >>> round(float(solve_contacts(ball, Law()).impulse[2]), 9)
        1.5
    """
    check_problem(problem)
    found = core_contacts(
        _plain(problem.delassus), _plain(problem.velocity_before), _plain(problem.velocity_free),
        problem.contacts([core_friction(*model) for model in models]), core_law(law),
    )  # fmt: skip
    if found.refused:
        raise InputError(found.refused)
    return ContactSolution.of(found)


def check_problem(problem: ContactProblem) -> None:
    """Refuse what no law can work on.

    Raises:
        ShapeError, NotFiniteError, RangeError.
    """
    n = len(problem.friction)
    rows = 3 * n + (0 if problem.turning is None else 3 * len(problem.turning.of))
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


# Slip that is rounding, against the velocities of all contacts.
NO_SLIP = 1e-12
PROVEN, NOT_PROVEN, SEVERAL = "proven", "not proven", "several"

RULE = (
    "the one reached from sticking: what approaches is held still first, and what cannot hold is "
    "let go; a contact that does not approach gets no impulse unless others press it; where this "
    "search ends without an answer, the one that slips least"
)
RULE_OF_SHARES = (
    "as between equally stiff springs under the contacts (each yields by its own mobility times "
    "its load), as far as none pulls"
)
SHARED = "redundant contacts share their load by rule"
REASONS = {
    Verdict.smooth: (PROVEN, "no friction: the problem is convex"),
    Verdict.weak: (PROVEN, "friction feeds back weakly on the normal impulses"),
    Verdict.all_tried: (
        PROVEN,
        "all modes were tried: any other v⁺ that obeys the law gains energy",
    ),
    Verdict.searched: (
        NOT_PROVEN,
        "Newton's method was started from all modes; no other v⁺ was found",
    ),
    Verdict.not_searched: (
        NOT_PROVEN,
        "not searched: too many contacts with friction that act on each other",
    ),
}


@dataclass(frozen=True)
class Finding:
    """A finding on the uniqueness of v⁺ of a contact problem.

    Attributes:
        verdict: "proven", "not proven" or "several".
        reason: why.
        impulses: (3n,) each, P of the others that gain no energy, each with other velocities.
        rule: by which the one shown is chosen, "" unless there are several.
    """

    verdict: str
    reason: str
    impulses: tuple[np.ndarray, ...] = ()
    rule: str = ""


def find_others(problem: ContactProblem, law: Law, solution: ContactSolution) -> Finding:
    """Return what else obeys the law, where that can be known.

    Args:
        problem: what was solved. law: by which. solution: the answer that is shown.
    """
    n = len(problem.friction)
    if solution.status is Status.NO_SOLUTION:
        return Finding(NOT_PROVEN, "the law gave no solution")
    if problem.turning is not None or solution.friction is not None:
        return Finding(NOT_PROVEN, "other solutions are not searched for this kind of friction")
    if law.order == "sequential" and n > 1:
        if solution.tied:
            reason = "contacts approach equally fast and are alike; another may be hit first"
            return Finding(NOT_PROVEN, reason)
        return Finding(PROVEN, "contacts are struck one after the other")
    if law.slip != "end":
        return Finding(PROVEN, "impulses are followed along the impact, step by step")
    found = core_others(
        _plain(problem.delassus), _plain(problem.velocity_before), _plain(problem.velocity_free),
        problem.contacts(), core_law(law), _plain(solution.impulse),
    )  # fmt: skip
    impulses = found.impulses
    for impulse in impulses:
        impulse.setflags(write=False)
    if impulses:
        count = len(impulses) + solution.status.valid
        reason = f"{count} v⁺ obey the law and gain no energy"
        rule = RULE if solution.status.obeys_law else ""
        return Finding(SEVERAL, reason, tuple(impulses), rule)
    if solution.unique is not None and _shares_matter(problem, law, solution):
        return Finding(
            NOT_PROVEN, "redundant contacts share their load by rule", (), RULE_OF_SHARES
        )
    return Finding(*REASONS[found.verdict])


def _shares_matter(problem: ContactProblem, law: Law, solution: ContactSolution) -> bool:
    """Return True if v⁺ may depend on how redundant contacts share their load."""
    if solution.unique is None:
        return False
    shared = ~solution.unique
    e, mu = problem.restitution[shared], problem.friction[shared]
    if law.restitution == "poisson" and e.any() and (mu.any() or np.ptp(e) > 0.0):
        return True
    slip = np.hypot(solution.velocity_after[0::3], solution.velocity_after[1::3])[: len(shared)]
    return bool((mu > 0.0).any() and (slip[shared] > NO_SLIP * slip.max(initial=0.0)).any())
