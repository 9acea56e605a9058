"""The rows of a constraint that is driven in time: their velocities, rates and places."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...rows.entries import JointRows
from ...scene.at_time import velocity_at
from ...scene.driven import Driven, Rates

__all__ = ["DrivenRows"]

# A motion begins where its driven joints are, but for this [m, rad].
OFF_AT_START = 1e-6


class DrivenRows:
    """One constraint of a scene, a ``Driven`` or one whose velocity is a function of time.

    Attributes:
        where: where its rows stand among all.
    """

    def __init__(self, entry: Any, name: str, where: slice) -> None:
        self._entry, self._name, self.where = entry, name, where
        self._count = where.stop - where.start
        self._rates: Rates | None = None
        if not isinstance(entry, Driven):
            size = np.size(velocity_at(entry.velocity, name, 0.0))
            self._rates = Rates(entry.velocity, f"{name}: velocity", size)

    def velocity(self, t: float) -> np.ndarray | float:
        """(k,) or one number for all rows, at a time [s]."""
        if isinstance(self._entry, Driven):
            return self._entry.rate(t)
        return velocity_at(self._entry.velocity, self._name, t)

    def acceleration(self, t: float) -> np.ndarray | float:
        """(k,) or one number for all rows, at a time [s]."""
        if self._rates is None:
            return self._entry.rate(t, 2)
        return self._rates(t)

    def drifts(
        self, model: pin.Model, said: Any, q: np.ndarray
    ) -> list[tuple[slice | list[int], Callable[[np.ndarray, float], np.ndarray]]]:
        """What tells how far it is off from where it should be; nothing where only velocities are.

        Raises:
            InputError: the motion begins elsewhere.
        """
        entry = self._entry
        if not isinstance(entry, Driven) or not isinstance(said, JointRows):
            return []
        joint_id = said.terms[0][0][0]
        at, row = model.idx_qs[joint_id], model.idx_vs[joint_id]
        if model.nqs[joint_id] == 1:

            def drift(q: np.ndarray, t: float) -> np.ndarray:
                return np.array([q[at] - entry.place(t)])
        else:
            neutral, move = pin.neutral(model), np.zeros(model.nv)

            def drift(q: np.ndarray, t: float) -> np.ndarray:
                move[row] = entry.place(t)
                there = pin.integrate(model, neutral, move)
                return pin.difference(model, there, q)[row : row + 1]

        off = float(drift(q, 0.0)[0])
        if not abs(off) <= OFF_AT_START:
            raise InputError(
                f'{self._name}: joint "{entry.joint}" begins {off:.3g} (rad or m) beside where it '
                f"is driven, position(0) = {entry.place(0.0):.9g}; begin the motion there"
            )
        return [(self.where, drift)]
