"""``solve``: one scene, one state, one impact."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import replace
from math import hypot, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..display import one_line
from ..errors import check_kind, warn_of_setup
from ..robot import state
from ..robot.arrays import FLOAT, real_numbers
from ..rows.reach import ReachedModel
from ..scene import Scene
from ..scene.at_time import scene_at
from ..scene.scene import KeptByThread
from .known import KnownImpulses
from .planning import planned, reached_by
from .result import Impact
from .yielding import YieldingControls, own_stops

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .constrained import ConstrainedJump
    from .outcome import Outcome

__all__ = ["ImpactSolver", "solve", "solve_touching", "solve_without_warnings"]

# So many numbers of a state are sooner squared by numpy than handed over one by one.
MANY = 100


class ImpactSolver:
    """The plan of a scene and its workspace; ``solve`` may be called any number of times.

    One solver belongs to one thread. ``impulsekit.solve`` keeps one per scene and thread.

    Attributes:
        scene: the scene.
        plan: what is computed, by which algorithm, and why.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> solver = ImpactSolver(scene)
        >>> solver.plan.algorithm
        'crba'
        >>> solver.solve(robot.neutral(), robot.velocity()).dv.shape
        (9,)
    """

    def __init__(self, scene: Scene) -> None:
        check_kind(scene, Scene, "solve")
        self.scene = scene_at(scene, 0.0)
        self._workspace = _Workspace(self.scene, as_given=self.scene is scene)
        self.plan = self._workspace.plan

    def __repr__(self) -> str:
        return one_line("ImpactSolver", repr(self.scene), algorithm=self.plan.algorithm)

    def solve(self, q: ArrayLike, v: ArrayLike) -> Impact:
        """The impact at configuration q (nq,) with velocity v (nv,) before it.

        Raises:
            ShapeError, NotFiniteError, StateError: q or v is not valid.
            SingularMassError: a joint moves no inertia at q.
        """
        return self._workspace.solve(self.scene, q, v)

    def solve_touching(self, q: ArrayLike, v: ArrayLike, touching: Container[int]) -> Impact:
        """The same where only some contacts take part: in a motion, those that meet now.

        Args:
            q: (nq,) configuration.
            v: (nv,) velocity before the impact.
            touching: indices of contacts in the scene. A plane counts as touched whatever
                the gap, a joint stop at its nearer limit, a collision where coal says so.

        Raises:
            As ``solve``.
        """
        return self._workspace.solve_touching(self.scene, q, v, touching)


class _Workspace:
    """All that a scene's solves share. It does not hold a user's scene, so that this can go.

    Args:
        scene: with velocities as they are at time 0.
        as_given: whether it is the user's; else it is what impacts are of.
    """

    def __init__(self, scene: Scene, *, as_given: bool) -> None:
        self._at_start = None if as_given else scene
        model = scene.robot.model
        self._model = model
        self._q_shape, self._v_shape = (model.nq,), (model.nv,)
        self._is_large = model.nq + model.nv >= MANY
        # Entries of q that lie on a circle or sphere exist only where nq > nv.
        self._has_unit_entries = model.nq > model.nv
        self._algorithm, self.plan, self._reached = planned(scene)
        self._has_rows = bool(scene.held or scene.contacts)
        # The way that takes any choice of contacts; made when a choice is first given.
        self._general: ConstrainedJump | None = None
        stops = own_stops(scene)
        self._yielding = YieldingControls(stops) if stops else None
        self._without: dict[tuple[str, ...], ImpactSolver] = {}
        # The commonest case, a robot alone on a fixed base, needs nothing in between.
        reached, as_given = self._reached, bool(self._reached and self._reached.is_as_given)
        self._jump_by_rows = self._constrained_jump
        self._velocity_jump: Callable[[np.ndarray], np.ndarray] = self._velocity_jump_of_reached
        if as_given and self._has_rows:
            self._jump_by_rows = self._algorithm.solve
        elif as_given:
            self._velocity_jump = self._algorithm.velocity_jump
        elif reached and not (self._has_rows or reached.whole) and reached.translations is None:
            self._velocity_jump = _jump_of_branches(self._algorithm, reached, model.nv)

    def solve(self, scene: Scene, q: ArrayLike, v: ArrayLike) -> Impact:
        """The impact at q and v, which are copied and checked."""
        scene = self._at_start or scene
        try:
            # Only what has to be converted can lose something on the way.
            plain = type(q) is np.ndarray and q.dtype is FLOAT
            q = np.array(q) if plain else real_numbers(q)
            plain = type(v) is np.ndarray and v.dtype is FLOAT
            v = np.array(v) if plain else real_numbers(v)
        except (TypeError, ValueError, OverflowError):
            state.checked_configuration(self._model, q)
            state.checked_velocity(self._model, v)
            raise
        if (
            q.shape != self._q_shape
            or v.shape != self._v_shape
            # One number that is not finite makes this so, too; squares would overflow.
            or not (_size_of_many(q, v) if self._is_large else hypot(*q.tolist(), *v.tolist()))
            < state.FASTEST
            or (
                self._has_unit_entries
                and not pin.isNormalized(self._model, q, state.QUATERNION_TOLERANCE)
            )
        ):
            q = state.checked_configuration(self._model, q)
            v = state.checked_velocity(self._model, v)
            if self._has_rows:
                state.refuse_overflow(v)
        if self._has_rows:
            if self._yielding is not None:
                freed = self._yielding.scene(scene, q, v)
                if freed is not scene:
                    return self._freed(freed).solve(q, v)
            return Impact(scene, q, v, *self._jump_by_rows(q, v))
        return Impact(scene, q, v, self._velocity_jump(q))

    def _freed(self, scene: Scene) -> ImpactSolver:
        """The solver of the scene with fewer controlled joints."""
        names = tuple(scene.controlled)
        if names not in self._without:
            self._without[names] = ImpactSolver(scene)
        return self._without[names]

    def solve_touching(
        self, scene: Scene, q: ArrayLike, v: ArrayLike, touching: Container[int]
    ) -> Impact:
        """The impact of some of the contacts; q and v are copied and checked."""
        scene = self._at_start or scene
        if not self._has_rows:
            return self.solve(scene, q, v)
        q = state.checked_configuration(self._model, q)
        v = state.checked_velocity(self._model, v)
        if self._yielding is not None:
            freed = self._yielding.scene(scene, q, v, touching)
            if freed is not scene:
                return self._freed(freed).solve_touching(q, v, touching)
        reached = self._reached
        own_v = v if reached.whole else v[reached.v_index]
        dv, outcome = self._of_some(scene).solve(reached.configuration(q), own_v, touching)
        if reached.whole:
            return Impact(scene, q, v, dv, outcome)
        return Impact(scene, q, v, self._spread(dv), self._widened(outcome))

    def _of_some(self, scene: Scene) -> ConstrainedJump:
        """The way that takes any choice of contacts."""
        if self._general is None:
            from .constrained import ConstrainedJump

            reached = reached_by(scene)
            self._general = ConstrainedJump(scene, KnownImpulses(scene, reached), reached)
        return self._general

    def _velocity_jump_of_reached(self, q: np.ndarray) -> np.ndarray:
        if self._algorithm is None:
            return np.zeros(self._v_shape)
        return self._spread(self._algorithm.velocity_jump(self._reached.configuration(q)))

    def _constrained_jump(
        self, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, Outcome | Callable[[], Outcome]]:
        reached = self._reached
        if reached.whole:
            return self._algorithm.solve(reached.configuration(q), v)
        dv_reached, outcome = self._algorithm.solve(reached.configuration(q), v[reached.v_index])
        return self._spread(dv_reached), lambda: self._widened(outcome)

    def _widened(self, outcome: Outcome | Callable[[], Outcome]) -> Outcome:
        """The outcome with its rows in the speeds of the whole robot."""
        if callable(outcome):
            outcome = outcome()
        touches = []
        for touch in outcome.touches:
            rows = np.zeros((3, self._v_shape[0]))
            rows[:, self._reached.v_index] = touch.jacobian
            touches.append(touch._replace(jacobian=rows))
        return replace(outcome, touches=tuple(touches))

    def _spread(self, dv_reached: np.ndarray) -> np.ndarray:
        """(nv,) Δv of the whole robot; what was not reached does not change."""
        if self._reached.whole:
            return dv_reached
        dv = np.zeros(self._v_shape)
        dv[self._reached.v_index] = dv_reached
        return dv


def _jump_of_branches(
    way: Any, reached: ReachedModel, nv: int
) -> Callable[[np.ndarray], np.ndarray]:
    """Δv (nv,) of the whole robot by a way on the branches reached, whose roots do not move."""
    q_index, v_index, zeros = reached.q_index, reached.v_index, np.zeros

    def velocity_jump(q: np.ndarray) -> np.ndarray:
        dv = zeros(nv)
        dv[v_index] = way.velocity_jump(q[q_index])
        return dv

    return velocity_jump


def solve(scene: Scene, q: ArrayLike, v: ArrayLike) -> Impact:
    """Solve the impact of a scene at one state: the velocity jump and all that follows from it.

    M Δv = I, with I the generalized impulse of the given impulses, the constraints and the
    contacts (Chang & Huston 1995, eqs. (18), (32)).

    Args:
        scene: the robot, its impulses, constraints and contacts, and the law of contact.
        q: (nq,) configuration, in Pinocchio's layout.
        v: (nv,) velocity before the impact.

    Raises:
        ShapeError, NotFiniteError, StateError: what is wrong with q or v.
        SingularMassError: a joint moves no inertia at q.

    Warns:
        SetupWarning: the first time a scene is solved, if ``Impact.doubts`` is not empty.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> impact = solve(scene, robot.neutral(), robot.velocity())
        >>> impact.is_valid()
        True
    """
    workspace = _workspaces.by_scene.get(id(scene))
    if workspace is None:
        from .doubts import doubts_of

        impact = _workspaces.of(scene).solve(scene, q, v)
        warn_of_setup(doubts_of(impact))
        return impact
    return workspace.solve(scene, q, v)


def solve_without_warnings(scene: Scene, q: Any, v: Any) -> Impact:
    """The same for a state out of many: none of them warns."""
    return _workspaces.of(scene).solve(scene, q, v)


def solve_touching(
    scene: Scene, q: np.ndarray, v: np.ndarray, touching: Container[int]
) -> Impact:  # fmt: skip
    """As ``ImpactSolver.solve_touching``, by the solver kept for the scene."""
    return _workspaces.of(scene).solve_touching(scene, q, v, touching)


def _size_of_many(q: np.ndarray, v: np.ndarray) -> float:
    """√(q·q + v·v), infinite where squares overflow."""
    with np.errstate(over="ignore", invalid="ignore"):
        return sqrt(q.dot(q) + v.dot(v))


_workspaces: KeptByThread[_Workspace] = KeptByThread(lambda scene: ImpactSolver(scene)._workspace)
