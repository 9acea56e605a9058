"""``MotionSettings``: how long a motion is followed, how accurately, and when to give up."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

from ..errors import InputError, RangeError, UnknownNameError, quoted
from ..errors.calls import public
from .entry import Checked
from .numbers import Check, between, choice, keep, number

# Of all motions [s].
LONGEST = 1e9
# Below it rounding is no smaller than the error of a step.
LEAST_RTOL = 1e-13
# With atol = 0 an entry of y that is 0 would be allowed no error at all.
LEAST_ATOL = 1e-300
# With shorter steps [s] a second takes more of them than ``max_steps`` may allow.
LEAST_STEP = 1e-9
# Impacts further apart in time [s] are no single instant to anybody.
LONGEST_TOGETHER = 1e-3
METHODS = ("dop853", "radau", "rk4", "semi-implicit")
# rtol and atol by ``accuracy``.
TOLERANCES = {"normal": (1e-8, 1e-10), "high": (5e-11, 1e-12)}


def _count(least: int, most: int, allowed: str) -> Check:
    """A check of whole numbers."""
    within = between(least, most, allowed)

    def checked(value: Any, what: str) -> int:
        result = within(value, what)
        if result != int(result):
            raise RangeError.of(what, value, "a whole number")
        return int(result)

    return checked


def _times(given: Any, what: str) -> tuple[float, ...]:
    """Times as numbers, in order."""
    if isinstance(given, str | bytes | dict) or not isinstance(given, Iterable):
        raise InputError(f"{what} must be a list of times, got {quoted(given)}", what=what)
    times = sorted({number(t, f"{what}[{i}]") for i, t in enumerate(given)})
    for t in times:
        if not 0.0 <= t <= LONGEST:
            raise RangeError.of(what, t, "0 to 1e9 s")
    return tuple(times)


@public
@dataclass(frozen=True)
class MotionSettings(Checked):
    """The settings of ``simulate``; in a scene file the table [motion].

    Attributes:
        duration: [s], 0 or more.
        samples: how many states the trajectory lists, evenly from 0 to the end.
        method: "dop853" (explicit, order 8: the rule; stiff stretches are left to the next),
            "radau" (implicit, order 5), or with a fixed step "rk4" and "semi-implicit".
        accuracy: "normal" (rtol 1e-8, atol 1e-10: a swing of seconds is right to about 1e-8)
            or "high" (5e-11, 1e-12: to about 1e-10).
        rtol, atol: tolerances of a step of the first two methods, relative and absolute; where
            they are given they replace those of ``accuracy``.
        step: length of the fixed step [s].
        capture_speed: a contact that approaches more slowly than this stays [m/s]. With
            the default a ball with e = 0.9 comes to rest within 1e-6 s of its true time.
            Slip slower than this keeps the direction in which it began (at the start slip of
            less than 1e-9 m/s is none); where slip begins,
            friction opposes its acceleration until it is 100 times as fast.
        max_step: no step is longer than this [s]; None for no limit but accuracy. Short forces
            need it where they act for less than a thousandth of ``duration``.
        stop_times: times at which a step ends and a new one begins [s], such as those at which
            a force jumps or begins to act; those past ``duration`` are of no matter.
        together: contacts that close within this of the first close with it [s].
        max_impacts, max_steps: after so many the motion is stopped with a status.

    Raises:
        RangeError, NotFiniteError.

    Example:
        >>> MotionSettings(duration=2.0).rtol, MotionSettings(accuracy="high").rtol
        (1e-08, 5e-11)
    """

    wording = "motion"

    duration: Annotated[float, between(0.0, LONGEST, "0 to 1e9 s")] = 1.0
    samples: Annotated[int, _count(1, 10_000_000, "1 to 10 million")] = 201
    method: Annotated[str, choice(*METHODS)] = "dop853"
    accuracy: Annotated[str, choice(*TOLERANCES)] = "normal"
    # Numbers once the settings are made.
    rtol: Annotated[float, between(LEAST_RTOL, 0.1, "1e-13 to 0.1")] = None  # type: ignore[assignment]
    atol: Annotated[float, between(LEAST_ATOL, 1.0, "above 0, up to 1")] = None  # type: ignore[assignment]
    step: Annotated[float, between(LEAST_STEP, 1e3, "1e-9 to 1e3 s")] = 1e-3
    max_step: Annotated[float, between(LEAST_STEP, LONGEST, "1e-9 to 1e9 s, or None")] | None = None
    stop_times: Annotated[tuple[float, ...], _times] = ()
    capture_speed: Annotated[float, between(0.0, 1e3, "0 to 1e3 m/s")] = 1e-7
    together: Annotated[float, between(0.0, LONGEST_TOGETHER, "0 to 1e-3 s")] = 1e-9
    max_impacts: Annotated[int, _count(0, 10**9, "0 or more")] = 10_000
    max_steps: Annotated[int, _count(1, 10**9, "1 or more")] = 100_000

    def __post_init__(self) -> None:
        keep(self, self.wording, choice(*TOLERANCES), "accuracy")
        for name, usual in zip(("rtol", "atol"), TOLERANCES[self.accuracy], strict=True):
            if getattr(self, name) is None:
                object.__setattr__(self, name, usual)
        super().__post_init__()

    def changed(self, **changes: Any) -> MotionSettings:
        """Return the same with some settings changed.

        Raises:
            UnknownNameError: no such setting.
        """
        known = [field.name for field in dataclasses.fields(self)]
        for name in changes:
            if name not in known:
                raise UnknownNameError.among("setting of a motion", name, known)
        if "accuracy" in changes:
            changes = {"rtol": None, "atol": None, **changes}
        try:
            return dataclasses.replace(self, **changes)
        except TypeError as error:
            raise InputError(str(error)) from None
