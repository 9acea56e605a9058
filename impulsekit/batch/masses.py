"""Links whose masses vary: what each adds to its joint, and a robot that has them."""

from __future__ import annotations

from collections.abc import Mapping

import pinocchio as pin

from ..errors import InputError, UnknownNameError
from ..robot import Robot

__all__ = ["heavy_links", "link_inertia", "scaled_robot"]


def heavy_links(robot: Robot) -> tuple[str, ...]:
    """The links that move and have a mass, by name."""
    return tuple(link.name for link in robot.links if link.joint_id > 0 and link.mass > 0.0)


def link_inertia(robot: Robot, name: str) -> tuple[int, pin.Inertia]:
    """The joint of a link, and the link's own inertia in the frame of the joint.

    Raises:
        UnknownNameError: no such link.
        InputError: it has no mass, or is fixed to the world.
    """
    links = {link.name: link for link in robot.links}
    if name not in links:
        raise UnknownNameError.among("link", name, heavy_links(robot), "masses")
    link = links[name]
    if link.joint_id == 0 or not link.mass > 0.0:
        what = "is fixed to the world" if link.joint_id == 0 else "has no mass of its own"
        raise InputError(f'masses: link "{name}" {what}; there is nothing to scale')
    return link.joint_id, link.spatial_inertia()


def scaled_robot(robot: Robot, factors: Mapping[str, float]) -> Robot:
    """The robot with the mass and inertia of some links so many times as large.

    Args:
        factors: by link; above 0.

    Raises:
        UnknownNameError, InputError: as ``link_inertia``.
    """
    model = pin.Model(robot.model)
    joints = {link_inertia(robot, name)[0] for name in factors}
    # Links are added up anew: nothing is taken away, so that all stays positive.
    wholes = {joint_id: pin.Inertia.Zero() for joint_id in joints}
    for link in robot.links:
        if link.joint_id in joints and link.mass > 0.0:
            wholes[link.joint_id] += link.spatial_inertia(factors.get(link.name, 1.0))
    for joint_id, whole in wholes.items():
        model.inertias[joint_id] = whole
    return Robot(model, robot.parts, robot.name)
