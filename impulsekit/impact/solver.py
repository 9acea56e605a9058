"""``solve``: one scene, one state, one impact; ``outcomes``: all that it may end with."""

from __future__ import annotations

from collections.abc import Callable, Container
from functools import cached_property
from math import hypot, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, check_kind, warn_of_setup
from ..errors.calls import public
from ..formatting import one_line
from ..robot import state
from ..robot.arrays import FLOAT, real_numbers
from ..scene import Scene
from ..scene.impulses import impulse_numbers, with_numbers
from ..scene.scene import ThreadCache, scene_at
from .known import KnownImpulses
from .plan import Plan, needs_rows, plan_of
from .result import Impact
from .scene_jump import SceneJump, jump_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .all_outcomes import Outcomes

__all__ = ["ImpactSolver", "outcomes", "solve", "solve_without_warnings"]

# So many numbers of a state are sooner squared by numpy than handed over one by one.
MANY = 100


@public
class ImpactSolver:
    """The plan of a scene and its workspace; ``solve`` may be called any number of times.

    One solver belongs to one thread. ``impulsekit.solve`` keeps one per scene and thread.

    Attributes:
        scene: the scene.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> solver = ImpactSolver(scene)
        >>> solver.plan.algorithm
        'articulated'
        >>> solver.solve(robot.neutral(), robot.velocity()).dv.shape
        (9,)
    """

    def __init__(self, scene: Scene) -> None:
        check_kind(scene, Scene, "solve")
        self.scene = scene_at(scene, 0.0)
        self._workspace = _Workspace(self.scene, as_given=self.scene is scene)

    @cached_property
    def plan(self) -> Plan:
        """The plan: computations, their algorithms, and reasons."""
        return plan_of(self.scene)

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
    """All that a scene's solves share.

    Args:
        scene: with velocities as they are at time 0.
        as_given: whether it is the user's; else it is what impacts are of.

    Attributes:
        is_new: whether nothing was solved yet.
    """

    is_new = True

    def __init__(self, scene: Scene, *, as_given: bool) -> None:
        self._at_start = None if as_given else scene
        model = scene.robot.model
        self._model = model
        self._q_shape, self._v_shape = (model.nq,), (model.nv,)
        self._is_large = model.nq + model.nv >= MANY
        # Entries of q that lie on a circle or sphere exist only where nq > nv.
        self._has_unit_entries = model.nq > model.nv
        self._rows: SceneJump | None = None
        self._velocity_jump: Callable[..., np.ndarray] = self._no_jump
        if not needs_rows(scene):
            if plan_of(scene).algorithm != "none":
                self._velocity_jump = KnownImpulses(scene).velocity_jump
            return
        if scene.robot.massless_motions:
            # It refuses what is singular at every configuration.
            plan_of(scene)
        self._rows = jump_of(scene)

    def solve(self, scene: Scene, q: ArrayLike, v: ArrayLike, impulses: Any = None) -> Impact:
        """The impact at q and v, which are copied and checked."""
        scene = self._at_start or scene
        scene, numbers = (scene, None) if impulses is None else _with_impulses(scene, impulses)
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
            if self._rows is not None:
                state.refuse_overflow(v)
        if self._rows is not None:
            solved = self._rows.solve(scene, q, v, numbers=numbers)
            return Impact(solved.scene, q, v, solved.core.solution.dv, solved=solved)
        return Impact(scene, q, v, self._velocity_jump(q, numbers))

    def solve_touching(
        self,
        scene: Scene,
        q: ArrayLike,
        v: ArrayLike,
        touching: Container[int],
    ) -> Impact:
        """The impact of some of the contacts; q and v are copied and checked."""
        scene = self._at_start or scene
        if self._rows is None:
            return self.solve(scene, q, v)
        q = state.checked_configuration(self._model, q)
        v = state.checked_velocity(self._model, v)
        solved = self._rows.solve(scene, q, v, touching)
        return Impact(solved.scene, q, v, solved.core.solution.dv, solved=solved)

    def _no_jump(self, q: np.ndarray, numbers: np.ndarray | None) -> np.ndarray:
        return np.zeros(self._v_shape)


def _with_impulses(scene: Scene, impulses: Any) -> tuple[Scene, np.ndarray]:
    """The scene with other numbers of its known impulses, and these (columns,)."""
    names = scene.entry_names("impulses")
    numbers = impulse_numbers(scene.impulses, names, impulses)
    if len(numbers) > 1:
        raise InputError(f"impulses: one state takes one row, got {len(numbers)}; see solve_batch")
    return scene.with_numbers(with_numbers(scene.impulses, numbers[0])), numbers[0]


@public
def solve(scene: Scene, q: ArrayLike, v: ArrayLike, *, impulses: Any = None) -> Impact:
    """Solve the impact of a scene at one state: the velocity jump and all that follows from it.

    M Δv = I, with I the generalized impulse of the given impulses, the constraints and the
    contacts (Chang & Huston 1995, eqs. (18), (32)).

    Args:
        scene: the robot, its impulses, constraints and contacts, and the law of contact.
        q: (nq,) configuration, in Pinocchio's layout.
        v: (nv,) velocity before the impact.
        impulses: numbers in place of those of the scene's known impulses, as in ``solve_batch``:
            (6,) or (3,), the force impulse alone, for an ``AppliedImpulse``, (k,) for a
            ``JointImpulse``; by name, or of one impulse alone as it is. The scene's plan is kept.

    Raises:
        ShapeError, NotFiniteError, StateError: what is wrong with q or v.
        UnknownNameError, ShapeError, NotFiniteError, InputError: what is wrong with impulses.
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
    check_kind(scene, Scene, "solve")
    workspace = _workspaces.of(scene)
    is_new, workspace.is_new = workspace.is_new, False
    impact = workspace.solve(scene, q, v, impulses)
    if is_new:
        from .doubts import doubts_of

        warn_of_setup(doubts_of(impact))
    return impact


@public
def outcomes(
    scene: Scene, q: ArrayLike, v: ArrayLike, *, samples: int = 4096, seed: int = 0
) -> Outcomes:
    """Return the v⁺ that the impact may end with when contacts compress in any order and shares.

    Rigid bodies that are hit at several points have no single answer: a law chooses one.

    Args:
        scene: with contacts. q, v: (nq,), (nv,) the state before.
        samples: how many processes are followed.
        seed: sample k depends on it and k alone, not on the number of threads.

    Raises:
        ShapeError, NotFiniteError, StateError: q or v.
        RangeError: samples below 1, a seed below 0.
        InputError: nothing touches; contacts with adhesion, rolling, torsion, tangential
            restitution, or friction that is no number; a law that the contacts do not accept.

    Example:
        >>> from impulsekit import Contact, Robot, Scene
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = Contact("ball", at=[0, 0, -0.1], friction=0.3)
        >>> scene = Scene(ball, contacts=[floor], gap_bound=1)
        >>> found = outcomes(scene, ball.neutral(), [1, 0, -2, 0, 0, 0], samples=16)
        >>> found.bounds[:, 0].round(9).tolist()
        [0.909090909, 0.909090909]
    """
    from .all_outcomes import outcomes_of

    return outcomes_of(solve(scene, q, v), samples, seed)


def solve_without_warnings(scene: Scene, q: Any, v: Any) -> Impact:
    """The same for a state out of many: none of them warns."""
    workspace = _workspaces.of(scene)
    workspace.is_new = False
    return workspace.solve(scene, q, v)


def _size_of_many(q: np.ndarray, v: np.ndarray) -> float:
    """√(q·q + v·v), infinite where squares overflow."""
    with np.errstate(over="ignore", invalid="ignore"):
        return sqrt(q.dot(q) + v.dot(v))


_workspaces: ThreadCache[_Workspace] = ThreadCache(lambda scene: ImpactSolver(scene)._workspace)
