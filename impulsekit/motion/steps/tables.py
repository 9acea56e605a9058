"""Tables for compiled steps: of a model's tree, of a scene's forces, room for steps."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ...geometry.point_table import MOST, Table
from ..forces.laws import ON, Loads
from ..tree.of_model import room_of, tree_of
from ..tree.pressed import Sliding
from .explicit import tableau
from .system import TOLERANCES, System, Work

__all__ = ["NOTHING_SLIDES", "NO_POINTS", "example_step", "no_loads", "work_of"]

NO_POINTS = Table(np.zeros((0, 3), np.int64), np.zeros((0, MOST)))
NOTHING_SLIDES = Sliding(np.zeros(0), np.zeros((0, 3)), 0.0, 0.0, 0.0)
# The step [s] of the example that compiling takes: any.
EXAMPLE_STEP = 1e-3


def work_of(nv: int, driven: int) -> Work:
    """Room for steps; ``driven`` numbers are driven in time."""
    stages = len(tableau().times)
    vectors = np.zeros((3, 2 * nv))
    return Work(
        np.zeros((stages, 2 * nv)),
        np.zeros((7, 2 * nv)),
        vectors[0],
        vectors[1],
        vectors[2],
        np.zeros((stages, driven)),
    )


def no_loads(nv: int) -> Loads:
    """No forces at all."""
    return Loads(
        np.zeros(nv),
        np.zeros((0, 3), np.int64),
        np.zeros((0, ON + 1)),
        np.zeros(0, np.int64),
        np.zeros((0, 2), np.int64),
        np.zeros((0, ON + 1)),
        np.zeros((0, 2), np.int64),
        np.zeros((0, 2), np.int64),
        np.zeros((0, 12)),
    )


def example_step() -> tuple:
    """Arguments of ``attempt``."""
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    model.appendBodyToJoint(1, pin.Inertia.Random(), pin.SE3.Identity())
    tree = tree_of(model)
    if tree is None:
        raise TypeError("a free body is a tree")
    system = System(
        tree,
        room_of(model),
        no_loads(model.nv),
        NO_POINTS,
        NOTHING_SLIDES,
        pin.neutral(model),
        np.zeros(model.nq),
        np.zeros(model.nv),
        np.zeros(0),
        np.zeros(0),
        np.zeros(0),
    )
    return system, tableau(), work_of(model.nv, 0), EXAMPLE_STEP, *TOLERANCES
