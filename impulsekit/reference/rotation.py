"""Rotation matrices and cross products, in any precision.

Each function takes the :class:`~impulsekit.reference.arithmetic.Arithmetic` to work in
and returns a matrix R that turns coordinates of the rotated axes into coordinates of the
fixed ones.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from impulsekit.reference.arithmetic import Arithmetic, Array

__all__ = ["about_axis", "cross", "of_quaternion", "of_roll_pitch_yaw", "skew"]


def skew(vector: Array, arithmetic: Arithmetic) -> Array:
    """Return the matrix (3, 3) with ``skew(a) @ b = a x b``, hence ``b @ skew(a) = b x a``."""
    x, y, z = vector
    matrix = arithmetic.zeros(3, 3)
    matrix[0, 1], matrix[0, 2], matrix[1, 2] = -z, y, -x
    matrix[1, 0], matrix[2, 0], matrix[2, 1] = z, -y, x
    return matrix


def about_axis(axis: Array, cosine: Any, sine: Any, arithmetic: Arithmetic) -> Array:
    """Return the rotation about a unit ``axis`` by the angle of this cosine and sine (Rodrigues).

    Example:
        >>> a = Arithmetic.double()
        >>> about_axis(a.array([0, 0, 1]), 0.0, 1.0, a) @ a.array([1, 0, 0])
        array([0., 1., 0.])
    """
    across = skew(axis, arithmetic)
    return arithmetic.eye(3) + sine * across + (1 - cosine) * (across @ across)


def of_roll_pitch_yaw(angles: Array, arithmetic: Arithmetic) -> Array:
    """Return URDF's rotation: roll about fixed x, then pitch about fixed y, then yaw about fixed
    z."""
    turned = arithmetic.eye(3)
    axes = arithmetic.eye(3)
    for axis, angle in zip(axes, angles, strict=True):
        if angle != 0:
            cosine, sine = arithmetic.cos(angle), arithmetic.sin(angle)
            turned = about_axis(axis, cosine, sine, arithmetic) @ turned
    return turned


def of_quaternion(quaternion: Array, arithmetic: Arithmetic) -> Array:
    """Return the rotation of a quaternion (x, y, z, w) of any length but zero."""
    vector, scalar = quaternion[:3], quaternion[3]
    across = skew(vector, arithmetic)
    twice = 2 / (quaternion @ quaternion)
    return arithmetic.eye(3) + twice * (scalar * across + across @ across)


def cross(a: Array, b: Array) -> Array:
    """Return the cross product along the last axis; numpy's own wants numbers it knows."""
    product = np.empty_like(a)
    product[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    product[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    product[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product
