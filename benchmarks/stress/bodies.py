"""Robots for the sweeps, written as URDF: random trees of solid boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from impulsekit.robot import Robot
from impulsekit.scene import Contact

from ..urdf import (
    Numbers,
    box_moments,
    box_shape,
    joint_text,
    link_text,
    one_body,
    robot_text,
    words,
)

# Limits of joints [rad, m]: nothing gets there. Moments of inertia of bodies of 1 kg [kg m²].
FAR, MOMENT = 1e9, 0.1


def hung(name: str, shape: str, *joints: tuple[str, str, str, Numbers]) -> Robot:
    """A body on a base, behind joints: name, kind, axis and place of each."""
    parts, parent = [link_text("base")], "base"
    for k, (joint, kind, axis, at) in enumerate(joints, 1):
        child = name if k == len(joints) else f"{name}{k}"
        parts.append(link_text(child, 1.0, MOMENT, shape=shape if child == name else ""))
        parts.append(joint_text(joint, kind, parent, child, axis, at=at, far=FAR))
        parent = child
    return Robot.from_urdf(robot_text(name, *parts))


def slider(name: str, shape: str) -> Robot:
    """A body on a slide along x."""
    return hung(name, shape, ("x", "prismatic", "1 0 0", "0 0 0"))


def free_body(name: str, shape: str, root: str = "freeflyer") -> Robot:
    """A body that turns alike about all axes."""
    return one_body(name, 1.0, MOMENT, shape, root)


def box(*size: float) -> str:
    return box_shape(size)


def ball(radius: float) -> str:
    return f'<sphere radius="{radius!r}"/>'


def rod(radius: float, length: float) -> str:
    return f'<cylinder radius="{radius!r}" length="{length!r}"/>'


def rounded_rod(name: str, radius: float, length: float) -> Robot:
    """A free rod with a ball at both ends, of three pieces."""
    ends = "".join(
        f'<collision><origin xyz="{words((0, 0, z))}"/><geometry>{ball(radius)}</geometry>'
        "</collision>"
        for z in (-0.5 * length, 0.5 * length)
    )
    link = link_text(name, 1.0, MOMENT, shape=rod(radius, length), more=ends)
    return Robot.from_urdf(robot_text(name, link), root="freeflyer")


# Limits of joints [rad, m]; the share of links that hang on any before.
REACH, BRANCHING = 100.0, 0.4


@dataclass(frozen=True)
class Link:
    """A solid box and the joint above it.

    Attributes:
        parent: index of the link it hangs on; −1 for the first.
        mass: [kg].
        size: edges [m].
        joint: "revolute", "prismatic" or "continuous".
        axis: of the joint.
        offset: (3,) of the joint in the parent's frame [m].
        turn: roll, pitch and yaw of the joint in the parent's frame [rad].
        inertia_scale: by which the box's own inertia is multiplied.
    """

    parent: int
    mass: float
    size: tuple[float, float, float] = (0.3, 0.1, 0.1)
    joint: str = "revolute"
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    offset: tuple[float, float, float] = (0.3, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia_scale: float = 1.0

    @property
    def centre(self) -> tuple[float, float, float]:
        """The mass centre, half a length along x [m]."""
        return (0.5 * self.size[0], 0.0, 0.0)

    @property
    def moments(self) -> tuple[float, float, float]:
        """ixx, iyy, izz about the mass centre [kg m²]."""
        return box_moments(self.inertia_scale * self.mass, self.size)


def tree_urdf(links: Sequence[Link], base: bool = False) -> str:
    """The URDF of a tree; links are called link_0, link_1, ... and joints joint_1, ...

    Args:
        base: put a link without mass before the first, with a joint of its own between; for
            robots on a fixed root.
    """
    parts = [link_text("base")] if base else []
    for k, link in enumerate(links):
        parts.append(link_text(f"link_{k}", link.mass, link.moments, at=link.centre))
        if link.parent < 0 and not base:
            continue
        parent = "base" if link.parent < 0 else f"link_{link.parent}"
        parts.append(
            joint_text(
                f"joint_{k}", link.joint, parent, f"link_{k}", link.axis, at=link.offset,
                turn=link.turn, far=REACH,
            )
        )  # fmt: skip
    return robot_text("tree", *parts)


def random_links(rng: np.random.Generator, count: int, *, planar: bool = False) -> list[Link]:
    """Links of about a kilogram and a foot, each on the one before or on any before."""
    links = []
    for k in range(count):
        parent = k - 1
        if k > 1 and rng.random() < BRANCHING:
            parent = int(rng.integers(0, k))
        axis = (0.0, 0.0, 1.0)
        turn = (0.0, 0.0, 0.0)
        if not planar:
            vector = rng.normal(size=3)
            axis = tuple(vector / np.linalg.norm(vector))
            turn = tuple(rng.uniform(-1.5, 1.5, 3))
        links.append(
            Link(
                parent=parent,
                mass=float(rng.uniform(0.3, 3.0)),
                size=tuple(rng.uniform(0.05, 0.4, 3)),
                joint=str(rng.choice(["revolute", "revolute", "continuous", "prismatic"])),
                axis=axis,
                offset=tuple(rng.uniform(-0.3, 0.3, 3) * ([1, 1, 0] if planar else [1, 1, 1])),
                turn=turn,
            )
        )
    return links


def uneven_links(ratio: float, rng: np.random.Generator, least: int, most: int) -> list[Link]:
    """A tree of ``least`` links or more, below ``most``; about half so many times as heavy."""
    links = random_links(rng, int(rng.integers(least, most)))
    return [replace(k, mass=k.mass * (ratio if rng.random() < 0.5 else 1.0)) for k in links]


def tilted_contact(link: int, rng: np.random.Generator, **coefficients: Any) -> Contact:
    """A contact of a link with a plane that is nearly level."""
    at, normal = rng.uniform(-0.2, 0.2, 3), (0.1 * rng.normal(), 0.1 * rng.normal(), 1.0)
    return Contact(f"link_{link}", at=at, normal=normal, **coefficients)


def robot_of(links: Sequence[Link], root: str) -> Robot:
    """The robot of a tree on a root; on a fixed one its first link has a joint as well."""
    return Robot.from_urdf(tree_urdf(links, base=root == "fixed"), root=root)


def random_state(
    robot: Robot, rng: np.random.Generator, count: int, speed: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """(count, nq) and (count, nv), of order one."""
    steps = rng.uniform(-1.5, 1.5, (count, robot.nv))
    q = np.array([pin.integrate(robot.model, robot.neutral(), step) for step in steps])
    return q, speed * rng.normal(size=(count, robot.nv))
