"""Bodies of one link or two for sweeps of flights, as URDF."""

from __future__ import annotations

from impulsekit.robot import Robot

from ..urdf import Numbers, box_shape, joint_text, link_text, one_body, robot_text, words

__all__ = ["FAR", "MOMENT", "ball", "box", "free_body", "hung", "rod", "rounded_rod", "slider"]

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
