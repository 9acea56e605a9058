"""One question with a known answer, put to every method alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from impulsekit.robot.arrays import read_only
from impulsekit.scene import Scene

__all__ = ["Problem"]


@dataclass(frozen=True)
class Problem:
    """An impact, or a motion after one, whose outcome is known beyond double precision.

    Attributes:
        family: what is asked, "struck chain" for one.
        size: what grows within the family: links, contacts, bodies.
        scene: what strikes, holds and touches.
        q: (nq,) configuration.
        v: (nv,) velocity before.
        exact: works out the answer, rounded once to double: ``v_after`` (nv,), or where
            ``duration`` is given, q and v at its end, one after the other (nq + nv,).
            Ask for ``answer``, which calls it once.
        source: where the answer comes from, in a few words.
        tolerance: relative error up to which a method counts as having solved it.
        duration: seconds of motion after the impact; 0 asks for the velocities alone.
    """

    family: str
    size: int
    scene: Scene
    q: np.ndarray
    v: np.ndarray
    exact: Callable[[], np.ndarray] = field(repr=False)
    source: str
    tolerance: float = 1e-9
    duration: float = 0.0

    @property
    def name(self) -> str:
        """Family and size: "struck chain 60"."""
        return f"{self.family} {self.size}"

    @cached_property
    def answer(self) -> np.ndarray:
        """What ``exact`` gives, kept; read-only."""
        answer = np.array(self.exact(), dtype=float)
        return read_only(answer)

    def error(self, found: np.ndarray) -> float:
        """Largest deviation from the exact answer, relative to the exact answer's largest."""
        exact = self.answer
        if np.shape(found) != exact.shape or not np.isfinite(found).all():
            return float("inf")
        scale = float(np.abs(exact).max()) or 1.0
        return float(np.abs(found - exact).max()) / scale
