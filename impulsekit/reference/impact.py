"""The change of motion in an impact, and what the joints carry of it.

For the reaction of a joint (Chang & Huston 1995) the directions that it holds are freed for a
moment, which adds up to six generalized speeds; the unknown constraint impulses act there as if
they came from outside; and Δ of the freed speeds is prescribed as zero. The impact equations of
the larger system are

    [ a_lp  a_ls ] [ Δy     ]   [ I_l       ]
    [ a_rp  a_rs ] [ Δs = 0 ] = [ I_r + Λ_r ]

With relative speeds each unknown Λ_r stands alone in its own added equation: the first
rows are those of the intact system, and the added ones say Λ_r = a_rp Δy_p − I_r, where a_rp Δy_p
is the change of momentum along the freed speeds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from impulsekit.reference import kane
from impulsekit.reference.arithmetic import Arithmetic, Array, closed, read_only
from impulsekit.reference.joint import WORLD
from impulsekit.reference.kinematics import Kinematics, freed_partials
from impulsekit.reference.tree import Tree


def joint_directions(at: Kinematics, tree: Tree, body: int) -> Array:
    """Return (d, 6) how each own speed of the joint above a body moves it, at its origin.

    Linear before angular, world axes. The rows are orthonormal for every kind of joint.
    """
    joint = tree.bodies[body].joint
    turned = at.rotations[body].T
    return np.concatenate([joint.linear @ turned, joint.angular @ turned], axis=1)


def freed_directions(numbers: Arithmetic, own: Array) -> Array:
    """Return (6 − d, 6) an orthonormal set of the directions that are not among ``own`` (d, 6)."""
    known = [*own]
    freed: list[Array] = []
    while len(known) < 6:
        left = numbers.eye(6)
        for _ in range(2):  # the second pass removes what rounding left of the first
            for direction in known:
                left = left - np.outer(left @ direction, direction)
        lengths = [row @ row for row in left]
        best = max(range(6), key=lengths.__getitem__)
        freed.append(left[best] / numbers.sqrt(lengths[best]))
        known.append(freed[-1])
    return np.array(freed, dtype=numbers.dtype).reshape(-1, 6)


def reaction(
    tree: Tree,
    at: Kinematics,
    body: int,
    dy: Array,
    impulses: Array,
    couples: Array,
    own_impulse: Array,
) -> Array:
    """Return the impulsive wrench that the joint above a body gives it.

    Args:
        body: index of the body below the joint.
        dy: (n,) Δy of the impact.
        impulses, couples: (N, 3) all outside impulses on the bodies, at mass centres, those
            of constraint rows among them.
        own_impulse: (d,) what acts inside the joint along its own speeds. It is part of the
            wrench: no constraint impulse lies in these directions.

    Returns:
        (6,) at the origin of the body's link frame, world axes, linear before angular.
    """
    own, speeds = joint_directions(at, tree, body), tree.bodies[body].joint.speeds
    gear = bool(tree.bodies[body].joint.mimics) or _is_followed(tree, body)
    if gear:
        # Joints that move together hold each other along their own motion too: there the
        # impulse of the gear is unknown like the rest, and every direction is freed.
        own, own_impulse = own[:0], own_impulse[:0]
    freed = freed_directions(tree.arithmetic, own)
    linear, angular = freed_partials(tree, at, body, freed[:, :3], freed[:, 3:])
    jump_linear, jump_angular = kane.momenta(at, dy)
    over = ([0, 2], [0, 1])
    constraint = np.tensordot(linear, jump_linear - impulses, axes=over)
    constraint = constraint + np.tensordot(angular, jump_angular - couples, axes=over)
    if len(own) and tree.bodies[body].joint.armature is not None:
        # The rotor takes its part of what acts along the joint's own speeds.
        own_impulse = own_impulse - tree.bodies[body].joint.armature * dy[speeds]
    return freed.T @ constraint + own.T @ own_impulse


def _is_followed(tree: Tree, body: int) -> bool:
    name = tree.bodies[body].joint.name
    return any(other.joint.mimics == name for other in tree.bodies)


@dataclass(frozen=True, eq=False)
class KaneImpact:
    """The change of motion in an impact. N bodies, n speeds, r rows; arrays are read-only.

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
        """Return the impulsive wrench that the parent link gives the child through a joint.

        Found by freeing the joint (:mod:`impulsekit.reference.impact`).

        Returns:
            (6,) at the joint's origin, world axes, linear (N s) before angular (N m s).
        """
        tree = self.tree
        body = tree.body_of_joint(joint)
        return closed(
            reaction(
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
        """Return :meth:`joint_reaction` of every joint, by name."""
        return {name: self.joint_reaction(name) for name in self.tree.joint_names}
