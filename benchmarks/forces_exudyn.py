"""Peak force of an impact, beside Exudyn's spring in place of the contact, to 1 %.

As ``forces`` does it with MuJoCo: Exudyn begins at the instant of touch and ends with the contact,
in the fewest steps of its quickest explicit solver that keep the peak within 1 %; the time to
read forces off its states is not counted.
"""

from __future__ import annotations

import numpy as np

from .forces import ALLOWED, MOST, STATES, STRUCK, many_peaks, one_peak, spring_of, spring_peak
from .methods.exudyn_touch import add_touch
from .methods.exudyn_tree import ExudynTree, exudyn_settings
from .methods.mechanism import mechanism_of
from .methods.mujoco_model import CONTACT_TIME
from .methods.swing import normal_rows
from .problems.problem import Problem
from .timing import Times, in_turn

__all__ = ["batch_of_forces", "single_forces"]

# Of the sphere that touches [m]: far more than it goes in.
RADIUS = 0.05
# Exudyn's states are run one after the other: so many stand for all.
THEIR_STATES = 16
FEWEST, ROUNDS = 3, 21


def single_forces(name: str) -> Times:
    """One state after the other: ``solve`` and ``force_history`` against a run of steps."""
    problem = STRUCK[name]()
    theirs = _Theirs(problem)
    return in_turn(one_peak(problem), lambda: theirs.run(1.0))


def batch_of_forces(name: str) -> Times:
    """Many states on one thread: ``peak_forces`` against a run for each."""
    problem = STRUCK[name]()
    theirs, factors = _Theirs(problem), np.linspace(0.5, 2.0, STATES)
    own = factors[:: STATES // THEIR_STATES]
    ours = many_peaks(problem, factors[:, None] * problem.v)
    return in_turn(ours, lambda: [theirs.run(factor) for factor in own], STATES, len(own), ROUNDS)


class _Theirs:
    """The same contact in Exudyn, and the fewest steps that keep the peak within 1 %.

    Attributes:
        steps: how many they take in and out.
    """

    def __init__(self, problem: Problem) -> None:
        import exudyn as exu

        mechanism = mechanism_of(problem)
        tree = ExudynTree(mechanism)
        # The container owns what the system is in.
        self._container, self._system, item = tree.system(mechanism.v)
        add_touch(
            self._system,
            tree,
            mechanism,
            item,
            mechanism.touches[0],
            RADIUS,
            dynamicFriction=0.0,
            contactStiffness=spring_of(problem).stiffness,
            restitutionCoefficient=1.0,
            impactModel=0,
        )
        self._system.Assemble()
        self._data, self._v = self._system.systemData, mechanism.v
        self._now, self._start = exu.ConfigurationType.Current, exu.ConfigurationType.Initial
        self._solver = exu.DynamicSolverType.RK44
        rows, inverse = normal_rows(problem, mechanism)
        mass, peak = 1.0 / float(rows[0] @ inverse @ rows[0]), spring_peak(problem)
        for self.steps in range(FEWEST, MOST):
            step = CONTACT_TIME / self.steps
            speeds = [float(rows[0] @ mechanism.v)]
            for count in range(1, self.steps + 1):
                self._settings = exudyn_settings(step, count)
                speeds.append(float(rows[0] @ self.run(1.0)))
            if abs(np.abs(np.diff(speeds)).max() * mass / step / peak - 1.0) <= ALLOWED:
                break

    def run(self, factor: float) -> np.ndarray:
        """(nv,) the velocities at the end, from so many times those of the problem."""
        self._data.SetODE2Coordinates_t(factor * self._v, self._start)
        self._system.SolveDynamic(self._settings, solverType=self._solver, showHints=False)
        return np.array(self._data.GetODE2Coordinates_t(self._now))
