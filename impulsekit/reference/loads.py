"""What acts on the bodies, as plain data: wrenches at points of links, springs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from impulsekit.errors import RangeError, ShapeError
from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Array
from impulsekit.reference.kinematics import Kinematics
from impulsekit.reference.tree import WORLD, Tree

__all__ = ["JointSpring", "Load", "PointSpring", "at_mass_centres", "point_on", "pull_of", "vector"]


@dataclass(frozen=True)
class Load:
    """A force and a couple, or the impulses of both, on a point of a link.

    In an impact N s and N m s, in motion N and N m.

    Attributes:
        link: the link that it acts on.
        linear: (3,) force or impulse.
        angular: (3,) couple about the point, or its impulse.
        at: (3,) m, the point in the link's frame.
        axes: "world" or "local" (the link's own), of ``linear`` and ``angular``.

    Example:
        >>> Load("hand", linear=(0, 5, 0), at=(0.1, 0, 0)).axes
        'world'
    """

    link: str
    linear: Any = (0, 0, 0)
    angular: Any = (0, 0, 0)
    at: Any = (0, 0, 0)
    axes: str = "world"


@dataclass(frozen=True)
class JointSpring:
    """A spring and a damper in a joint with one speed: −stiffness (q − rest) − damping q̇."""

    joint: str
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True)
class PointSpring:
    """A spring and a damper along the line between points of two links, or of the world.

    The pull is stiffness (length − rest_length) + damping times the rate of the length.

    Attributes:
        link, other: the links.
        at, other_at: (3,) m, the points in the frames of the links.
        stiffness: N/m. damping: N s/m. rest_length: m.
    """

    link: str
    other: str
    at: Any = (0, 0, 0)
    other_at: Any = (0, 0, 0)
    stiffness: float = 0.0
    damping: float = 0.0
    rest_length: float = 0.0


def point_on(tree: Tree, at: Kinematics, body: int, point: Any, what: str) -> Array:
    """World coordinates (3,) m of a point given in the frame of a body, or of the world."""
    own = vector(tree, point, what)
    return own if body == WORLD else at.origins[body] + at.rotations[body] @ own


def at_mass_centres(tree: Tree, at: Kinematics, loads: Iterable[Load]) -> tuple[Array, Array]:
    """The loads as one force F_k and one couple M_k per body, (N, 3) each, world axes.

    A force F on a point at r from the mass centre is F on the mass centre and a couple r x F.

    Raises:
        UnknownNameError, ShapeError, NotFiniteError, RangeError: of a load.
    """
    forces = tree.arithmetic.zeros(len(tree.bodies), 3)
    couples = tree.arithmetic.zeros(len(tree.bodies), 3)
    for load in loads:
        body = tree.body_of_link(load.link)
        what = f'load on "{load.link}"'
        force = vector(tree, load.linear, f"{what}: linear")
        couple = vector(tree, load.angular, f"{what}: angular")
        point = point_on(tree, at, body, load.at, f"{what}: at")
        if load.axes not in ("world", "local"):
            raise RangeError.of(f"{what}: axes", repr(load.axes), '"world" or "local"')
        if body == WORLD:
            continue  # the world does not move
        if load.axes == "local":
            force, couple = at.rotations[body] @ force, at.rotations[body] @ couple
        arm = rotation.skew(point - at.mass_centres[body], tree.arithmetic)
        forces[body] += force
        couples[body] += couple + arm @ force
    return forces, couples


def vector(tree: Tree, values: Any, what: str) -> Array:
    """A checked copy of three numbers."""
    checked = tree.arithmetic.finite_array(values, what)
    if checked.shape != (3,):
        raise ShapeError.of(what, (3,), checked.shape)
    return checked


def pull_of(spring: PointSpring, tree: Tree, at: Kinematics, y: Array) -> tuple[Array, Array]:
    """Forces and couples of a spring between points on all bodies, (N, 3) each.

    Raises:
        RangeError: its ends meet, so its pull has no direction.
    """
    numbers = tree.arithmetic
    forces = numbers.zeros(len(tree.bodies), 3)
    couples = numbers.zeros(len(tree.bodies), 3)
    what = f'spring between "{spring.link}" and "{spring.other}"'
    velocity, spin = at.velocities(y)
    ends = []
    for link, place in ((spring.link, spring.at), (spring.other, spring.other_at)):
        body = tree.body_of_link(link)
        point = point_on(tree, at, body, place, what)
        if body == WORLD:
            ends.append((body, point, numbers.zeros(3), numbers.zeros(3, 3)))
        else:
            arm = rotation.skew(point - at.mass_centres[body], numbers)
            ends.append((body, point, velocity[body] - arm @ spin[body], arm))
    (first, here, here_rate, arm), (other, there, there_rate, other_arm) = ends
    length = numbers.norm(there - here)
    if not length > 0:
        raise RangeError.of(f"length of the {what}", 0, "more than 0")
    along = (there - here) / length
    stretch = length - numbers.number(spring.rest_length)
    rate = along @ (there_rate - here_rate)
    pull = numbers.number(spring.stiffness) * stretch + numbers.number(spring.damping) * rate
    for body, lever, force in ((first, arm, pull * along), (other, other_arm, -pull * along)):
        if body != WORLD:
            forces[body] += force
            couples[body] += lever @ force
    return forces, couples
