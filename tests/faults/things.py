"""The robots and scenes on which faults are committed."""

from __future__ import annotations

import functools

from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import AppliedImpulse, Contact, Scene


def link(name: str, mass: str = "1", inside: str = "", **moments: str) -> str:
    """A link with inertia."""
    own = {"ixx": "0.1", "iyy": "0.1", "izz": "0.1", "ixy": "0", "ixz": "0", "iyz": "0", **moments}
    inertia = " ".join(f'{key}="{value}"' for key, value in own.items())
    return (
        f'<link name="{name}"><inertial><mass value="{mass}"/><inertia {inertia}/></inertial>'
        f"{inside}</link>"
    )


def joint(
    name: str = "elbow",
    kind: str | None = "revolute",
    parent: str = "upper_arm",
    child: str = "fore_arm",
    inside: str = '<axis xyz="0 1 0"/>',
    limit: str = '<limit lower="-2" upper="2" effort="10" velocity="5"/>',
) -> str:
    """A joint."""
    of_kind = "" if kind is None else f' type="{kind}"'
    return (
        f'<joint name="{name}"{of_kind}><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 1"/>{inside}{limit}</joint>'
    )


def arm_text(*changed: str) -> str:
    """An arm of three links, or a robot of the elements given."""
    box = '<collision><geometry><box size="0.1 0.1 1"/></geometry></collision>'
    parts = changed or (
        link("base", inside=box),
        link("upper_arm", inside=box),
        link("fore_arm", inside=box),
        link("hand"),
        joint("shoulder", parent="base", child="upper_arm"),
        joint("elbow"),
        joint("wrist", "fixed", "fore_arm", "hand"),
    )
    return f'<robot name="arm">{"".join(parts)}</robot>'


ARM = arm_text()
BALL = arm_text(link("ball")).replace('name="arm"', 'name="ball"')


@functools.cache
def arm(root: str = "fixed") -> Robot:
    """The arm."""
    return Robot.from_urdf(ARM, root)


@functools.cache
def ball() -> Robot:
    """A ball that flies."""
    return Robot.from_urdf(BALL, "freeflyer")


@functools.cache
def both() -> Robot:
    """Arm and ball in one world."""
    return combine(arm=arm(), ball=ball())


@functools.cache
def struck() -> Scene:
    """The arm, struck at its hand."""
    return Scene(arm(), [AppliedImpulse("hand", linear=[1, 0, 0], name="blow")])


@functools.cache
def resting() -> Scene:
    """The ball on a floor."""
    return Scene(ball(), contacts=[Contact("ball", restitution=0.5, friction=0.3, name="floor")])
