"""Bodies and trees out of numbers: links, joints and whole URDFs as text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from impulsekit.robot import Robot

# Limits of joints that nothing reaches [rad, m].
FAR = 1e4

Numbers = Sequence[float] | np.ndarray | str


def one_body(
    name: str,
    mass: float,
    moments: float | Sequence[float],
    shape: str = "",
    root: str = "freeflyer",
) -> Robot:
    """A robot of one link; see ``link_text``."""
    text = robot_text(name, link_text(name, mass, moments, shape=shape))
    return Robot.from_urdf(text, root=root)


def solid_box(name: str, mass: float, sides: Sequence[float]) -> Robot:
    """A free box with edges ``sides`` [m]."""
    return one_body(name, mass, box_moments(mass, sides), box_shape(sides))


def box_moments(mass: float, sides: Sequence[float]) -> tuple[float, float, float]:
    """ixx, iyy, izz of a solid box about its middle [kg m²]."""
    a, b, c = (side * side for side in sides)
    share = mass / 12.0
    return share * (b + c), share * (a + c), share * (a + b)


def box_shape(sides: Sequence[float]) -> str:
    """A box as URDF has it."""
    return f'<box size="{words(sides)}"/>'


def robot_text(name: str, *parts: str) -> str:
    """A robot of such links and joints."""
    return f'<robot name="{name}">{"".join(parts)}</robot>'


def link_text(
    name: str,
    mass: float | None = None,
    moments: float | Sequence[float] = 1.0,
    *,
    at: Numbers = "0 0 0",
    turn: Numbers = "0 0 0",
    shape: str = "",
    more: str = "",
) -> str:
    """A link.

    Args:
        mass: [kg]; None for a link without inertia.
        moments: of inertia about the mass centre [kg m²]: ixx ixy ixz iyy iyz izz, the three of
            principal axes, or one for all axes.
        at, turn: of the mass centre and the axes of the moments: position [m] and roll, pitch,
            yaw [rad].
        shape: what collides, such as ``<sphere radius="1"/>``.
        more: other elements.
    """
    inertial = ""
    if mass is not None:
        given = [moments] * 3 if isinstance(moments, int | float) else list(moments)
        if len(given) == 3:
            given = [given[0], 0.0, 0.0, given[1], 0.0, given[2]]
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        inertia = " ".join(f'{n}="{float(x)!r}"' for n, x in zip(names, given, strict=True))
        inertial = (
            f'<inertial><origin xyz="{words(at)}" rpy="{words(turn)}"/>'
            f'<mass value="{float(mass)!r}"/><inertia {inertia}/></inertial>'
        )
    collision = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    return f'<link name="{name}">{inertial}{collision}{more}</link>'


def joint_text(
    name: str,
    kind: str,
    parent: str,
    child: str,
    axis: Numbers = "1 0 0",
    *,
    at: Numbers = "0 0 0",
    turn: Numbers = "0 0 0",
    far: float | Sequence[float] = FAR,
    more: str = "",
) -> str:
    """A joint of a kind that URDF knows.

    Args:
        at, turn: of the joint in its parent: position [m] and roll, pitch, yaw [rad].
        far: its limits [rad, m], the lower and the upper one, or one for both sides.
        more: other elements.
    """
    lower, upper = (-far, far) if isinstance(far, int | float) else far
    limit = ""
    if kind in ("revolute", "prismatic"):
        limit = f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{words(at)}" rpy="{words(turn)}"/><axis xyz="{words(axis)}"/>'
        f"{limit}{more}</joint>"
    )


def words(values: Numbers) -> str:
    """Numbers that read back as the same doubles."""
    return values if isinstance(values, str) else " ".join(repr(float(x)) for x in values)
