"""The arrays ω_klm and v_klm of all bodies, and their time derivatives.

Chang & Huston 1995, eqs. (1)-(6): with generalized speeds y_l,

    ω_k = ω_klm y_l n_0m,    v_k = v_klm y_l n_0m,

where k is the body, l the speed and m the inertial axis. ω_klm and v_klm are the
components of the partial angular velocity and of the partial velocity of the mass centre.
They follow from body to body. A body k is joined to a body j; r is the vector from the origin
of j to that of k, s_l and w_l are the directions in which the joint moves the origin of k
and turns k. Then for the origin o

    ω_kl = ω_jl + w_l,    v^o_kl = v^o_jl + ω_jl x r + s_l.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Array, read_only
from impulsekit.reference.joint import joint_pose
from impulsekit.reference.tree import WORLD, Tree


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Poses of the bodies and their partial velocities. N bodies, n speeds, world axes.

    Attributes:
        rotations: (N, 3, 3) of the link frames.
        origins: (N, 3) m of the link frames.
        mass_centres: (N, 3) m.
        inertias: (N, 3, 3) kg m² about the mass centres, I_kmn.
        masses: (N,) kg.
        angular: (N, n, 3) partial angular velocities ω_klm.
        linear: (N, n, 3) partial velocities v_klm of the mass centres.
        armature: (n,) what rotors add to the generalized mass of each speed.
    """

    rotations: Array
    origins: Array
    mass_centres: Array
    inertias: Array
    masses: Array
    angular: Array
    linear: Array
    armature: Array

    def __post_init__(self) -> None:
        read_only(*vars(self).values())

    def velocities(self, y: Array) -> tuple[Array, Array]:
        """Return velocities of the mass centres v_k and angular velocities ω_k, (N, 3) each.

        Chang & Huston 1995, eqs. (1) and (2).
        """
        return (
            np.tensordot(self.linear, y, axes=([1], [0])),
            np.tensordot(self.angular, y, axes=([1], [0])),
        )


@dataclass(frozen=True, eq=False)
class PartialRates:
    """Time derivatives of the partial velocities: ω̇_klm and v̇_klm, (N, n, 3) each."""

    angular: Array
    linear: Array

    def __post_init__(self) -> None:
        read_only(self.angular, self.linear)


def kinematics(tree: Tree, q: Array) -> Kinematics:
    """Return ω_klm and v_klm at a configuration (Chang & Huston 1995, eqs. 1, 2, 5, 6).

    Args:
        q: (nq,) as :meth:`Tree.configuration` returns it.
    """
    numbers, count = tree.arithmetic, len(tree.bodies)
    rotations, origins = numbers.zeros(count, 3, 3), numbers.zeros(count, 3)
    centres, inertias = numbers.zeros(count, 3), numbers.zeros(count, 3, 3)
    masses, armature = numbers.zeros(count), numbers.zeros(tree.n)
    angular = numbers.zeros(count, tree.n, 3)
    of_origin = numbers.zeros(count, tree.n, 3)
    of_centre = numbers.zeros(count, tree.n, 3)
    for k, body in enumerate(tree.bodies):
        joint, j = body.joint, body.parent
        turned, shifted = joint.placement
        own_rotation, own_shift = joint_pose(joint, q, numbers)
        if j == WORLD:
            rotations[k] = turned @ own_rotation
            origins[k] = shifted + turned @ own_shift
        else:
            reach = rotations[j] @ (shifted + turned @ own_shift)
            rotations[k] = rotations[j] @ (turned @ own_rotation)
            origins[k] = origins[j] + reach
            angular[k] = angular[j]
            of_origin[k] = of_origin[j] + angular[j] @ rotation.skew(reach, numbers)
        if len(joint.linear):
            of_origin[k, joint.speeds] += joint.multiplier * (joint.linear @ rotations[k].T)
            angular[k, joint.speeds] += joint.multiplier * (joint.angular @ rotations[k].T)
        if joint.armature is not None:
            armature[joint.speeds] += joint.multiplier**2 * joint.armature
        arm = rotations[k] @ body.mass_centre
        centres[k] = origins[k] + arm
        of_centre[k] = of_origin[k] + angular[k] @ rotation.skew(arm, numbers)
        inertias[k] = rotations[k] @ body.inertia @ rotations[k].T
        masses[k] = body.mass
    return Kinematics(rotations, origins, centres, inertias, masses, angular, of_centre, armature)


def partial_rates(tree: Tree, at: Kinematics, y: Array) -> PartialRates:
    """Return ω̇_klm and v̇_klm, for accelerations (Chang & Huston 1995, eqs. 3, 4):

        α_k = (ω_klm ẏ_l + ω̇_klm y_l) n_0m,    a_k = (v_klm ẏ_l + v̇_klm y_l) n_0m.

    The joint's directions stand still in the child, so they turn with its angular velocity.

    Args:
        at: the kinematics at the configuration.
        y: (n,) generalized speeds.
    """
    numbers, count = tree.arithmetic, len(tree.bodies)
    centre_speed, spin = at.velocities(y)
    arms = at.mass_centres - at.origins
    origin_speed = centre_speed - rotation.cross(spin, arms)
    angular = numbers.zeros(count, tree.n, 3)
    of_origin = numbers.zeros(count, tree.n, 3)
    of_centre = numbers.zeros(count, tree.n, 3)
    for k, body in enumerate(tree.bodies):
        joint, j = body.joint, body.parent
        if j != WORLD:
            reach = rotation.skew(at.origins[k] - at.origins[j], numbers)
            reach_rate = rotation.skew(origin_speed[k] - origin_speed[j], numbers)
            angular[k] = angular[j]
            of_origin[k] = of_origin[j] + angular[j] @ reach + at.angular[j] @ reach_rate
        if len(joint.linear):
            turning = joint.multiplier * (at.rotations[k].T @ rotation.skew(spin[k], numbers).T)
            of_origin[k, joint.speeds] += joint.linear @ turning
            angular[k, joint.speeds] += joint.angular @ turning
        arm = rotation.skew(arms[k], numbers)
        arm_rate = rotation.skew(rotation.cross(spin[k], arms[k]), numbers)
        of_centre[k] = of_origin[k] + angular[k] @ arm + at.angular[k] @ arm_rate
    return PartialRates(angular, of_centre)


def freed_partials(
    tree: Tree, at: Kinematics, body: int, linear: Array, angular: Array
) -> tuple[Array, Array]:
    """Return partial velocities of the speeds that a freed joint gains.

    Args:
        body: index of the body below the joint. It and all below it move as one.
        linear, angular: (d, 3) each, world axes: for each freed speed how the body's
            origin moves and how the body turns.

    Returns:
        Partial velocities of the mass centres and partial angular velocities, (N, d, 3).
    """
    numbers, count = tree.arithmetic, len(tree.bodies)
    of_centre = numbers.zeros(count, len(linear), 3)
    spin = numbers.zeros(count, len(linear), 3)
    for k in tree.subtree(body):
        arm = rotation.skew(at.mass_centres[k] - at.origins[body], numbers)
        of_centre[k] = linear + angular @ arm
        spin[k] = angular
    return of_centre, spin
