"""The formulas of a pair of frames: relative velocity, its rate, its derivative by q, the wrench.

Conventions of all rows. The first frame receives the impulse, the other one the opposite; linear
comes before angular; vectors are in world axes. With c, c' the two points, v, v' their velocities
and R = [t₁ t₂ n] the axes, n from the other to the first,

    d = c − c',   w = v − v',   u = Rᵀ (w, ω − ω').

c' is a point of the other frame, or the point of it that coincides with c: v' is then that of the
other body at c. Of a body v at an arm r from a point is v + ω × r. Where the place x at which v is
taken moves over the body, and the axes turn with Ω,

    v̇ = a + ω × (ẋ − v),   u̇ = Rᵀ (ẇ − Ω × w, ω̇ − ω̇' − Ω × (ω − ω')).

Derivatives by an entry of q have the same form, with those of places and turns in place of ẋ and
Ω. An impulse p of the rows is the wrench R p at c on the first body
and −R p at c' on the other; its moment about another point is r × f with the arm r from there.

For compiled code and Python alike; what kernels work on side by side they compile for themselves.
"""

from __future__ import annotations

from typing import NamedTuple

from ..geometry.vectors import Vector, along, cross
from ..laws.borrowed import borrowing

__all__ = [
    "PointMotion",
    "motion_at",
    "passing",
    "relative_rate",
    "turning_of_line",
    "velocity_at",
]


class PointMotion(NamedTuple):
    """How a point of a body moves, in any axes that stand still.

    Attributes:
        velocity: [m/s].
        rate: of the velocity, at this point of the body or at a place that moves over it [m/s²].
        spin: ω of the body [rad/s].
    """

    velocity: Vector
    rate: Vector
    spin: Vector


@borrowing
def velocity_at(velocity: Vector, spin: Vector, arm: Vector) -> Vector:
    """v + ω × r: of the point of a body at an arm from one that moves with ``velocity``."""
    return (
        velocity[0] + (spin[1] * arm[2] - spin[2] * arm[1]),
        velocity[1] + (spin[2] * arm[0] - spin[0] * arm[2]),
        velocity[2] + (spin[0] * arm[1] - spin[1] * arm[0]),
    )


@borrowing
def motion_at(
    velocity: Vector, rate: Vector, spin: Vector, spin_rate: Vector, arm: Vector
) -> PointMotion:
    """How the point of a body at an arm from another one moves.

    Args:
        velocity, spin: (3,) of the body at that other point [m/s, rad/s].
        rate, spin_rate: (3,) the spatial acceleration there [m/s², rad/s²]: a − ω × v and ω̇.
        arm: (3,) from there to the point [m].
    """
    moves = velocity_at(velocity, spin, arm)
    return PointMotion(
        moves, along(velocity_at(rate, spin_rate, arm), 1.0, cross(spin, moves)), spin
    )


@borrowing
def passing(point: PointMotion, place: Vector) -> PointMotion:
    """The points of a body that a place passes; ``place``: (3,) the velocity of the place [m/s].

    v̇ = a + ω × (ẋ − v).
    """
    over = along(place, -1.0, point.velocity)
    return PointMotion(point.velocity, along(point.rate, 1.0, cross(point.spin, over)), point.spin)


@borrowing
def relative_rate(first: PointMotion, other: PointMotion, turning: Vector) -> Vector:
    """(3,) ẇ − Ω × w, w = v − v', where the axes turn with Ω [m/s²]."""
    w = along(first.velocity, -1.0, other.velocity)
    return along(along(first.rate, -1.0, other.rate), -1.0, cross(turning, w))


@borrowing
def turning_of_line(n: Vector, length: float, w: Vector) -> Vector:
    """(3,) n × w / L: how a line between two points turns, n along it, w of one to the other."""
    x, y, z = cross(n, w)
    return x / length, y / length, z / length
