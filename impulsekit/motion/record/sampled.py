"""A motion as it was recorded: its samples, its impacts, and its states at any time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ...display import Displayed
from ...errors import RangeError, ShapeError
from ...impact import Impact
from ...robot.arrays import read_only
from ...scene import Scene
from ...scene.motion import MotionSettings
from ...scene.numbers import number
from .path import Path
from .status import MotionStatus

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .loads import LoadsOfMotion

__all__ = ["Rest", "SampledMotion"]


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


class SampledMotion(Displayed):
    """What a simulation leaves; ``Trajectory`` adds what follows from it."""

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
        self.impacts = tuple((float(time), impact) for time, impact in impacts)
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

    @property
    def duration(self) -> float:
        """The time up to which the motion was followed [s]."""
        return float(self._path.end)

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
