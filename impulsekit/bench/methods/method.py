"""What a method of the benchmark is: a name, what it can do, and a call to be timed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..problems.problem import Problem

__all__ = ["Answer", "Method"]

Answer = Callable[[], np.ndarray]


@dataclass(frozen=True)
class Method:
    """One way to solve problems.

    Attributes:
        name: "impulsekit, aba" or "mujoco, one step".
        peer: whether it is another program's or a classical way, not one of ours.
        needs: the packages it imports, by distribution name; where one is missing the
            method is left out, and the report says so.
        suits: whether it can take a problem at all.
        prepare: builds once what may be built once and gives the call that is timed, which
            returns the answer in the problem's own coordinates.
        precision: what it computes in.
        states: how many states one call answers; its time is divided by them.
    """

    name: str
    suits: Callable[[Problem], bool]
    prepare: Callable[[Problem], Answer]
    peer: bool = False
    needs: tuple[str, ...] = ()
    precision: str = "float64"
    states: int = 1
