"""What a method of the benchmark is: a name, what it can do, and a call to be timed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from ..problems.problem import Problem

__all__ = ["Answer", "Method"]

Answer = Callable[[], np.ndarray]


@dataclass(frozen=True)
class Method:
    """One way to solve problems.

    Attributes:
        name: "impulsekit, solve" or "mujoco, one step". Methods of one name differ in their
            setting; the diagrams join them by a line.
        peer: whether it is another program's or a classical way, not one of ours.
        needs: the packages it imports, by distribution name; where one is missing the
            method is left out, and the report says so.
        suits: whether it can take a problem at all.
        prepare: builds once what may be built once and gives the call that is timed, which
            returns the answer in the problem's own coordinates. One that works in another
            process is a ``TimesItself``.
        states: how many states one call answers; its time is divided by them.
        setting: what is turned up or down along that line, a tolerance, a step or a
            stiffness; None where there is nothing to turn.
        lacks: says what else is missing here and how to get it, "" where nothing is; for
            what is no package of this interpreter.
    """

    name: str
    suits: Callable[[Problem], bool]
    prepare: Callable[..., Answer]
    peer: bool = False
    needs: tuple[str, ...] = ()
    states: int = 1
    setting: float | None = None
    lacks: Callable[[], str] | None = None

    def at(self, settings: Iterable[float]) -> tuple[Method, ...]:
        """The method at each of some settings, which ``prepare`` takes behind the problem."""
        return tuple(
            replace(self, prepare=partial(_prepared, self.prepare, setting), setting=setting)
            for setting in settings
        )

    @property
    def label(self) -> str:
        """Name and setting: "mujoco, soft contacts, 0.001"."""
        return self.name if self.setting is None else f"{self.name}, {self.setting:g}"

    def missing(self) -> str:
        """What keeps it from running here, with the way to get it; "" where nothing does."""
        absent = [name for name in self.needs if not _is_installed(name)]
        if absent:
            return f'{" and ".join(absent)} not installed: pip install "impulsekit[peers]"'
        return self.lacks() if self.lacks else ""


def _prepared(prepare: Callable[..., Answer], setting: float, problem: Problem) -> Answer:
    return prepare(problem, setting)


def _is_installed(distribution: str) -> bool:
    try:
        version(distribution)
    except PackageNotFoundError:
        return False
    return True
