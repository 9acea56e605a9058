"""``MotionSettings``: how long a motion is followed, how accurately, and when to give up."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ..errors import InputError, RangeError, UnknownNameError, quoted
from .numbers import number

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


@dataclass(frozen=True)
class MotionSettings:
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

    duration: float = 1.0
    samples: int = 201
    method: str = "dop853"
    accuracy: str = "normal"
    # Numbers once the settings are made.
    rtol: float = None  # type: ignore[assignment]
    atol: float = None  # type: ignore[assignment]
    step: float = 1e-3
    max_step: float | None = None
    stop_times: tuple[float, ...] = ()
    capture_speed: float = 1e-7
    together: float = 1e-9
    max_impacts: int = 10_000
    max_steps: int = 100_000

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        _check_choice("accuracy", self.accuracy, TOLERANCES)
        _check_choice("method", self.method, METHODS)
        for name, usual in zip(("rtol", "atol"), TOLERANCES[self.accuracy], strict=True):
            if getattr(self, name) is None:
                set_field(self, name, usual)
        for name, least, most, allowed in (
            ("duration", 0.0, LONGEST, "0 to 1e9 s"),
            ("rtol", LEAST_RTOL, 0.1, "1e-13 to 0.1"),
            ("atol", LEAST_ATOL, 1.0, "above 0, up to 1"),
            ("step", LEAST_STEP, 1e3, "1e-9 to 1e3 s"),
            ("max_step", LEAST_STEP, LONGEST, "1e-9 to 1e9 s, or None"),
            ("capture_speed", 0.0, 1e3, "0 to 1e3 m/s"),
            ("together", 0.0, LONGEST_TOGETHER, "0 to 1e-3 s"),
            ("samples", 1, 10_000_000, "1 to 10 million"),
            ("max_impacts", 0, 10**9, "0 or more"),
            ("max_steps", 1, 10**9, "1 or more"),
        ):
            what = f"motion: {name}"
            given = getattr(self, name)
            if name == "max_step" and given is None:
                continue
            value = number(given, what)
            if not least <= value <= most:
                raise RangeError.of(what, given, allowed)
            if name in ("samples", "max_impacts", "max_steps"):
                if value != int(value) or isinstance(given, bool):
                    raise RangeError.of(what, given, "a whole number")
                set_field(self, name, int(value))
            else:
                set_field(self, name, value)
        set_field(self, "stop_times", _times(self.stop_times))

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


def _check_choice(name: str, given: Any, choices: Iterable[str]) -> None:
    if not isinstance(given, str) or given not in choices:
        wanted = ", ".join(f'"{choice}"' for choice in choices)
        raise RangeError.of(f"motion: {name}", quoted(given), wanted)


def _times(given: Any) -> tuple[float, ...]:
    """Times as numbers, in order."""
    what = "motion: stop_times"
    if isinstance(given, str | bytes | dict) or not isinstance(given, Iterable):
        raise InputError(f"{what} must be a list of times, got {quoted(given)}", what=what)
    times = sorted({number(t, f"{what}[{i}]") for i, t in enumerate(given)})
    for t in times:
        if not 0.0 <= t <= LONGEST:
            raise RangeError.of(what, t, "0 to 1e9 s")
    return tuple(times)
