"""The text that Pinocchio gets: what has been checked of a URDF, and nothing else.

Two readers of one text may understand it differently; so Pinocchio's reads what the
check has read, written anew. A float's shortest text reads back as the same double.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from xml.sax.saxutils import quoteattr

from .urdf_elements import MOMENTS, LinkInertial, UrdfJoint

__all__ = ["plain_urdf"]


def plain_urdf(
    name: str,
    links: Mapping[str, LinkInertial],
    joints: Sequence[UrdfJoint],
    shapes: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """The URDF of links and joints.

    Args:
        name: the robot's name.
        links: inertia by name.
        joints: the joints.
        shapes: by link, checked XML of its <visual> and <collision> elements.
    """
    shapes = shapes or {}
    text = [f"<robot name={quoteattr(name)}>"]
    for link, inertial in links.items():
        text.append(f"<link name={quoteattr(link)}>{_inertial(inertial)}")
        text += shapes.get(link, ())
        text.append("</link>")
    text += map(_joint, joints)
    return "".join([*text, "</robot>"])


def _inertial(inertial: LinkInertial) -> str:
    if inertial.mass == 0.0 and not any(inertial.moments):
        return ""
    moments = " ".join(
        f'{key}="{moment!r}"' for key, moment in zip(MOMENTS, inertial.moments, strict=True)
    )
    origin = _origin(inertial.com, inertial.rpy)
    return f'<inertial>{origin}<mass value="{inertial.mass!r}"/><inertia {moments}/></inertial>'


def _joint(joint: UrdfJoint) -> str:
    text = [
        f'<joint name={quoteattr(joint.name)} type="{joint.kind}">',
        f"<parent link={quoteattr(joint.parent)}/><child link={quoteattr(joint.child)}/>",
        _origin(joint.xyz, joint.rpy),
    ]
    if joint.axis is not None:
        text.append(f'<axis xyz="{_listed(joint.axis)}"/>')
    if joint.limit is not None:
        text.append(_element("limit", vars(joint.limit)))
    if joint.dynamics is not None:
        damping, friction = joint.dynamics
        text.append(_element("dynamics", {"damping": damping, "friction": friction}))
    if joint.mimic is not None:
        leader, own = quoteattr(joint.mimic.leader), joint.mimic
        text.append(
            f'<mimic joint={leader} multiplier="{own.multiplier!r}" offset="{own.offset!r}"/>'
        )
    return "".join([*text, "</joint>"])


def _element(tag: str, values: Mapping[str, float]) -> str:
    return f"<{tag} " + " ".join(f'{key}="{value!r}"' for key, value in values.items()) + "/>"


def _origin(xyz: Iterable[float], rpy: Iterable[float]) -> str:
    return f'<origin xyz="{_listed(xyz)}" rpy="{_listed(rpy)}"/>'


def _listed(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, numbers))
