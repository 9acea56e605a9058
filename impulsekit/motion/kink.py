"""One kink of a force."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from .roots import States

__all__ = ["Kink"]


class Kink(NamedTuple):
    """Where a force of the scene changes its law.

    Attributes:
        t: [s].
        switch: sets what changes there to what it is from then on.
        off: what falls to zero there and its rate, from a time and the states of a step.
    """

    t: float
    switch: Callable[[], None]
    off: Callable[[float, States], tuple[float, float]]
