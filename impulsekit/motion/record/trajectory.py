"""``Trajectory``: a motion, its impacts, and what follows from it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ...display import Displayed, one_line
from ...errors import RangeError, ShapeError
from ...impact.named import ByName
from ...laws.status import Status
from ...robot.arrays import read_only
from ...scene.motion import MotionSettings
from ...scene.numbers import number
from . import histories
from .path import Path
from .status import MotionStatus

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...impact import Impact
    from ...scene import Scene
    from .balance import MomentumBalance
    from .comparing import Comparison, Recorded
    from .energies import EnergyHistory, MomentumHistory
    from .histories import ConstraintHistory, ContactHistory, ForceHistory, JointHistory
    from .loads import LoadsOfMotion

__all__ = ["Rest", "Trajectory"]


@dataclass(frozen=True)
class Rest:
    """A contact that lay still against what it touches, for a while.

    Attributes:
        contact: the entry's name.
        start, end: [s]; ``end`` is infinite where it was still at rest when the motion ended.
    """

    contact: str
    start: float
    end: float


class Trajectory(Displayed):
    """The motion of a robot, as returned by ``impulsekit.simulate``.

    Attributes:
        scene: the scene.
        t: (T,) sample times [s].
        q: (T, nq) configurations; v: (T, nv) velocities. Where an impact happens at a
            sample, they are the values just after it.
        impacts: (time [s], ``Impact``) in order of time.
        rests: the intervals in which contacts were at rest.
        status: how the motion ended; the part computed until then is always kept.
        settings: the method, tolerances and limits of the simulation.
        steps: number of integrator steps.
        evaluations: number of evaluations of the accelerations.

    Example:
        >>> from impulsekit import Robot, Scene, simulate
        >>> panda = Robot.from_example("panda")
        >>> motion = simulate(Scene(panda), panda.neutral(), panda.velocity(), duration=0.1)
        >>> motion.q.shape, motion.status.finished
        ((201, 9), True)
    """

    def __init__(
        self,
        scene: Scene,
        t: np.ndarray,
        path: Path,
        impacts: tuple[tuple[float, Impact], ...],
        rests: tuple[Rest, ...],
        status: MotionStatus,
        settings: MotionSettings,
        *,
        detail: str = "",
        steps: int = 0,
        evaluations: int = 0,
    ) -> None:
        self.scene = scene
        self.t = read_only(t)
        self.impacts = impacts
        self.rests = rests
        self.status, self.settings = status, settings
        self.detail = detail
        self.steps = steps
        self.evaluations = evaluations
        self._path = path

    @cached_property
    def q(self) -> np.ndarray:
        """(len(t), nq) the configurations at the samples."""
        own = [q for q, _ in self._states]
        return read_only(np.array(own).reshape(len(self.t), self.scene.robot.nq))

    @cached_property
    def v(self) -> np.ndarray:
        """(len(t), nv) the velocities at the samples."""
        own = [v for _, v in self._states]
        return read_only(np.array(own).reshape(len(self.t), self.scene.robot.nv))

    @cached_property
    def _states(self) -> list[tuple[np.ndarray, np.ndarray]]:
        return [self._path.state(time) for time in self.t.tolist()]

    @cached_property
    def several(self) -> tuple[tuple[float, Impact], ...]:
        """(time [s], ``Impact``) of the impacts at which the law leaves several v⁺ open.

        The motion is one of those that the law allows; computed on first access, from
        ``Impact.uniqueness``.
        """
        return tuple(hit for hit in self.impacts if hit[1].status is Status.MANY_SOLUTIONS)

    @property
    def duration(self) -> float:
        """The time up to which the motion was followed [s]."""
        return float(self._path.end)

    @cached_property
    def contacts(self) -> ByName[ContactHistory]:
        """By the name of a contact: its impacts, and its forces while it rested.

        ``motion.contacts["floor"]`` is the tuple of (time [s], ``ContactResult``) of each impact
        in which it touched, and has ``force(t)``, ``points(t)``, ``impulse``, ``work``.

        Raises:
            UnknownNameError: on a name that no contact of the scene has.
        """
        return ByName(histories.of_contacts(self), "contact")

    @cached_property
    def constraints(self) -> ByName[ConstraintHistory]:
        """By the name of a constraint: its impacts, and its forces between them.

        Raises:
            UnknownNameError: on a name that no constraint of the scene has.
        """
        return ByName(histories.of_constraints(self), "constraint")

    @cached_property
    def forces(self) -> ByName[ForceHistory]:
        """By the name of a spring, actuator or applied force: what it gave, and its work.

        Raises:
            UnknownNameError: on a name that no force of the scene has.
        """
        return ByName(histories.of_forces(self), "force")

    @cached_property
    def joints(self) -> ByName[JointHistory]:
        """By the name of a joint: what it transmits, ``motion.joints["knee"].reaction(t)``.

        Raises:
            UnknownNameError: on a name that no joint of the robot has.
        """
        return ByName(histories.of_joints(self), "joint")

    def balance(self, start: float | None = None, end: float | None = None) -> MomentumBalance:
        """Where the momentum came from between two times: forces, and impulses of impacts.

        Args:
            start: after an impact at that time [s]; None for the beginning, before its impacts.
            end: after an impact at that time [s]; None for the end of the motion.

        Raises:
            RangeError: times outside the motion.

        Example:
            >>> from impulsekit import Contact, Robot, Scene, simulate
            >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
            >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5, name="floor")])
            >>> drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
            >>> balance = simulate(scene, drop, ball.velocity(), duration=1).balance()
            >>> round(float(balance.shares["weight"][2] / ball.mass), 9)
            -9.81
            >>> bool(abs(balance.residual).max() < 1e-8)
            True
        """
        from .balance import momentum_balance

        return momentum_balance(self, start, end)

    @cached_property
    def loads(self) -> LoadsOfMotion:
        """All forces of the motion, worked out where they are asked for."""
        from .loads import LoadsOfMotion

        return LoadsOfMotion(self.scene, self._path)

    def checked_times(self, t: ArrayLike) -> np.ndarray:
        """Times of the motion [s], a number or (T,), as an array.

        Raises:
            RangeError, NotFiniteError, ShapeError: no times of this motion.
        """
        if np.ndim(t) > 1:
            raise ShapeError.of("times", ("T",), np.shape(t))
        return np.array([self.checked_time(one) for one in np.atleast_1d(t)])

    def checked_span(self, start: float | None, end: float | None) -> tuple[float, float]:
        """A span of time of the motion [s]; None for its beginning or its end.

        Raises:
            RangeError: it is none.
        """
        a = 0.0 if start is None else self.checked_time(start)
        b = self.duration if end is None else self.checked_time(end)
        if a > b:
            raise RangeError.of("start", start, f"at most the end, {b:g} s")
        return a, b

    @property
    def step_times(self) -> np.ndarray:
        """(S,) where the integrator's steps began [s]."""
        return self._path.step_times

    def at(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """q (nq,) and v (nv,) at any time, to the integrator's accuracy.

        At the time of an impact: just after it. For times (T,) q is (T, nq) and v (T, nv).

        Raises:
            RangeError: before the start or after the end.
            NotFiniteError, ShapeError: no time, or no list of times.
        """
        if np.ndim(t) == 0:
            return self._path.state(self.checked_time(cast(float, t)))
        if np.ndim(t) != 1:
            raise ShapeError.of("times", ("T",), np.shape(t))
        states = [self._path.state(self.checked_time(one)) for one in np.asarray(t)]
        robot = self.scene.robot
        return (
            np.array([q for q, _ in states]).reshape(-1, robot.nq),
            np.array([v for _, v in states]).reshape(-1, robot.nv),
        )

    def checked_time(self, t: float) -> float:
        """A time of the motion [s], as a number.

        Raises:
            RangeError, NotFiniteError: no time of this motion.
        """
        # NaN and infinity are no times of this motion, either.
        time = float(t) if isinstance(t, float | np.floating) else number(t, "time")
        if not 0.0 <= time <= self.duration:
            raise RangeError.of("time", t, f"0 to {self.duration:g} s")
        return time

    def energy(self) -> EnergyHistory:
        """Kinetic and potential energies at the sample times."""
        from .energies import energies_of

        return energies_of(self)

    def momentum(self) -> MomentumHistory:
        """Linear and angular momentum at the sample times, the latter about the world's origin."""
        from .energies import momenta_of

        return momenta_of(self)

    def compare(self, recording: Recorded, frame: str | None = None) -> Comparison:
        """How far a frame is from where a recording has it, and how far turned, over time.

        Args:
            recording: a ``Recording`` (times and configurations of a log, of a camera), or another
                ``Trajectory``, of the same robot; what is outside the motion's time is left out.
            frame: whose; by default the first link that moves.

        Raises:
            InputError: no recording of this robot.
            RangeError: none of its times is within the motion.
            UnknownNameError: no such frame.
        """
        from .comparing import compare

        return compare(self, recording, frame)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to an npz file of plain arrays and text; see ``motion.archive``.

        ``t``, ``q`` and ``v`` are readable by numpy alone. The scene stands in it as the
        text of a scene file, the URDFs in full. What no scene file can hold, a function or
        a robot made from a ``pin.Model``, has to be given to ``load``.

        Raises:
            OSError: nothing can be written there.
        """
        from .saved import save_motion

        save_motion(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str], scene: Scene | None = None) -> Trajectory:
        """Read what ``save`` wrote; nothing in the file is run.

        Args:
            path: the file.
            scene: the scene of the motion; wanted only where the file cannot hold it.

        Raises:
            InputError: no trajectory, one without its scene, or one of another robot.
            OSError: it cannot be read.
        """
        from .saved import load_motion

        return load_motion(path, scene)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over time: q, v by coordinate name, energies, momenta.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from .tables import state_table

        return state_table(self)

    def events(self) -> Any:
        """An ``xarray.Dataset`` of the impacts (by contact: impulse, mode) and of the rests.

        Along "impact" stand the time, the status, the energy before and its change, and by
        "contact" whether it touched, its mode, and its impulse on the first body in world axes
        [N s]; a joint stop has its one number first, and NaN. Along "rest" stand what rested,
        from when to when; an end that is infinite is after the motion.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from .tables import event_table

        return event_table(self)

    def __getstate__(self) -> dict[str, Any]:
        # Between samples the path of a copy is its interpolant.
        _ = self.q, self.v
        state = dict(vars(self))
        for made in (
            "_states",
            "contacts",
            "constraints",
            "forces",
            "joints",
            "loads",
        ):
            state.pop(made, None)
        state["_path"] = self._path.arrays(), self._path.footings
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._path = Path.of_arrays(self.scene.robot.model, *state["_path"])

    def __repr__(self) -> str:
        name, span = self.scene.robot.name, f"0 to {self.duration:g} s"
        count = f"{len(self.impacts)} impact{'s' if len(self.impacts) != 1 else ''}"
        return one_line("Trajectory", self.status.name, repr(name), span, count)
