"""What Pinocchio's data hold, as arrays over all joints: no look-up per joint and evaluation.

Pinocchio keeps placements and velocities of joints in vectors of C++, one after another in
memory. Each call to ``data.oMi[i]`` makes an object; here the whole vector is one array.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from ...geometry.point_table import Kinematics

__all__ = ["MOTION", "Memory", "order_of_speeds", "rows_of"]

# Of a placement: the rotation, column by column, then the translation. Of a motion: linear
# before angular.
PLACE, MOTION = 12, 6


class Memory:
    """Data of Pinocchio and arrays that show what is in it.

    Attributes:
        data: to call Pinocchio with.
        places: (njoints, 12) of joints in the world: rotations column by column, translations.
        speeds, rates: (njoints, 6) velocities and accelerations in the joints' own axes.
        jacobian: (nv, 6) Jacobians of joints at the origin of the world, transposed.
        factor: (nv, nv) U of M = U D Uᵀ, transposed. pivots: (nv,) D.
        mass: (nv, nv) M, its lower half.
        last: (njoints,) the last speed of each joint, −1 without one.
        before: (nv,) the speed that comes before each on the way to the root, −1 for none.
        branch: (nv,) the first speed of the tree that each belongs to.
        kinematics: what tables of points need of all this; None with mimic joints.
    """

    def __init__(self, model: pin.Model) -> None:
        self.data = model.createData()
        data, count = self.data, model.njoints
        self.places = rows_of(data.oMi, lambda place: place.rotation, count, PLACE)
        self.speeds = rows_of(data.v, lambda motion: motion.vector, count, MOTION)
        self.rates = rows_of(data.a, lambda motion: motion.vector, count, MOTION)
        # Of mimic joints there are more columns than speeds.
        self.jacobian = data.J.reshape(MOTION, data.J.size // MOTION, order="F").T
        self.factor, self.mass = data.U.T, data.M.T
        self.pivots = data.D
        self.last, self.before, self.branch = order_of_speeds(model)
        self.kinematics: Kinematics | None = None
        if len(self.jacobian) == model.nv:
            shown = self.places, self.speeds, self.rates, self.jacobian
            self.kinematics = Kinematics(*shown, self.last, self.before)


def order_of_speeds(model: pin.Model) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """``last`` (njoints,), ``before`` (nv,) and ``branch`` (nv,), as ``Memory`` has them."""
    count = model.njoints
    last = np.array([model.idx_vs[j] + model.nvs[j] - 1 for j in range(count)])
    last[0] = -1
    before, branch = np.full(model.nv, -1), np.zeros(model.nv, dtype=int)
    for j in range(1, count):
        first, parent = model.idx_vs[j], model.parents[j]
        # A joint without speeds of its own goes on with those of its parent.
        if model.nvs[j] == 0:
            last[j] = last[parent]
        for row in range(first, first + model.nvs[j]):
            before[row] = row - 1 if row > first else last[parent]
            above = before[row]
            branch[row] = branch[above] if above >= 0 else row
    return last, before, branch


def rows_of(vector: Any, part: Any, count: int, width: int) -> np.ndarray:
    """(count, width) the memory of a vector of C++."""
    first = part(vector[0])
    address = first.__array_interface__["data"][0]
    step = part(vector[1]).__array_interface__["data"][0] - address if count > 1 else 8 * width
    if step != 8 * width:
        raise TypeError("Pinocchio's data are laid out in another way")
    shown = np.lib.stride_tricks.as_strided(first.ravel(order="K"), (count, width), (step, 8))
    if shown.__array_interface__["data"][0] != address:
        raise TypeError("Pinocchio's data are laid out in another way")
    return shown
