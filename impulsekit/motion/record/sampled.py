"""A motion as it was recorded: its samples, its impacts, and its states at any time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, SupportsIndex, cast, overload

import numpy as np

from ...errors import InputError, RangeError, ShapeError, shown
from ...formatting import Displayed
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

__all__ = ["Rest", "SampledMotion", "slip_without_direction"]

# Slip below so many times what has no direction of its own keeps the way in which it began [m/s].
GROWN, NO_SLIP = 100.0, 1e-9


Hits = tuple[tuple[float, Impact], ...]


class Impacts(tuple[tuple[float, Impact], ...]):
    """(time [s], impact) in order of time."""

    @overload
    def __getitem__(self, key: SupportsIndex) -> tuple[float, Impact]: ...
    @overload
    def __getitem__(self, key: slice) -> Hits: ...
    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            raise InputError(
                "impacts are listed in order of time: motion.impacts[0] is (time, impact); "
                f'motion.contacts["{shown(key)}"] lists those of one contact'
            )
        return super().__getitem__(key)


def slip_without_direction(settings: MotionSettings) -> float:
    """Slip that keeps the way in which it began [m/s]."""
    return GROWN * max(NO_SLIP, settings.capture_speed)


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
    """The samples of a simulation; ``Trajectory`` adds quantities derived from them."""

    def __init__(
        self,
        scene: Scene,
        t: np.ndarray,
        path: Path,
        impacts: Hits | Callable[[], Hits],
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
        self._made_impacts = impacts if callable(impacts) else lambda: impacts
        self.rests = rests
        self.status, self.settings = status, settings
        self.detail = detail
        self.steps = steps
        self.evaluations = evaluations
        self._path = path

    @cached_property
    def impacts(self) -> Impacts:
        """(time [s], ``Impact``) in order of time; computed on access."""
        return Impacts(self._made_impacts())

    @cached_property
    def q(self) -> np.ndarray:
        """(len(t), nq) the configurations at the samples."""
        return read_only(self._states[0])

    @cached_property
    def v(self) -> np.ndarray:
        """(len(t), nv) the velocities at the samples."""
        return read_only(self._states[1])

    @cached_property
    def _states(self) -> tuple[np.ndarray, np.ndarray]:
        return self._path.states(self.t)

    @property
    def duration(self) -> float:
        """The time up to which the motion was followed [s]."""
        return float(self._path.end)

    @cached_property
    def loads(self) -> LoadsOfMotion:
        """All forces of the motion; computed on access."""
        from .loads import LoadsOfMotion

        return LoadsOfMotion(self.scene, self._path, slip_without_direction(self.settings))

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
        _ = self.impacts
        state = dict(vars(self))
        for made in (
            "_made_impacts",
            "_states",
            "contacts",
            "constraints",
            "forces",
            "joints",
            "loads",
        ):
            state.pop(made, None)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
