"""Pieces of a step in which nothing turns far: there motions are smooth between few nodes.

Every point of a tree of bodies is a sum of arms that turn with their bodies, so what is seen of
it in time has no part faster than the fastest body turns. Nodes at a quarter of a radian, or
closer, tell all of it (Whittaker's and Shannon's sampling theorem asks for a turn and a half).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pinocchio as pin

from ...laws.borrowed import borrowing
from .roots import PIECES, States

__all__ = ["Turning", "count_of_windows", "nodes_between"]

# No body turns further than this in a window [rad].
TURN_OF_WINDOW = 1.0


@borrowing
def count_of_windows(turned: float) -> int:
    """How many windows a step is looked at in, in which bodies may turn so far [rad]."""
    return max(1, math.ceil(turned / TURN_OF_WINDOW)) if turned < math.inf else 1


class Turning:
    """How fast the bodies of a tree turn at most.

    Attributes:
        speeds: (k, nv) how fast bodies turn with each speed [1/s by its unit].
    """

    def __init__(self, model: pin.Model) -> None:
        # The angular part of every entry of v keeps its size wherever the bodies are.
        data = model.createData()
        pin.computeJointJacobians(model, data, pin.neutral(model))
        own = [np.zeros(model.nv)]
        for i in range(1, model.njoints):
            jacobian = pin.getJointJacobian(model, data, i, pin.LOCAL).reshape(6, -1)[3:]
            own.append(np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian)))
        self.speeds = np.unique(own, axis=0)

    def windows(self, velocities: Sequence[np.ndarray], start: float, end: float) -> list[float]:
        """The times at which windows of a step begin and end; ``velocities`` at some of it."""
        fastest = np.abs(velocities).max(axis=0)
        turned = float(self.speeds.dot(fastest).max(initial=0.0)) * (end - start)
        count = count_of_windows(turned)
        return [*np.linspace(start, end, count + 1)[:-1].tolist(), end]

    def nodes(self, states: States, start: float, end: float) -> list[float]:
        """The times at which to look at a step."""
        once = nodes_between(start, end)
        windows = self.windows([states(t)[1] for t in once], start, end)
        if len(windows) == 2:
            return once
        found = [nodes_between(a, b) for a, b in pairwise(windows)]
        return [t for nodes in found for t in nodes[:-1]] + [end]


def nodes_between(start: float, end: float) -> list[float]:
    """The times at which a window is looked at, its ends included."""
    return [*np.linspace(start, end, PIECES + 1)[:-1].tolist(), end]
