"""Right, said so, or silently wrong.

Errors are those of velocities: each speed counts by how fast it moves matter at most, so that
neither units nor masses decide. An answer that its status calls valid is right where the
largest error is below 1e-10, or below ten times condition times eps. All else that is called
valid is silently wrong. Ill-posed are answers for which that bound is above a thousandth: they
are right as well if what they leave of their equations is below 1e-14, and counted apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.truths.found import Exact, Found
from benchmarks.truths.numbers import EPS, SMALLEST

from .sweep import StateTruth

# In units of condition times eps.
BOUND = 10.0
# [of the largest speed] To which answers agree with exact ones, whatever their condition.
AGREED = 1e-10
# Where even that allows more than this share, no method can be told right from wrong.
ILL_POSED = 1e-3
# What is left of equations by rounding, relative to their terms.
BACKWARD = 1e-14


@dataclass(frozen=True)
class Judgement:
    """What is to be said of an answer; the numbers are those of ``Point``."""

    verdict: str
    error: float = math.inf
    condition: float = math.nan
    share: float = math.inf
    each: float = math.inf
    momentum: float = math.nan
    law: float = math.nan


def judge(state: StateTruth, exact: Exact | None, found: Found) -> tuple[Judgement, Exact | None]:
    """The judgement of an answer, and the truth it was held against.

    Args:
        state: the equations.
        exact: a solution of them, from a method before; None to look for one.
    """
    if found.dv is None or not np.isfinite(found.dv).all():
        condition = exact.condition if exact is not None else math.nan
        return Judgement("wrong" if found.valid else "said so", condition=condition), exact
    # A law may have more than one solution: the one that counts is beside the answer.
    if exact is None or (found.valid and _share(exact, found, state) > BOUND):
        exact = state.exact(found)
        if exact is not None and found.valid and _share(exact, found, state) > BOUND:
            beside = getattr(state, "exact_in_its_modes", lambda answer: None)(found)
            if beside is not None and _share(beside, found, state) <= BOUND:
                exact = beside
    left = state.residuals(found)
    met = left.momentum <= BACKWARD and left.law <= BACKWARD
    if exact is None:
        # Beyond what 50 digits tell apart: right if it answers a question that differs by rounding.
        verdict = "said so" if not found.valid else "right" if met else "wrong"
        return Judgement(verdict, math.nan, math.inf, momentum=left.momentum, law=left.law), None
    share = _share(exact, found, state)
    if share > BOUND and met and not exact.determined:
        # Of redundant impulses the truth has some; those of the answer obey the law.
        share = _share(replace(exact, violation=0.0), found, state)
    differences = np.abs(exact.dv - found.dv)
    error = _over(np.max(exact.weights * differences), exact.scale)
    wrong = (share > BOUND and not _agrees(exact, found, state, error)) or not exact.only
    if wrong and exact.condition * EPS * BOUND > ILL_POSED:
        # Rounding of the data alone changes the answer beyond first order: then it is right if
        # it answers a question that differs by rounding.
        wrong = not met
    return Judgement(
        "said so" if not found.valid else "wrong" if wrong else "right",
        error,
        exact.condition,
        share,
        max(
            _over(difference, EPS * slack + SMALLEST)
            for difference, slack in zip(differences, exact.slack, strict=True)
        ),
        left.momentum,
        left.law,
    ), exact


def _share(exact: Exact, found: Found, state: StateTruth) -> float:
    """The largest error over condition times eps, of speeds and of impulses."""
    worst = max(exact.violation, _largest(exact.dv, found.dv, exact.slack, exact.weights))
    impulses = _impulses(exact, found, state)
    if impulses is None:
        return worst
    return max(
        worst,
        _largest(exact.impulses, impulses, exact.impulses_slack, exact.impulses_weights),
    )


def _agrees(exact: Exact, found: Found, state: StateTruth, error: float) -> bool:
    """Return whether speeds, of this error, and impulses agree as far as is promised."""
    impulses = _impulses(exact, found, state)
    if impulses is None or exact.impulses is None:
        return error <= AGREED
    weights: Any = exact.impulses_weights
    off = np.max(weights * np.abs(exact.impulses - impulses))
    return max(error, _over(off, np.max(weights * np.abs(exact.impulses)))) <= AGREED


def _impulses(exact: Exact, found: Found, state: StateTruth) -> Any:
    """The impulses of an answer in the truth's axes; None where they are not comparable."""
    if exact.impulses is None or not exact.determined or not _all_unique(found):
        return None
    own_axes = getattr(state, "own_axes", None)
    return own_axes(found) if own_axes is not None else None


def _largest(exact: Any, found: Any, slack: Any, weights: Any) -> float:
    allowed = np.max(weights * (EPS * slack + SMALLEST))
    return _over(np.max(weights * np.abs(exact - found)), allowed)


def _all_unique(found: Found) -> bool:
    rows = found.rows is None or bool(np.isfinite(found.rows).all())
    return rows and (found.contacts_unique is None or all(found.contacts_unique))


def _over(difference: Any, size: Any) -> float:
    if not difference > 0:
        return 0.0
    return float(difference / size) if size > 0 else math.inf
