"""Bodies of one link or two for sweeps of flights, as URDF."""

from __future__ import annotations

from ...robot import Robot

__all__ = ["ball", "box", "free_body", "joint", "link", "rod", "rounded_rod", "slider", "urdf"]


def urdf(name: str, shape: str, joints: str = "", mass: float = 1.0, moment: float = 0.1) -> str:
    return f'<robot name="{name}">{joints}{link(name, shape, mass, moment)}</robot>'


def link(name: str, shape: str, mass: float = 1.0, moment: float = 0.1) -> str:
    solid = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    return (
        f'<link name="{name}"><inertial><mass value="{mass!r}"/><inertia ixx="{moment!r}" '
        f'iyy="{moment!r}" izz="{moment!r}" ixy="0" ixz="0" iyz="0"/></inertial>{solid}</link>'
    )


def joint(name: str, kind: str, parent: str, child: str, axis: str, at: str = "0 0 0") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>'
        '<limit lower="-1e9" upper="1e9" effort="1" velocity="1"/></joint>'
    )


def slider(name: str, shape: str) -> Robot:
    """A body on a slide along x."""
    return Robot.from_urdf(
        urdf(name, shape, '<link name="base"/>' + joint("x", "prismatic", "base", name, "1 0 0"))
    )


def free_body(name: str, shape: str) -> Robot:
    """A body that turns alike about all axes."""
    return Robot.from_urdf(urdf(name, shape), root="freeflyer")


def box(*size: float) -> str:
    return f'<box size="{" ".join(repr(float(x)) for x in size)}"/>'


def ball(radius: float) -> str:
    return f'<sphere radius="{radius!r}"/>'


def rod(radius: float, length: float) -> str:
    return f'<cylinder radius="{radius!r}" length="{length!r}"/>'


def rounded_rod(name: str, radius: float, length: float) -> Robot:
    """A free rod with a ball at both ends, of three pieces."""
    ends = "".join(
        f'<collision><origin xyz="0 0 {z!r}"/><geometry>{ball(radius)}</geometry></collision>'
        for z in (-0.5 * length, 0.5 * length)
    )
    text = urdf(name, rod(radius, length)).replace("</link>", ends + "</link>")
    return Robot.from_urdf(text, root="freeflyer")
