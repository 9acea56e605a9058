"""``Simulation``: a motion that is followed step by step."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, MutableMapping
from dataclasses import replace
from functools import wraps
from threading import Lock
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

import numpy as np

from .._core import ForcesOfMotion
from ..errors import (
    CallbackError,
    InputError,
    RangeError,
    ShapeError,
    SolveError,
    a_thing,
    check_kind,
)
from ..errors.calls import public
from ..formatting import Displayed, one_line
from ..impact import Impact
from ..robot.arrays import array_of, lock
from ..scene import Scene
from ..scene.functions import let_through, of_function
from ..scene.motion import MotionSettings
from ..scene.numbers import number
from .flat import flat_motion
from .followed import Followed, checked_start, warn_of_start
from .record.loads import pushed_points
from .record.sampled import Impacts, slip_without_direction
from .record.status import MotionStatus
from .record.trajectory import Trajectory
from .simulate import sample_times

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Simulation"]

P = ParamSpec("P")
Result = TypeVar("Result")


def _alone(
    method: Callable[Concatenate[Simulation, P], Result],
) -> Callable[Concatenate[Simulation, P], Result]:
    """Return the method, refused while another call on the same Simulation is under way.

    The core computes without Python's lock: a second thread would change its state underneath.
    """

    @wraps(method)
    def guarded(self: Simulation, *args: P.args, **kwargs: P.kwargs) -> Result:
        in_use = self._in_use
        if not in_use.acquire(False):
            raise InputError(
                f"Simulation.{method.__name__}: another thread, or a function of the scene, uses "
                "this Simulation now; give each thread its own copy()"
            )
        try:
            return method(self, *args, **kwargs)
        except CallbackError as error:
            own = of_function(error, self._followed.core.t)
        finally:
            in_use.release()
        raise own

    return guarded


@public
class Simulation(Displayed):
    """A motion that goes on step by step, with torques that are set on the way.

    The integrator keeps its own steps, which may reach beyond the time asked for; states in
    between are read from them, so that a short ``step`` costs nothing and changes no digit. A
    torque that is set begins a new one.

    One thread at a time uses a Simulation; each thread may have its own ``copy()``, which are
    stepped on all cores.

    Args:
        scene: the robot, what acts on it, and the law of contact; its impulses act at t = 0.
        q: (nq,) configuration at the start. v: (nv,) velocity, before the impulses act.
        record: False to forget the way, for a simulation that never ends; then there is no
            ``trajectory``.
        settings: method, tolerances and limits, see ``MotionSettings``. ``duration`` [s] is
            only how far a step may reach at most; ``max_steps`` counts for each call.
        **changes: single settings to change, such as ``accuracy="high"``.

    Attributes:
        controls: torques [N m, N] by joint name, added to the scene's forces from ``t`` on; a
            number, or (k,) for a joint of k degrees of freedom. ``control`` sets all at once.

    Raises:
        ShapeError, NotFiniteError, StateError, InputError, SolveError: as ``simulate``; and
            InputError where two threads use it at once.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, Simulation
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> floor = Contact("ball", normal=[0, 0, 1], restitution=0.5, name="floor")
        >>> sim = Simulation(
        ...     Scene(ball, contacts=[floor]), ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1]),
        ...     ball.velocity())
        >>> impact = sim.next_impact()
        >>> round(sim.t, 6), impact.v_after[2].round(6).item()
        (0.451524, 2.214723)
        >>> sim.step(0.1).contacts
        ()
    """

    def __init__(
        self,
        scene: Scene,
        q: ArrayLike,
        v: ArrayLike,
        *,
        record: bool = True,
        settings: MotionSettings | None = None,
        **changes: Any,
    ) -> None:
        base = MotionSettings() if settings is None else settings
        check_kind(base, MotionSettings, "settings")
        q, v = checked_start(scene, q, v, "Simulation")
        warn_of_start(scene, q)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            chosen = base.changed(**changes)
            self._followed = let_through(lambda: Followed(scene, q, v, chosen), lambda: 0.0)
            let_through(self._followed.begin, lambda: 0.0)
        self._record, self._t, self._in_use = bool(record), 0.0, Lock()
        self._state: tuple[np.ndarray, np.ndarray] | None = None
        self._controls = Controls(scene)
        self._stop_at(0.0)

    @property
    def controls(self) -> Controls:
        """Torques [N m, N] by joint name, added to the scene's forces from ``t`` on."""
        return self._controls

    @controls.setter
    def controls(self, torques: Any) -> None:
        raise InputError(
            f"controls holds torques by joint name, got {a_thing(torques)}: set one as in "
            'sim.controls["knee"] = 5.0, or all by sim.control(torques)'
        )

    def control(self, torques: ArrayLike) -> Simulation:
        """Set the torques of all joints from ``t`` on; returns itself.

        Args:
            torques: (nv,) in the order of v [N m, N].

        Raises:
            ShapeError, NotFiniteError, InputError: not nv finite numbers.

        Example:
            >>> from impulsekit import Robot, Scene, Simulation
            >>> arm = Robot.from_example("panda")
            >>> sim = Simulation(Scene(arm), arm.neutral(), arm.velocity())
            >>> sim.control([0, 2, 0, 0, 0, 0, 0, 0, 0]).controls["panda_joint2"]
            2.0
        """
        controls = self._controls
        controls.set_all(array_of(torques, controls.torques.shape, "control"))
        return self

    @property
    def t(self) -> float:
        """The time reached [s]."""
        return self._t

    @property
    @_alone
    def q(self) -> np.ndarray:
        """(nq,) the configuration at ``t``."""
        return self._state_now()[0]

    @property
    @_alone
    def v(self) -> np.ndarray:
        """(nv,) the velocity at ``t``; just after the impact where there is one."""
        return self._state_now()[1]

    @property
    @_alone
    def impacts(self) -> Impacts:
        """(time [s], ``Impact``) of all up to ``t``."""
        return self._impacts()

    @property
    def contacts(self) -> tuple[str, ...]:
        """The names of the contacts that rest now."""
        return tuple(self.forces)

    @property
    @_alone
    def forces(self) -> dict[str, np.ndarray]:
        """By name of a contact that rests, (3,) its force on the first body, world axes [N].

        Of a joint stop (1,), in its joint [N m, N].
        """
        followed, (q, v) = self._followed, self._state_now()
        slow = slip_without_direction(followed.settings)
        core = ForcesOfMotion(flat_motion(followed.scene).core, slow)
        found = core.at(self._t, q, v, followed.core.resting_state(self._t))
        names, forces = followed.scene.entry_names("contacts"), dict[str, np.ndarray]()
        for point in pushed_points(followed.scene, found):
            name = names[point.entry]
            forces[name] = forces.get(name, np.zeros(len(point.force))) + point.force
        return forces

    @_alone
    def step(self, dt: float) -> Simulation:
        """Go on by a time [s]; returns itself.

        Raises:
            RangeError, NotFiniteError: no time, or one below 0.
            SolveError: the motion cannot be followed so far; ``t`` is where it ended.
        """
        return self._run_until(self._later(self._t + number(dt, "dt")))

    @_alone
    def run_until(self, t: float) -> Simulation:
        """Go on up to a time [s]; returns itself.

        Raises:
            RangeError, NotFiniteError: no time, or one in the past.
            SolveError: the motion cannot be followed so far; ``t`` is where it ended.
        """
        return self._run_until(self._later(number(t, "t")))

    def _run_until(self, t: float) -> Simulation:
        # Torques that are set at each step will change again at its end.
        horizon = t if self._controls.changed else self._horizon(t)
        core = self._obeying()
        if core.t < t:
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                goes_on = core.run(t, horizon, None, False)
            if not goes_on:
                self._stop_at(t)
        self._t = t
        return self

    @_alone
    def next_impact(self, until: float | None = None) -> Impact | None:
        """Go on to the next impact, and return it; None where there is none.

        Args:
            until: but no further than to this time [s]; by default by ``duration``.

        Raises:
            RangeError, NotFiniteError: no time, or one in the past.
            SolveError: the motion cannot be followed so far; ``t`` is where it ended.
        """
        duration = self._followed.settings.duration
        t = self._later(self._t + duration if until is None else number(until, "t"))
        core = self._obeying()
        known = bisect_right(core.impact_times, self._t)
        if known == len(core.impact_times) and core.t < t:
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                core.run_to_impact(t, self._horizon(t))
        times = core.impact_times
        if known < len(times) and times[known] <= t:
            self._stop_at(times[known])
            self._t = times[known]
            return self._impacts()[-1][1]
        self._stop_at(t)
        self._t = t
        return None

    @_alone
    def copy(self) -> Simulation:
        """The same motion at the same time, which goes on by itself."""
        twin = object.__new__(type(self))
        own = {"_followed": self._followed.copy(), "_controls": self.controls.copy()}
        vars(twin).update(vars(self), **own, _in_use=Lock())
        return twin

    def restore(self, state: Simulation) -> None:
        """Be again where a copy is; the copy may be used again.

        Raises:
            InputError: it is none, or one of another scene.
        """
        check_kind(state, Simulation, "restore")
        if state._followed.scene is not self._followed.scene:
            raise InputError("restore: the state is of another scene")
        self._become(state.copy())

    @_alone
    def trajectory(self, samples: ArrayLike | None = None) -> Trajectory:
        """The motion up to now, as ``simulate`` gives it.

        Args:
            samples: how many states it lists, evenly; or increasing times [s].

        Raises:
            InputError: the way was not recorded.
            RangeError, NotFiniteError: no samples.
        """
        if not self._record:
            raise InputError("trajectory: this Simulation was made with record=False")
        settings = replace(self._followed.settings, duration=self._t)
        times = sample_times(settings.samples if samples is None else samples, self._t)
        return self._followed.trajectory(self._t, times, settings, MotionStatus.FINISHED)

    @_alone
    def _become(self, twin: Simulation) -> None:
        vars(self).update(vars(twin), _in_use=self._in_use)

    def _state_now(self) -> tuple[np.ndarray, np.ndarray]:
        """q and v at ``t``, read-only, read from the core once."""
        if self._state is None:
            self._state = q, v = self._followed.core.state(self._t)
            lock(q, v)
        return self._state

    def _impacts(self) -> Impacts:
        return Impacts(self._followed.impacts(self._t)())

    def _later(self, t: float) -> float:
        """Return a time, which is not in the past."""
        if t < self._t:
            raise RangeError.of("t", t, f"{self._t:g} s, the time reached, or later")
        return t

    def _horizon(self, t: float) -> float:
        """Return the limit of steps: beyond a time, since later ones will be requested."""
        return max(t, self._followed.core.t + self._followed.settings.duration)

    def _obeying(self) -> Any:
        """The core, with torques that were set."""
        core, self._state = self._followed.core, None
        if not self._record:
            core.forget(self._t)
        controls = self._controls
        if controls.changed:
            controls.changed = False
            core.control(self._t, controls.torques)
        return core

    def _stop_at(self, wanted: float) -> None:
        """Tell that the motion has ended before a time."""
        followed = self._followed
        if not followed.status.finished and followed.core.t <= wanted:
            self._t = followed.core.t
            raise SolveError(f"Simulation: {followed.status.value} {followed.detail}".strip())

    @_alone
    def __repr__(self) -> str:
        followed = self._followed
        count = bisect_right(followed.core.impact_times, self._t) + len(followed.first)
        hits = f"{count} impact{'s' if count != 1 else ''}"
        return one_line("Simulation", repr(followed.scene.robot.name), f"t = {self._t:g} s", hits)


class Controls(MutableMapping[str, Any]):
    """Torques by joint name [N m, N].

    Attributes:
        torques: (nv,) all of them. changed: whether one was set that nothing heeded yet.
    """

    def __init__(self, scene: Scene) -> None:
        self._robot = scene.robot
        self._places: dict[str, slice] = {}
        self.torques = np.zeros(scene.robot.nv)
        self.changed = False

    def copy(self) -> Controls:
        """The same torques, apart."""
        twin = object.__new__(Controls)
        vars(twin).update(vars(self), torques=self.torques.copy())
        return twin

    def set_all(self, torques: np.ndarray) -> None:
        """Set all torques (nv,), which are kept."""
        self.torques = torques
        self.changed = True

    def update(self, other: Any = (), /, **torques: Any) -> None:
        """Set some torques; a mapping, pairs, or by keyword.

        Raises:
            InputError: none of these.
        """
        try:
            given = {**dict(other), **torques}
        except (TypeError, ValueError):
            raise InputError(
                f"controls.update takes torques by joint name, got {a_thing(other)}; an array of "
                "all is set by sim.control(torques)"
            ) from None
        super().update(given)

    def _where(self, name: str) -> slice:
        if name not in self._places:
            joint = self._robot.model.joints[self._robot.joint_id(name)]
            self._places[name] = slice(joint.idx_v, joint.idx_v + joint.nv)
        return self._places[name]

    def __getitem__(self, name: str) -> Any:
        own = self.torques[self._where(name)]
        return float(own[0]) if len(own) == 1 else own.copy()

    def __setitem__(self, name: str, torque: ArrayLike) -> None:
        where = self._where(name)
        size = where.stop - where.start
        what = f'controls["{name}"]'
        given: Any = torque
        own = [number(x, what) for x in ([given] if np.ndim(given) == 0 else given)]
        if len(own) != size:
            raise ShapeError.of(what, (size,), (len(own),))
        self.torques[where] = own
        self.changed = True

    def __delitem__(self, name: str) -> None:
        self[name] = np.zeros(self.torques[self._where(name)].shape)

    def __iter__(self) -> Iterator[str]:
        return iter(self._robot.joint_names)

    def __len__(self) -> int:
        return len(self._robot.joint_names)
