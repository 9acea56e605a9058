"""Whether a contact problem has other velocities that obey the law, and which are shown."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from ...laws.coulomb import can_press, raising
from ...laws.found import SAME
from ...laws.modes import DEPENDENT
from ...laws.others import (
    ALL_TRIED,
    MOST_ANSWERS,
    SEARCHED,
    SMOOTH,
    TOO_MANY,
    WEAK,
    find_answers,
)
from ...laws.status import Status
from ...laws.tolerances import GAIN, NEGLIGIBLE, PART
from ...laws.uniqueness import NEAR, is_searched
from ...laws.words import NEWTON, POISSON
from ...scene.law import Law
from ...tolerances import NONZERO
from .groups import groups_of, solution_of_contacts
from .problem import ContactProblem, ContactSolution, arrays_of, in_order, rows_of_contacts
from .single import block_of

__all__ = ["NOT_PROVEN", "PROVEN", "SEVERAL", "Finding", "find_others", "told_if_several"]

PROVEN, NOT_PROVEN, SEVERAL = "proven", "not proven", "several"
CLOSED_FORM = "one contact, solved in closed form"
OF_GROUPS = "contacts that do not act on each other, each solved in closed form"

ALL_MODES = "all modes of the contacts in the plane were tried"

RULE = (
    "the one reached from sticking: all contacts are held still first, and what cannot hold is "
    "let go; an answer in which nothing slips is shown wherever there is one. Where that one gains "
    "energy it is the one of least energy among those that do not"
)
RULE_OF_PARTING = "a contact that parts gets no impulse"
RULE_OF_TIES = "of contacts that are alike in speed and all else, the first entry is hit first"
RULE_OF_SPLIT = (
    "the compression of least Σ w |P|², w being the mobility of each contact (of one contact the "
    "least friction impulse); what is given back is e times its load"
)
RULE_OF_SLIP = (
    "the load that equally stiff springs under the contacts would take (each gives way by its own "
    "mobility times its load), as far as none pulls"
)
SLIPPING = "redundant contacts slip: load can be shifted between them, and friction with it"
SHARED = "the compression's load may be shared in many ways, and e times it comes back"
# A way to shift load ends where a contact has none, on either side.
ENDS = 2
_NO_ANSWER = (Status.NO_SOLUTION, Status.NOT_CONVERGED, Status.SEQUENCE_TOO_LONG)


class Finding(NamedTuple):
    """What is known of the answers of a contact problem beside the one shown.

    Attributes:
        verdict: "proven", "not proven" or "several".
        reason: why.
        impulses: (3n,) each, P of the others that gain no energy, each with other velocities.
        rule: by which the one shown is chosen, "" unless there are several.
        settled: whether the rule is one of the law itself, so that the status stays what it is:
            all differ by the shares of the compression of Poisson's law alone, friction could
            press in a lone contact that parts, or contacts of a sequence are alike.
    """

    verdict: str
    reason: str
    impulses: tuple[np.ndarray, ...] = ()
    rule: str = ""
    settled: bool = False


def told_if_several(
    problem: ContactProblem, law: Law, solution: ContactSolution
) -> ContactSolution:
    """The solution; MANY_SOLUTIONS where others obey the law as well."""
    if not solution.status.valid:
        return solution
    found = find_others(problem, law, solution)
    if found.verdict is SEVERAL and not found.settled:
        return dataclasses.replace(solution, status=Status.MANY_SOLUTIONS)
    return solution


def find_others(problem: ContactProblem, law: Law, solution: ContactSolution) -> Finding:
    """What else obeys the law, where that can be known.

    Args:
        problem: what was solved.
        law: by which.
        solution: the answer that is shown.
    """
    if solution.status in _NO_ANSWER:
        return Finding(NOT_PROVEN, "the law gave no solution")
    if problem.turning is not None:
        reason = "other solutions are not searched for contacts with rolling or torsion"
        return Finding(NOT_PROVEN, reason)
    n = len(problem.friction)
    if law.order == "sequential" and n > 1:
        if solution.tied:
            return _of_a_tie(problem, law, solution)
        return _of_hits(solution, "contacts are struck one after the other, each in closed form")
    if law.restitution == "lzb" and n > 1:
        return _of_hits(solution, "impulses are followed from where contacts touch, step by step")
    if law.slip == "path":
        return _of_hits(solution, "slip is followed along the impact, step by step")
    scale = problem.fastest(solution.velocity_after)
    if not scale:
        return Finding(PROVEN, "nothing moves")
    newton = law.restitution == "newton"
    if n == 1 and _is_closed_form(problem, solution, newton=newton):
        return Finding(PROVEN, CLOSED_FORM)
    if n > 1:
        groups = groups_of(problem)
        if len(groups) > 1:
            return _of_groups(problem, law, solution, groups)
    search = _search(problem, solution.impulse, scale, newton=newton)
    slips = newton or not problem.restitution.any()
    if search.split and slips and (search.others or solution.unique is not None):
        others = search.others or _of_unloaded(problem, solution, scale)
        return Finding(SEVERAL, SLIPPING, others, RULE_OF_SLIP, settled=True)
    if not search.others:
        if search.how in (SMOOTH, WEAK) and not newton and _gives_back_shares(problem, solution):
            return _of_shares(problem, solution, scale)
        return _alone(problem, solution, search, newton=newton)
    if search.split:
        return Finding(SEVERAL, SHARED, search.others, RULE_OF_SPLIT, settled=True)
    if n == 1 and not solution.impulse.any():
        reason = "the contact parts, and friction could press it in as well"
        return Finding(SEVERAL, reason, search.others, RULE_OF_PARTING, settled=True)
    reason = f"{len(search.others) + 1} v⁺ obey the law and gain no energy"
    return Finding(SEVERAL, reason, search.others, RULE)


def _of_groups(
    problem: ContactProblem, law: Law, solution: ContactSolution, groups: list[np.ndarray]
) -> Finding:
    """What is known of contacts that act on each other in groups: of each without the others."""
    findings: list[Finding] = []
    impulses: list[np.ndarray] = []
    for members in groups:
        own = solution_of_contacts(solution, members)
        found = find_others(problem.of_contacts(members), law, own)
        findings.append(found)
        for impulse in found.impulses:
            P = solution.impulse.copy()
            P[rows_of_contacts(members)] = impulse
            P.setflags(write=False)
            impulses.append(P)
    for verdict in (SEVERAL, NOT_PROVEN, PROVEN):
        told = [found for found in findings if found.verdict is verdict]
        if told:
            break
    reasons, rules = (
        "; ".join(dict.fromkeys(texts))
        for texts in ([found.reason for found in told], [found.rule for found in told])
    )
    settled = verdict is SEVERAL and all(found.settled for found in told)
    reason = OF_GROUPS if reasons == CLOSED_FORM else reasons
    return Finding(verdict, reason, tuple(impulses), rules, settled)


def _of_unloaded(
    problem: ContactProblem, solution: ContactSolution, scale: float
) -> tuple[np.ndarray, ...]:
    """Answers in which one of the redundant contacts that slip carries no load: two extremes."""
    from .simultaneous import solve_simultaneous

    if solution.unique is None:
        return ()
    found: list[np.ndarray] = []
    shift = problem.newtons_shift()
    for i in np.flatnonzero(~solution.unique):
        rest = np.delete(np.arange(len(problem.friction)), i)
        part = solve_simultaneous(problem.of_contacts(rest), Law())
        P = np.zeros_like(solution.impulse)
        P[rows_of_contacts(rest)] = part.impulse
        normal = 3 * i + 2
        meant = problem.velocity_free[normal] + problem.delassus[normal] @ P + shift[normal]
        if not part.status.valid or meant < -SAME * scale:
            continue
        if all(_apart(problem, one, P, scale) for one in (solution.impulse, *found)):
            P.setflags(write=False)
            found.append(P)
        if len(found) == ENDS:
            break
    return tuple(found)


def _of_a_tie(problem: ContactProblem, law: Law, solution: ContactSolution) -> Finding:
    """What comes if of contacts that are alike the last entry is hit first."""
    from .sequential import solve_sequential

    back = np.arange(len(problem.friction))[::-1]
    turned = solve_sequential(problem.of_contacts(back), law)
    scale = problem.fastest(solution.velocity_after)
    P = turned.impulse[np.argsort(rows_of_contacts(back))]
    if not turned.status.valid or not _apart(problem, solution.impulse, P, scale):
        return Finding(NOT_PROVEN, "contacts approach equally fast and are alike")
    P.setflags(write=False)
    reason = "contacts approach equally fast and are alike; another may be hit first"
    return Finding(SEVERAL, reason, (P,), RULE_OF_TIES, settled=True)


def _of_hits(solution: ContactSolution, reason: str) -> Finding:
    if solution.status is Status.MANY_SOLUTIONS:
        return Finding(SEVERAL, "a hit has several solutions", rule=RULE)
    return Finding(PROVEN, reason)


def _is_closed_form(problem: ContactProblem, solution: ContactSolution, *, newton: bool) -> bool:
    """Whether the closed form of one contact knows all solutions."""
    mu = problem.friction.item()
    if solution.status is Status.MANY_SOLUTIONS or solution.unique is not None:
        return not mu
    if solution.impulse.any() or mu <= NEGLIGIBLE:
        return True
    # It parts; unless friction can press it in there is no other.
    b1, b2, bn = (problem.velocity_free + (problem.newtons_shift() if newton else 0.0)).tolist()
    block = block_of(problem.delassus, 0)
    return not can_press(block, b1, b2, bn, mu, abs(b1) + abs(b2) + abs(bn))


class _Search(NamedTuple):
    """What ``laws.others`` finds: how, how many answers, (3n,) P of each other one, if split."""

    how: int
    total: int
    others: tuple[np.ndarray, ...]
    split: bool


def _search(problem: ContactProblem, shown: np.ndarray, scale: float, *, newton: bool) -> _Search:
    room = np.empty((2, MOST_ANSWERS, len(shown)))
    restitution = NEWTON if newton else POISSON
    W, before, free, *coefficients = arrays_of(problem)
    up = raising(scale)
    how, count, others, split = find_answers(
        W,
        up * before,
        up * free,
        np.array(coefficients),
        restitution,
        up * in_order(shown),
        up * scale,
        room,
        NEAR,
    )
    found = room[0, :others] / up
    found.setflags(write=False)
    return _Search(how, count, tuple(found), split)


def _gives_back_shares(problem: ContactProblem, solution: ContactSolution) -> bool:
    """Whether Poisson's v⁺ may depend on how redundant contacts share their load.

    It does not where they are without friction and have one e: e times the resultant comes back.
    """
    if solution.unique is None:
        return False
    e, mu = problem.restitution[~solution.unique], problem.friction[~solution.unique]
    return bool(e.any() and (mu.any() or np.ptp(e) > 0.0))


def _of_shares(problem: ContactProblem, solution: ContactSolution, scale: float) -> Finding:
    """What other shares of the compression's load come to; only without friction are they tried.

    Along each null direction of the normals that press, the shares are those as far as no
    contact pulls.
    """
    if problem.friction.any():
        return Finding(NOT_PROVEN, SHARED)
    W, free = problem.delassus, problem.velocity_free
    pressed = _without_release(problem, free)
    if not pressed.status.valid:
        return Finding(NOT_PROVEN, SHARED)
    closed = np.flatnonzero(pressed.velocity_after[2::3] <= SAME * scale)
    sizes = np.sqrt(np.maximum(W.diagonal()[2::3][closed], NONZERO))
    values, axes = np.linalg.eigh(W[2::3, 2::3][np.ix_(closed, closed)] / np.outer(sizes, sizes))
    found: list[np.ndarray] = []
    for axis in axes.T[values <= DEPENDENT * values.max(initial=0.0)]:
        for direction in (axis / sizes, -axis / sizes):
            load = pressed.impulse[2::3][closed]
            gives = direction < -PART * np.abs(direction).max()
            if not gives.any():
                continue
            share = pressed.impulse.copy()
            step = (load[gives] / -direction[gives]).min()
            share[3 * closed + 2] = np.maximum(load + step * direction, 0.0)
            P = _released(problem, share)
            if P is not None and all(
                _apart(problem, one, P, scale) for one in (solution.impulse, *found)
            ):
                P.setflags(write=False)
                found.append(P)
    if not found:
        return Finding(NOT_PROVEN, SHARED)
    return Finding(SEVERAL, SHARED, tuple(found), RULE_OF_SPLIT, settled=True)


def _released(problem: ContactProblem, share: np.ndarray) -> np.ndarray | None:
    """P of an impact without friction whose compression was shared so; None if it gains energy."""
    W, free = problem.delassus, problem.velocity_free
    P = share * (1.0 + np.repeat(problem.restitution, 3))
    rest = _without_release(problem, free + W @ P)
    P = P + rest.impulse
    work = 0.5 * P * (2.0 * free + W @ P)
    if not rest.status.valid or work.sum() > GAIN * np.abs(P * free).sum():
        return None
    return P


def _without_release(problem: ContactProblem, free: np.ndarray) -> ContactSolution:
    """What holds the normals of a problem without friction from this velocity."""
    from .simultaneous import solve_simultaneous

    none = np.zeros_like(problem.restitution)
    return solve_simultaneous(ContactProblem(problem.delassus, free, free, none, none, none), Law())


def _alone(
    problem: ContactProblem, solution: ContactSolution, search: _Search, *, newton: bool
) -> Finding:
    """What is to be said where no other was found."""
    if search.how == SMOOTH:
        return Finding(PROVEN, "nothing rubs: the problem is convex")
    if search.how == WEAK:
        return Finding(PROVEN, "friction feeds back weakly on the normal impulses")
    if search.how == ALL_TRIED and search.total:
        tried = CLOSED_FORM if len(problem.friction) == 1 else ALL_MODES
        return Finding(PROVEN, tried)
    shares = solution.unique is not None and not newton and problem.restitution.any()
    if search.how == SEARCHED and not shares:
        searched = "all modes were searched for directions of slip; no other v⁺ was found"
        return Finding(NOT_PROVEN, searched)
    mu = np.where(problem.friction > NEGLIGIBLE, problem.friction, 0.0)
    if search.how == TOO_MANY and not is_searched(mu, NEAR):
        rubbing = int(np.count_nonzero(mu))
        reason = (
            f"not searched: {rubbing} contacts with friction and {len(mu) - rubbing} without, not "
            "in one plane"
        )
        return Finding(NOT_PROVEN, reason)
    return Finding(NOT_PROVEN, "modes were searched, but not all ways to share a load")


def _apart(problem: ContactProblem, P: np.ndarray, other: np.ndarray, scale: float) -> bool:
    """Whether two impulses make different velocities."""
    return bool(np.abs(problem.delassus @ (P - other)).max() > SAME * scale)
