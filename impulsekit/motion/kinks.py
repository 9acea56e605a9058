"""Kinks of forces: steps of a motion end where one begins, ceases, saturates or turns round.

Forces are smooth while what makes them does what it did: one-sided springs (``spring_kinks``) and
joints with dry friction (``joint_kinks``).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from .joint_kinks import JointKinks
from .kink import Kink
from .roots import States
from .spring_kinks import SpringKinks

if TYPE_CHECKING:
    from .compiled_loads import Loads
    from .dynamics import Dynamics

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
        self._springs = SpringKinks(dynamics.forces, dynamics.model)
        joints = dynamics.resting.joints
        self._joints = None if joints is None else JointKinks(joints, dynamics.model, accelerate)

    def __bool__(self) -> bool:
        return bool(self._springs) or self._joints is not None

    def connect(self, loads: Loads) -> None:
        """Keep the tables of compiled code, ``loads`` of the same scene, up to date as well."""
        self._springs.connect(loads)

    def begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Set all for the state at which a motion begins."""
        self._springs.begin(q, v)
        if self._joints is not None:
            self._joints.begin(v)

    def heed_jump(self, q: np.ndarray, v: np.ndarray) -> None:
        """After a jump of the velocity."""
        self._springs.heed_jump(q, v)
        if self._joints is not None:
            self._joints.begin(v)

    def first(self, states: States, start: float, end: float) -> Kink | None:
        """The first kink within a step, if there is one.

        Args:
            states: (q, v) at a time within the step.
            start, end: of the step [s].
        """
        if not end > start:
            return None
        found = self._springs.first(states, start, end)
        if self._joints is not None:
            own = self._joints.first(states, start, end if found is None else found.t)
            found = own if own is not None else found
        return found
