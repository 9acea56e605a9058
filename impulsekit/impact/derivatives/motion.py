"""Twists of bodies and how they change with the configuration, on its tangent space.

In world coordinates, about the world's origin, body b has the twist V_b = Σ_k X_k v_k
over the degrees of freedom k on its way to the world. A change δ_j of the configuration
along v_j turns and moves all behind joint j, so that ∂X_k/∂q_j = X_j × X_k for k behind
j or in the same joint, and

    ∂V_b/∂q_j = X_j × (V_b − V_p(j)),    p(j): the body before joint j.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

__all__ = ["Motion", "Tree", "Twists", "cross", "skew"]

_NEXT, _AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])


def skew(a: np.ndarray) -> np.ndarray:
    """(3, 3) S with S b = a × b."""
    x, y, z = a.tolist()
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a × b along the first axis, of (3,), (3, n) or both."""
    if a.ndim == 1:
        return skew(a).dot(b)
    if b.ndim == 1:
        return -skew(b).dot(a)
    return a[_NEXT] * b[_AFTER] - a[_AFTER] * b[_NEXT]


class Tree:
    """Which degrees of freedom move which body.

    Attributes:
        support: (njoints, nv) 1 where a degree of freedom moves a joint's body.
        zero: (3, nv) zeros.
        above: (nv, nv) [k, j] 1 where k is of a joint strictly on the way from j to the world.
    """

    def __init__(self, model: pin.Model) -> None:
        self.support = np.zeros((model.njoints, model.nv))
        self.zero = np.zeros((3, model.nv))
        owner = np.zeros(model.nv, dtype=int)
        for joint_id in range(1, model.njoints):
            first, count = model.idx_vs[joint_id], model.nvs[joint_id]
            self.support[joint_id] = self.support[model.parents[joint_id]]
            self.support[joint_id, first : first + count] = 1.0
            owner[first : first + count] = joint_id
        parents = np.array([model.parents[joint_id] for joint_id in owner.tolist()], dtype=int)
        self.above = np.ascontiguousarray(self.support[parents].T)


class Motion:
    """Motion subspaces X and placements at one configuration, out of Pinocchio's data.

    Attributes:
        linear, angular: (3, nv) of X, about the world's origin.
        placements: of the joints; zero: (3, nv) zeros.
    """

    def __init__(self, tree: Tree, data: pin.Data) -> None:
        self.tree = tree
        jacobian = np.array(data.J).reshape(6, -1)  # (6,) with one degree of freedom
        self.linear, self.angular = jacobian[:3], jacobian[3:]
        self._jacobian = jacobian
        self.placements = data.oMi
        self.zero = tree.zero

    def turning(self, joint_id: int) -> np.ndarray:
        """(3, nv) ∂θ/∂q: how a body turns with the configuration; also its ω by v."""
        return self.angular * self.tree.support[joint_id]

    def moving(self, joint_id: int, point: np.ndarray) -> np.ndarray:
        """(3, nv) ∂c/∂q of a point of a body, given in the world; also its velocity by v."""
        return (self.linear + cross(self.angular, point)) * self.tree.support[joint_id]

    def at_speed(self, v: np.ndarray) -> Twists:
        """The same with the speeds v (nv,)."""
        return Twists(self, v)

    @property
    def jacobian(self) -> np.ndarray:
        """(6, nv) X."""
        return self._jacobian


class Twists:
    """Twists of all bodies at speeds v, and their derivatives by the configuration."""

    def __init__(self, motion: Motion, v: np.ndarray) -> None:
        self._motion, self._v = motion, v
        self._before = motion.jacobian @ (motion.tree.above * v[:, None])

    def of(self, joint_id: int) -> tuple[np.ndarray, np.ndarray]:
        """V (6,) of a body and ∂V/∂q (6, nv)."""
        motion = self._motion
        mask = motion.tree.support[joint_id]
        twist = motion.jacobian @ (mask * self._v)
        gap = (twist[:, None] - self._before) * mask
        change = np.empty_like(gap)
        change[:3] = cross(motion.angular, gap[:3]) + cross(motion.linear, gap[3:])
        change[3:] = cross(motion.angular, gap[3:])
        return twist, change
