"""How the generalized impulse of wrenches changes with the configuration.

A force f at a point of a body, and a couple c, both fixed in the world, pull the degree of
freedom k with J_k·f + a_k·c, where J_k moves the point and a_k turns the body. What stands
before k on the way from the world turns J_k and a_k, what stands behind moves the point:

    ∂/∂q_j = (a_j × J_k)·f + (a_j × a_k)·c    j before k or in its joint,
             (a_k × J_j)·f                    j behind k.
"""

from __future__ import annotations

import numpy as np

from .expanded import ExpandedModel

__all__ = ["Pulls", "skew"]


def skew(a: np.ndarray) -> np.ndarray:
    """(3, 3) S with S b = a × b."""
    x, y, z = a.tolist()
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


class Pulls:
    """The sum of ∂(Gᵀp)/∂q over rows G with impulses p."""

    def __init__(self, expanded: ExpandedModel) -> None:
        self._expanded = expanded
        self._by_force: np.ndarray | None = None
        self._by_couple: np.ndarray | None = None
        self._beside: np.ndarray | None = None

    def push(self, jacobian: np.ndarray, force: np.ndarray, couple: np.ndarray | None) -> None:
        """Add a wrench that is fixed in the world.

        Args:
            jacobian: (6, nv of the expanded model) of its point.
            force, couple: (3,) in the world; None for no couple.
        """
        turning = jacobian[3:]
        part = jacobian[:3].T.dot(skew(force).dot(turning))
        self._by_force = part if self._by_force is None else self._by_force + part
        if couple is not None:
            part = turning.T.dot(skew(couple).dot(turning))
            self._by_couple = part if self._by_couple is None else self._by_couple + part

    def add(self, part: np.ndarray) -> None:
        """Add (nv, nv) of another origin."""
        self._beside = part if self._beside is None else self._beside + part

    def total(self) -> np.ndarray | None:
        """(nv, nv) the sum; None for zero."""
        if self._by_force is None:
            return self._beside
        before = self._expanded.before
        first = self._by_force if self._by_couple is None else self._by_force + self._by_couple
        whole = np.where(before, first, self._by_force.T)
        if self._expanded.spread is not None:
            whole = self._expanded.rows(self._expanded.columns(whole))
        return whole if self._beside is None else whole + self._beside
