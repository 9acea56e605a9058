"""The contacts of a scene under its law: from rows and velocities to impulses."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..laws.status import Status
from ..laws.tolerances import GAIN, ROUNDING, ROUNDING_OF_SUMS
from ..robot.arrays import lock
from ..rows.contacts import ContactRows, Touch, ellipse_axis
from ..rows.reach import ReachedModel
from ..scene import Scene
from ..scene.contacts import turns
from ..scene.friction import is_plain, static_friction
from ..scene.restitution import restitution_at
from .singular import has_uneven_masses

if TYPE_CHECKING:
    from .contact_space import ContactProblem, ContactSolution
    from .contact_space.problem import Turning
    from .contact_space.refine import Steps

__all__ = ["SceneContacts", "with_work_of_rows"]


class SceneContacts:
    """The contacts of a scene: rows, coefficients and law.

    Attributes:
        rows: of the contacts.
        acts_at_once: whether contacts aim at velocities of before the constraints act, too
            (Newton's restitution, all at once): both together may then gain energy.
    """

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        from .contact_space import ContactProblem, find_impulses
        from .contact_space.problem import THROWN, is_thrown

        self._problem, self._solve = ContactProblem, find_impulses
        self._thrown, self._is_thrown = THROWN**2, is_thrown
        self.rows = ContactRows(scene, reached)
        self._uneven = has_uneven_masses(reached.model)
        self._law = law = scene.law
        self.acts_at_once = (law.restitution, law.slip, law.order) == (
            "newton",
            "end",
            "simultaneous",
        )
        self._restitution = [entry.restitution for entry in scene.contacts]
        self._varying = any(callable(e) for e in self._restitution)
        self._names = scene.entry_names("contacts")
        models = [getattr(entry, "friction", 0.0) for entry in scene.contacts]
        self._models = None if all(map(is_plain, models)) else models
        self._friction = np.array([static_friction(model) for model in models])
        self._tangential = np.array(
            [getattr(entry, "tangential_restitution", 0.0) for entry in scene.contacts]
        )
        self._stiffness = None
        if scene.law.restitution == "lzb":
            self._stiffness = np.array([entry.stiffness for entry in scene.contacts], dtype=float)
        self._adhesion = None
        if any(getattr(entry, "adhesion", 0.0) for entry in scene.contacts):
            self._adhesion = np.array([getattr(e, "adhesion", 0.0) for e in scene.contacts])
        self._resists = None
        if any(map(turns, scene.contacts)):
            self._resists = np.array(
                [
                    (getattr(entry, "rolling", 0.0), getattr(entry, "torsion", 0.0))
                    for entry in scene.contacts
                ]
            )
        # Nearly always each contact touches at one point.
        self._each_once = list(range(len(scene.contacts)))
        self._fixed = None if self._varying else np.array(self._restitution, dtype=float)
        lock(self._friction, self._tangential, self._fixed)

    def problem(
        self, half: np.ndarray, before: np.ndarray, free: np.ndarray, touches: list[Touch]
    ) -> ContactProblem:
        """The law's problem, for rows half-solved (nv, 3n) and velocities (3n,)."""
        entries, turning = [touch.entry for touch in touches], None
        if self._resists is not None:
            entries, turning = self._turning(touches, self._resists)
        friction, tangential = self._friction, self._tangential
        if entries != self._each_once:
            friction, tangential = friction[entries], tangential[entries]
        return self._problem(
            half.T.dot(half),
            before,
            free,
            self._coefficients(entries, before),
            friction,
            tangential,
            None if self._stiffness is None else self._stiffness[entries],
            None if self._adhesion is None else self._adhesion[entries],
            turning,
        )

    def _turning(self, touches: list[Touch], resists: np.ndarray) -> tuple[list[int], Turning]:
        """The entries of the points, and which of these resist turning."""
        from .contact_space.problem import Turning

        points = [touch.entry for touch in touches if touch.turns < 0]
        turned = [touch for touch in touches if touch.turns >= 0]
        rolling, torsion = resists[[touch.entry for touch in turned]].reshape(-1, 2).T
        return points, Turning(
            np.array([touch.turns for touch in turned], dtype=int), rolling, torsion
        )

    def _measured(
        self, problem: ContactProblem, models: list[Any], touches: list[Touch]
    ) -> ContactSolution:
        """P where friction is more than one number."""
        from .contact_space.measured_friction import solve_measured

        points = [touch for touch in touches if touch.turns < 0]
        return solve_measured(
            problem,
            self._law,
            [models[touch.entry] for touch in points],
            [ellipse_axis(models[touch.entry], touch) for touch in points],
            self._solve,
        )

    def solve(self, problem: ContactProblem, touches: list[Touch]) -> ContactSolution:
        """P by the law."""
        solution = (
            self._solve(problem, self._law)
            if self._models is None
            else self._measured(problem, self._models, touches)
        )
        return self.with_status(solution)

    def with_status(self, solution: ContactSolution) -> ContactSolution:
        """The solution; NEARLY_DEPENDENT for NOT_UNIQUE where masses are too uneven to tell."""
        if self._uneven and solution.status is Status.NOT_UNIQUE:
            # Beside grams and tonnes W does not tell rows that depend from rows that nearly do.
            return dataclasses.replace(solution, status=Status.NEARLY_DEPENDENT)
        return solution

    def plain_coefficients(self) -> np.ndarray | None:
        """(3, n) µ, e and tangential restitution; None where a law needs more or refuses them."""
        law, laws = self._law, ("newton", "poisson", "stronge")
        more = (self._models, self._adhesion, self._resists, self._stiffness)
        if self._fixed is None or any(m is not None for m in more) or law.restitution not in laws:
            return None
        if law.order == "simultaneous" and (law.slip != "end" or law.restitution == "stronge"):
            return None
        if not self.acts_at_once and self._tangential.any():
            return None
        return np.array([self._friction, self._fixed, self._tangential])

    def is_near(self, residual: float, off: float, fastest: float) -> bool:
        """Whether the law's residual and ``off``, J Δv − (u⁺ − u⁻) [m/s], are rounding errors."""
        rounding = ROUNDING if self._uneven else ROUNDING_OF_SUMS
        return residual <= ROUNDING and off <= rounding * fastest

    def is_met(
        self,
        problem: ContactProblem,
        solution: ContactSolution,
        jacobian: np.ndarray,
        dv: np.ndarray,
    ) -> bool:
        """Whether Δv makes the velocities of the law, and these obey it, but for rounding."""
        if not solution.residual <= ROUNDING:
            return False
        before = problem.velocity_before
        after = before + jacobian.dot(dv)
        rounding = ROUNDING if self._uneven else ROUNDING_OF_SUMS
        off = after - solution.velocity_after
        # Met in norms, which cost next to nothing, it is met in each row.
        most = max(before.dot(before), after.dot(after))
        least = most / len(before)
        free = problem.velocity_free
        if free.dot(free) > self._thrown * most and self._is_thrown(free, before, jacobian, dv):
            return False
        if off.dot(off) <= rounding**2 * least:
            return True
        size = max(np.abs(after).max(), np.abs(before).max())
        return self.is_near(solution.residual, float(np.abs(off).max()), float(size))

    def refined(
        self, problem: ContactProblem, solution: ContactSolution, dv: np.ndarray, steps: Steps
    ) -> tuple[ContactSolution, np.ndarray]:
        """The solution and Δv once more, from the velocities that Δv makes."""
        if problem.turning is not None or self._models is not None:
            return solution, dv
        if problem.adhesion is not None:
            from .contact_space.adhesive import refined_adhesive

            return refined_adhesive(problem, self._law, solution, dv, steps)
        from .contact_space.refine import refined

        return refined(problem, self._law, solution, dv, steps)

    def _coefficients(self, entries: list[int], before: np.ndarray) -> np.ndarray:
        if self._fixed is not None:
            return self._fixed if entries == self._each_once else self._fixed[entries]
        approach = np.maximum(-before[2 : 3 * len(entries) : 3], 0.0)
        return np.array(
            [
                restitution_at(
                    self._restitution[entry], float(speed), f"{self._names[entry]}: restitution"
                )
                for entry, speed in zip(entries, approach, strict=True)
            ]
        )


def with_work_of_rows(
    solution: ContactSolution,
    impulse: np.ndarray,
    before: np.ndarray,
    change: np.ndarray,
    by_blows: Callable[[], tuple[float, float]],
) -> ContactSolution:
    """The solution, or that the energy went up by what contacts and constraints add together.

    Args:
        impulse: (k,) of the bilateral rows that are brought to rest [N s].
        before, change: (k,) their velocities before the impact, and Δ of them [m/s].
        by_blows: gives Σ P·Δu/2 of all rows, where Δu is what blows alone would change, and
            Σ |P·u| with the velocities that they would leave [J].
    """
    if not solution.status.valid:
        return solution
    works = impulse * (before + 0.5 * change)
    own = solution.normal_work + solution.friction_work
    size = np.abs(impulse).dot(np.abs(before)) + np.abs(works).sum() + np.abs(own).sum()
    gain = float(works.sum() + own.sum())
    if not gain > GAIN * size:
        return solution
    change_of_work, more = by_blows()
    if not min(gain, gain + change_of_work) > GAIN * (size + more):
        return solution
    return dataclasses.replace(solution, status=Status.ENERGY_GAIN)
