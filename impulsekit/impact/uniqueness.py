"""Uniqueness of v⁺ under the law of contact, and the choice that is shown."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..formatting import Displayed
from ..scene.coefficients import restitution_at

if TYPE_CHECKING:
    from .answer import Answer
    from .contact_law import ContactProblem

__all__ = ["Uniqueness", "problem_of", "uniqueness_of"]


@dataclass(frozen=True, eq=False, repr=False)
class Uniqueness(Displayed):
    """A finding on whether v⁺ is the only one that the law allows and that gains no energy.

    Attributes:
        verdict: "proven" (no other v⁺ obeys the law and gains no energy), "not proven" (none was
            found, or not looked for), or "several".
        reason: what proves it, what was tried, or what leaves it open.
        others: (nv,) each, further v⁺ that obey the law and gain no energy; of a continuum
            its extremes. Empty unless there are several.
        rule: by which the one shown is chosen among several; it knows no axes, units or order
            of entries. "" unless there are several.
    """

    verdict: str
    reason: str
    others: tuple[np.ndarray, ...] = ()
    rule: str = ""

    @property
    def proven(self) -> bool:
        """True if it is proven that no other v⁺ obeys the law and gains no energy."""
        return self.verdict == "proven"

    @property
    def several(self) -> bool:
        """True if other v⁺ were found."""
        return self.verdict == "several"

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "verdict": self.verdict,
            "reason": self.reason,
            "others": [other.tolist() for other in self.others],
            "rule": self.rule,
        }


def uniqueness_of(impact: Answer) -> Uniqueness:
    """The uniqueness of an impact's v⁺ under the scene's law."""
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return Uniqueness("proven", "no contact took part")
    if any(touch.turns >= 0 for touch in outcome.touches):
        return Uniqueness(
            "not proven", "other solutions are not searched for contacts with rolling or torsion"
        )
    if outcome.contacts.friction is not None:
        return Uniqueness(
            "not proven", "other solutions are not searched for friction other than a number"
        )
    solution = outcome.contacts
    from .contact_law import find_others

    jacobian = np.vstack([touch.jacobian for touch in outcome.touches])
    moved, _, delassus = impact.mechanics.responses(jacobian)
    problem = problem_of(impact, jacobian, delassus)
    if problem.adhesion is not None:
        # What adheres is pulled first, and then pushed by P + A.
        pull = np.zeros(len(solution.impulse))
        pull[2::3] = problem.adhesion
        problem = replace(
            problem, velocity_free=problem.velocity_free - problem.delassus @ pull, adhesion=None
        )
        solution = replace(solution, impulse=solution.impulse + pull)
    found = find_others(problem, impact.scene.law, solution)
    others = []
    for P in found.impulses:
        v = impact.v_after + moved @ (P - solution.impulse)
        v.setflags(write=False)
        others.append(v)
    return Uniqueness(found.verdict, found.reason, tuple(others), found.rule)


def problem_of(impact: Answer, jacobian: np.ndarray, delassus: np.ndarray) -> ContactProblem:
    """The contact problem of an impact, from the rows that it keeps."""
    from .contact_law import ContactProblem

    outcome, scene = impact.outcome, impact.scene
    if outcome is None or outcome.contacts is None:
        raise ValueError("no contact touched")
    entries = [scene.contacts[touch.entry] for touch in outcome.touches]
    names = scene.entry_names("contacts")
    before, after = jacobian @ impact.v_before, jacobian @ impact.v_after
    approach = np.maximum(-before[2::3], 0.0).tolist()
    restitution = [
        restitution_at(entry.restitution, speed, f"{names[touch.entry]}: restitution")
        for entry, speed, touch in zip(entries, approach, outcome.touches, strict=True)
    ]
    pulls = [getattr(entry, "adhesion", 0.0) for entry in entries]
    stiffness = [getattr(entry, "stiffness", None) or 0.0 for entry in entries]
    symmetric = 0.5 * (delassus + delassus.T)
    return ContactProblem(
        symmetric,
        before,
        after - symmetric @ outcome.contacts.impulse,
        np.array(restitution, dtype=float),
        np.array([getattr(entry, "friction", 0.0) for entry in entries]),
        np.array([getattr(entry, "tangential_restitution", 0.0) for entry in entries]),
        stiffness=np.array(stiffness) if all(stiffness) else None,
        adhesion=np.array(pulls) if any(pulls) else None,
    )
