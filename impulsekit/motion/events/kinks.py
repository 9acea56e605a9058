"""Kinks of forces: steps of a motion end where one begins, ceases, saturates or turns round.

Forces are smooth while what makes them does what it did: one-sided springs (``spring_kinks``), PD
laws with a limit (``limit_kinks``) and joints with dry friction (``joint_kinks``).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..forces.laws import LIMITED
from ..zeros.roots import States
from .joint_kinks import JointKinks
from .kink import Kink
from .limit_kinks import LimitKinks
from .spring_kinks import SpringKinks

if TYPE_CHECKING:
    from ..dynamics.accelerations import Dynamics

__all__ = ["Kink", "Kinks"]


class Kinks:
    """All kinks of a motion.

    Args:
        dynamics: of the motion.
        accelerate: (nv,) v̇ at a time and state, which tells what rests of its forces.
    """

    def __init__(
        self,
        dynamics: Dynamics,
        accelerate: Callable[[float, np.ndarray, np.ndarray], np.ndarray],
    ) -> None:
        loads, model = dynamics.forces.loads, dynamics.model
        self._springs = SpringKinks(loads, model)
        self._others: list[LimitKinks | JointKinks] = []
        if (loads.kinks[:, 0] == LIMITED).any():
            self._others.append(LimitKinks(loads, model))
        if dynamics.resting.joints is not None:
            self._others.append(JointKinks(dynamics.resting.joints, model, accelerate))

    def __bool__(self) -> bool:
        return bool(self._springs) or bool(self._others)

    def begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Set all for the state at which a motion begins."""
        self._springs.begin(q, v)
        for own in self._others:
            own.begin(q, v)

    def heed_jump(self, q: np.ndarray, v: np.ndarray) -> None:
        """After a jump of the velocity."""
        self._springs.heed_jump(q, v)
        for own in self._others:
            own.begin(q, v)

    def first(self, states: States, start: float, end: float) -> Kink | None:
        """The first kink within a step, if there is one.

        Args:
            states: (q, v) at a time within the step.
            start, end: of the step [s].
        """
        if not end > start:
            return None
        found = self._springs.first(states, start, end)
        for own in self._others:
            until = end if found is None else found.t
            if until > start:
                found = own.first(states, start, until) or found
        return found
