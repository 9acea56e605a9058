"""``Followed``: a motion in the core, and what Python makes of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._core import Ended, MotionImpact
from ..errors import InputError, check_kind, warn_of_setup
from ..impact import Impact
from ..impact.doubts import doubts_of_state
from ..impact.scene_jump import jump_of
from ..robot import state
from ..robot.model_checks import check_capacity
from ..scene import Contact, Scene
from ..scene.functions import call
from ..scene.motion import MotionSettings
from .flat import is_new
from .interrupts import Interrupts
from .record.impact_scenes import scene_of_impact
from .record.path import Path
from .record.sampled import Hits, Rest
from .record.status import MotionStatus
from .record.trajectory import Trajectory
from .start import begin, core_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .._core import RestInterval

__all__ = ["Followed", "checked_start", "rests_until"]


class Followed:
    """A motion.

    Attributes:
        scene, settings: its own.
        core: the motion in the core.
        first: the impact at t = 0, if there was one.
    """

    def __init__(
        self, scene: Scene, q: np.ndarray, v: np.ndarray, settings: MotionSettings
    ) -> None:
        self.scene, self.settings = scene, settings
        self.core, self._start = core_of(scene, q, v, settings), (q, v)
        self.first: Hits = ()

    def begin(self) -> None:
        """Bring it to just after t = 0."""
        core = self.core
        self.first = tuple(begin(core, self.scene, *self._start))

    def copy(self) -> Followed:
        """The same, which goes on by itself."""
        twin = object.__new__(Followed)
        vars(twin).update(vars(self), core=self.core.copy())
        return twin

    def to_end(self, times: np.ndarray, progress: Callable[[float], None] | None) -> Trajectory:
        """Follow it for the settings' duration; the motion, sampled at ``times``."""
        with Interrupts() as interrupts:
            status = self.follow(interrupts, progress)
        return self.trajectory(self.core.t, times, self.settings, status)

    def follow(
        self, interrupts: Interrupts, progress: Callable[[float], None] | None = None
    ) -> MotionStatus:
        """Follow it for the settings' duration; how it ended.

        Args:
            interrupts: of whoever follows it.
        """
        core, duration, heed = self.core, self.settings.duration, interrupts.heed

        def look(t: float) -> None:
            heed()
            if progress is not None:
                call(progress, "progress", t)
                heed()

        try:
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                self.begin()
                if core.begun:
                    core.run(duration, duration, look, progress is not None)
                heed()
        except KeyboardInterrupt:
            return MotionStatus.INTERRUPTED
        return self.status

    def state(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """q (nq,) and v (nv,) at a time [s] that has been reached."""
        return self.core.state(t) if self.core.begun else self._start

    def trajectory(
        self, t: float, times: np.ndarray, settings: MotionSettings, status: MotionStatus
    ) -> Trajectory:
        """The motion up to a time [s] that has been reached."""
        core, detail = self.core, ""
        if status is not MotionStatus.INTERRUPTED and t >= core.t:
            status, detail = self.status, self.detail
        names = self.scene.entry_names("contacts")
        rests = [Rest(names[entry], start, end) for entry, start, end in rests_until(core.rests, t)]
        return Trajectory(
            self.scene,
            np.append(times[times < t], t) if t < settings.duration else times,
            Path(self.scene.robot.model, core.path, t, *self.state(t)),
            self.impacts(t),
            tuple(sorted(rests, key=lambda rest: rest.start)),
            status,
            settings,
            detail=detail,
            steps=core.steps,
            evaluations=core.evaluations,
        )

    def impacts(self, until: float) -> Callable[[], Hits]:
        """Return the impacts up to a time [s], each with all results of ``solve``."""
        scene, first = self.scene, self.first
        met = [hit for hit in self.core.impacts if hit.t <= until]
        return lambda: (*first, *(_impact_of(scene, hit) for hit in met))

    @property
    def status(self) -> MotionStatus:
        """The motion's status; FINISHED while it goes on."""
        if self.first and not self.first[-1][1].status.valid:
            return MotionStatus.IMPACT_NOT_VALID
        ended = self.core.ended
        going_on = ended is Ended.not_yet
        return MotionStatus.FINISHED if going_on else MotionStatus[ended.name.upper()]

    @property
    def detail(self) -> str:
        """Details of the motion's end."""
        if self.status is not MotionStatus.IMPACT_NOT_VALID:
            return str(self.core.detail)
        t, impact = self.impacts(math.inf)()[-1]
        return f"the impact at {t:.9g} s is {impact.describe_status()}"


def rests_until(rests: Sequence[RestInterval], t: float) -> list[tuple[int, float, float]]:
    """Return (contact, start [s], end [s]) of the rests up to a time; the end may be inf."""
    return [
        (rest.entry, rest.start, rest.end if rest.end <= t else math.inf)
        for rest in rests
        if rest.start <= t
    ]


def warn_of_start(scene: Scene, q: np.ndarray) -> None:
    """Warn of what is likely not meant, the first time that a scene is simulated."""
    if is_new(scene):
        warn_of_setup(doubts_of_state(scene, q, moves=True))


def checked_start(
    scene: Scene, q: ArrayLike, v: ArrayLike, what: str
) -> tuple[np.ndarray, np.ndarray]:
    """q and v at the start of a motion.

    Raises:
        InputError: no scene, or a contact with adhesion without a force that holds it.
        ShapeError, NotFiniteError, StateError: q or v is not valid.
    """
    check_kind(scene, Scene, what)
    for i, contact in enumerate(scene.contacts):
        if isinstance(contact, Contact) and contact.adhesion and not contact.holding_force:
            raise InputError(
                f"{what}: contacts[{i}] has an adhesion, which bounds the impulse, and no force "
                "that holds between impacts; give holding_force= [N] too"
            )
    model = scene.robot.model
    check_capacity(model, copies=2)
    return state.checked_configuration(model, q), state.checked_velocity(model, v)


def _impact_of(scene: Scene, hit: MotionImpact) -> tuple[float, Impact]:
    """An impact that the core met during the motion, with all results of ``solve``."""
    own = scene_of_impact(scene, hit.t, soft=hit.is_soft)
    solved, core = jump_of(own).solved(own, hit.solved), hit.solved
    return hit.t, Impact(solved.scene, core.q, core.v, core.solution.dv, solved=solved)
