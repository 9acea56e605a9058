"""What an impact changes, and what the joints carry of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from impulsekit.reference import freed
from impulsekit.reference.arithmetic import Array, closed, read_only
from impulsekit.reference.body import WORLD
from impulsekit.reference.kinematics import Kinematics
from impulsekit.reference.tree import Tree

__all__ = ["KaneImpact"]


@dataclass(frozen=True, eq=False)
class KaneImpact:
    """How an impact changes the motion. N bodies, n speeds, r rows; arrays are read-only.

    Attributes:
        dy, y_before, y_after: (n,) generalized speeds.
        generalized_impulse: (n,) all of I_l, those of constraint rows included.
        momentum_before, momentum_after: (n,) P_l.
        generalized_masses: (n, n) a_lp.
        body_dv: (N, 3) m/s, changes of the mass-centre velocities, world axes.
        body_domega: (N, 3) rad/s, changes of the angular velocities, world axes.
        energy_before, energy_after: kinetic energies in J.
        row_impulses: (r,) N s or N m s.
    """

    tree: Tree = field(repr=False)
    dy: Array
    y_before: Array
    y_after: Array
    generalized_impulse: Array
    momentum_before: Array
    momentum_after: Array
    generalized_masses: Array
    body_dv: Array
    body_domega: Array
    energy_before: Any
    energy_after: Any
    row_impulses: Array
    _at: Kinematics = field(repr=False)
    _impulses: Array = field(repr=False)
    _couples: Array = field(repr=False)
    _own_impulses: Mapping[str, Array] = field(repr=False)

    def __post_init__(self) -> None:
        read_only(*(value for value in vars(self).values() if isinstance(value, np.ndarray)))

    def body(self, link: str) -> tuple[Array, Array]:
        """Change of the mass-centre velocity and of the angular velocity of a link."""
        index = self.tree.body_of_link(link)
        if index == WORLD:
            zero = closed(self.tree.arithmetic.zeros(3))
            return zero, zero
        return self.body_dv[index], self.body_domega[index]

    def joint_reaction(self, joint: str) -> Array:
        """The impulsive wrench that the parent link gives the child through a joint.

        Found by freeing the joint (:mod:`impulsekit.reference.freed`).

        Returns:
            (6,) at the joint's origin, world axes, linear (N s) before angular (N m s).
        """
        tree = self.tree
        body = tree.body_of_joint(joint)
        return closed(
            freed.reaction(
                tree,
                self._at,
                body,
                self.dy,
                self._impulses,
                self._couples,
                self._own_impulses[joint],
            )
        )

    def joint_reactions(self) -> dict[str, Array]:
        """:meth:`joint_reaction` of every joint, by name."""
        return {name: self.joint_reaction(name) for name in self.tree.joint_names}
