"""What one compiled step works on: the system that moves, and arrays for the step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Table
from ..forces.laws import Loads
from ..tree.bodies import Room, Tree
from ..tree.pressed import Sliding

__all__ = ["TOLERANCES", "System", "Work"]

# rtol and atol in examples of arguments: those of ``MotionSettings`` unless others are given.
TOLERANCES = 5e-11, 1e-12


class System(NamedTuple):
    """What moves, and what acts on it while the same points rest.

    Attributes:
        tree, room, loads: see there.
        table, sliding: of the points that rest; empty without any.
        reference: (nq,) of the chart.
        q: (nq,) and load: (nv,) room. last: (3n,) forces at rest, of the last evaluation.
        accelerations, slip: (3n,) of the points.
    """

    tree: Tree
    room: Room
    loads: Loads
    table: Table
    sliding: Sliding
    reference: np.ndarray
    q: np.ndarray
    load: np.ndarray
    last: np.ndarray
    accelerations: np.ndarray
    slip: np.ndarray


class Work(NamedTuple):
    """A step.

    Attributes:
        slopes: (16, 2 nv) of the stages; the first is there.
        powers: (7, 2 nv) of the dense output.
        before, after, trial: (2 nv,) y at both ends, and room.
        driven: (16, k) what is driven in time, at the times of the stages.
    """

    slopes: np.ndarray
    powers: np.ndarray
    before: np.ndarray
    after: np.ndarray
    trial: np.ndarray
    driven: np.ndarray
