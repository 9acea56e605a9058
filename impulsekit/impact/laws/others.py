"""Whether a contact problem has other velocities that obey the law, and which are shown."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...laws.status import Status
from ...laws.uniqueness import (
    ALL_TRIED,
    SAME,
    SEARCHED,
    SMOOTH,
    SURE,
    TOO_MANY,
    WEAK,
    Search,
    is_another,
    search_answers,
)
from ...scene.law import Law
from .problem import ContactProblem, ContactSolution

__all__ = ["NOT_PROVEN", "PROVEN", "SEVERAL", "Finding", "find_others", "told_if_several"]

PROVEN, NOT_PROVEN, SEVERAL = "proven", "not proven", "several"

RULE = (
    "the one reached from sticking: all contacts are held still first, and what cannot hold is "
    "let go; an answer in which nothing slips is shown wherever there is one"
)
RULE_OF_PARTING = "a contact that parts gets no impulse"
RULE_OF_TIES = "of contacts that are alike in speed and all else, the first entry is hit first"
RULE_OF_SPLIT = (
    "the compression of least Σ w |P|², w being the mobility of each contact (of one contact the "
    "least friction impulse); what is given back is e times its load"
)
# What an answer that is told of may leave of the law, relative to the velocities.
LAWFUL = 1e-10
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
        return Finding(NOT_PROVEN, "of contacts that resist rolling or spin none were searched")
    n = len(problem.friction)
    if law.order == "sequential" and n > 1:
        if solution.tied:
            return _of_a_tie(problem, law, solution)
        return _of_hits(solution, "contacts are struck one after the other, each in closed form")
    if law.restitution == "lzb" and n > 1:
        return _of_hits(solution, "impulses are followed from where contacts touch, step by step")
    if law.slip == "path":
        return _of_hits(solution, "slip is followed along the impact, step by step")
    scale = max(
        float(np.abs(problem.velocity_before).max()), float(np.abs(solution.velocity_after).max())
    )
    if not scale:
        return Finding(PROVEN, "nothing moves")
    if n == 1 and _is_closed_form(problem, solution):
        return Finding(PROVEN, "one contact, solved in closed form")
    newton = law.restitution == "newton"
    search = _search(problem, solution.impulse, scale, newton=newton)
    others: list[np.ndarray] = []
    for P in search.impulses:
        W, start = problem.delassus, problem.velocity_before if newton else problem.velocity_free
        if all(
            is_another(W, P, other, start, problem.velocity_free, scale)
            for other in (solution.impulse, *others)
        ):
            P.setflags(write=False)
            others.append(P)
    if not others:
        return _alone(problem, solution, search, newton=newton)
    if _is_split(problem, search, scale):
        reason = "the compression's load may be shared in many ways, and e times it comes back"
        return Finding(SEVERAL, reason, tuple(others), RULE_OF_SPLIT, settled=True)
    if n == 1 and not solution.impulse.any():
        reason = "the contact parts, and friction could press it in as well"
        return Finding(SEVERAL, reason, tuple(others), RULE_OF_PARTING, settled=True)
    reason = f"{len(others) + 1} v⁺ obey the law and gain no energy"
    return Finding(SEVERAL, reason, tuple(others), RULE)


def _of_a_tie(problem: ContactProblem, law: Law, solution: ContactSolution) -> Finding:
    """What comes if of contacts that are alike the last entry is hit first."""
    from .sequential import solve_sequential

    back = np.arange(len(problem.friction))[::-1]
    rows = (3 * back[:, None] + np.arange(3)).ravel()
    turned = solve_sequential(
        ContactProblem(
            np.ascontiguousarray(problem.delassus[np.ix_(rows, rows)]),
            problem.velocity_before[rows],
            problem.velocity_free[rows],
            problem.restitution[back],
            problem.friction[back],
            problem.tangential_restitution[back],
        ),
        law,
    )
    scale = float(np.abs(problem.velocity_before).max())
    P = turned.impulse[np.argsort(rows)]
    if not turned.status.valid or not _apart(problem, solution.impulse, P, scale):
        return Finding(NOT_PROVEN, "contacts approach equally fast and are alike")
    P.setflags(write=False)
    reason = "contacts approach equally fast and are alike; another may be hit first"
    return Finding(SEVERAL, reason, (P,), RULE_OF_TIES, settled=True)


def _of_hits(solution: ContactSolution, reason: str) -> Finding:
    if solution.status is Status.MANY_SOLUTIONS:
        return Finding(SEVERAL, "a hit has several solutions", rule=RULE)
    return Finding(PROVEN, reason)


def _is_closed_form(problem: ContactProblem, solution: ContactSolution) -> bool:
    """Whether the closed form of one contact knows all solutions."""
    mu = problem.friction.item()
    if solution.status is Status.MANY_SOLUTIONS or solution.unique is not None:
        return not mu
    W = problem.delassus
    # Where it parts and friction cannot press it in, W_nn ≥ µ |W_nt|, there is no other.
    parts = not solution.impulse.any()
    return not (parts and W[2, 2] < mu * math.hypot(W[2, 0], W[2, 1]) * (1.0 + SURE))


def _search(problem: ContactProblem, shown: np.ndarray, scale: float, *, newton: bool) -> Search:
    aim, before, release = problem.velocity_free, problem.velocity_before, None
    if newton:
        aim = aim.copy()
        aim[2::3] += problem.restitution * np.minimum(before[2::3], 0.0)
        aim[0::3] += problem.tangential_restitution * before[0::3]
        aim[1::3] += problem.tangential_restitution * before[1::3]
    elif problem.restitution.any():
        release = problem.restitution
    search = search_answers(problem.delassus, aim, problem.friction, scale, release)
    if search.how not in (SEARCHED, TOO_MANY):
        return search
    pressed = search
    if release is not None:
        # In space: all compressions that can be found, and of each the expansion from it.
        pressed = search_answers(problem.delassus, aim, problem.friction, scale)
    if pressed.how == SEARCHED:
        known = [np.zeros_like(aim), shown, *pressed.impulses]
        held = _held(problem.delassus, aim, problem.friction, known)
        pressed = pressed._replace(impulses=np.array([*pressed.impulses, *held]))
    if release is None:
        return pressed
    pairs = [pair for P in pressed.impulses if (pair := _with_expansion(problem, P)) is not None]
    if not pairs:
        return search
    return pressed._replace(
        impulses=np.array([P + back for P, back in pairs]),
        compressions=np.array([P for P, _ in pairs]),
    )


def _held(
    W: np.ndarray, aim: np.ndarray, mu: np.ndarray, known: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """(3n,) P that hold some redundant contacts still, the others being as in a known answer.

    The modes take one share of a redundant load; the cones may ask for another.
    """
    from .frictional import is_redundant, rubbing
    from .modes import Modes
    from .split import least_holding

    W, aim = rubbing(W, aim, mu)
    modes = Modes(W, aim, mu, None)
    found = []
    for chosen in itertools.product((True, False), repeat=len(mu)):
        rows = np.flatnonzero(np.repeat(chosen, 3))
        block = np.ascontiguousarray(W[np.ix_(rows, rows)])
        if not len(rows) or not is_redundant(block):
            continue
        for P in known:
            P = P.copy()
            P[rows] = 0.0
            moved = aim[rows] + W[rows] @ P
            P[rows] = least_holding(Modes(block, moved, mu[list(chosen)], None))
            if P[rows].any() and modes.residual(P) <= LAWFUL:
                found.append(P)
    return found


def _with_expansion(
    problem: ContactProblem, compression: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """(3n,) P of a compression, shared as the law shares it, and of its expansion, if found."""
    from .frictional import solve_frictional

    W, free, mu = problem.delassus, problem.velocity_free, problem.friction
    fastest = float(np.abs(free).max())
    pressed = solve_frictional(W, free, mu, None, compression, least=True).impulse
    floor = problem.restitution * pressed[2::3]
    start = np.repeat(problem.restitution, 3) * pressed
    back = solve_frictional(W, free + W @ pressed, mu, floor, start, fastest, least=True)
    return (pressed, back.impulse) if back.status.valid else None


def _alone(
    problem: ContactProblem, solution: ContactSolution, search: Search, *, newton: bool
) -> Finding:
    """What is to be said where no other was found."""
    if search.how == SMOOTH:
        return Finding(PROVEN, "nothing rubs: the problem is convex")
    if search.how == WEAK:
        return Finding(PROVEN, "friction feeds back weakly on the normal impulses")
    if search.how == ALL_TRIED and len(search.impulses):
        return Finding(PROVEN, "all modes of the contacts in the plane were tried")
    shares = solution.unique is not None and not newton and problem.restitution.any()
    if search.how == SEARCHED and not shares:
        searched = "all modes were searched for directions of slip; no other v⁺ was found"
        return Finding(NOT_PROVEN, searched)
    return Finding(NOT_PROVEN, f"the modes of {len(problem.friction)} contacts were not searched")


def _apart(problem: ContactProblem, P: np.ndarray, other: np.ndarray, scale: float) -> bool:
    """Whether two impulses make different velocities."""
    return bool(np.abs(problem.delassus @ (P - other)).max() > SAME * scale)


def _is_split(problem: ContactProblem, search: Search, scale: float) -> bool:
    """Whether the solutions have one velocity at the end of compression, and one v⁺ each."""
    pressed = search.compressions
    if pressed is None:
        return False
    W = problem.delassus
    if np.abs((pressed - pressed[0]) @ W).max() > SAME * scale:
        return False
    for i, one in enumerate(pressed):
        for j in range(i):
            alike = np.abs(W.diagonal() * (one - pressed[j])).max() <= SAME * scale
            if alike and _apart(problem, search.impulses[i], search.impulses[j], scale):
                return False
    return True
