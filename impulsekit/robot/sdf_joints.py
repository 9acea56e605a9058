"""Joints of SDF that carry a link, written as URDF."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin

from ..errors import shown
from .sdf_elements import SdfElements, listed, origin_text

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["KINDS", "axis_of", "joint_texts"]

KINDS = (
    "revolute", "continuous", "prismatic", "fixed", "ball", "universal", "revolute2",
)  # fmt: skip
# Two hinges in series.
TWO_HINGES = ("universal", "revolute2")
# SDF's way to write "no limit" [rad, m].
_ENDLESS = 1e16
# Below this a placement is none [m, rad]: positions in files have fewer digits.
_SAME = 1e-12
# What is written for a limit of which SDF says nothing.
NO_LIMIT = 1e100


def joint_texts(model: SdfElements, name: str) -> list[str]:
    """The URDF joints that carry the child of a joint of the tree."""
    joint, kind = model.joints[name], model.joints[name].get("type", "")
    parent, child = model.end_of(name, "parent"), model.end_of(name, "child")
    above = model.placed.get(parent, pin.SE3.Identity())
    at = model.pose_of_joint(name)
    from_parent, to_child = above.actInv(at), at.actInv(model.placed[child])
    shifted = bool(abs(to_child.homogeneous - np.eye(4)).max() > _SAME)
    simple = list(_simple(model, name, joint, kind, at))
    written, last = [], len(simple) - 1
    for k, (own, each, axis, limits) in enumerate(simple):
        below = child if k == last and not shifted else f"{own}__frame"
        if below != child:
            written.append(f"<link name={quoteattr(below)}/>")
        moving = f'<axis xyz="{listed(axis)}"/>{limits}' if each != "fixed" else ""
        written.append(
            f'<joint name={quoteattr(own)} type="{each}"><parent link={quoteattr(parent)}/>'
            f"<child link={quoteattr(below)}/>{origin_text(from_parent)}{moving}</joint>"
        )
        parent, from_parent = below, pin.SE3.Identity()
    if shifted:
        written.append(
            f'<joint name={quoteattr(name + "__fixed")} type="fixed"><parent '
            f"link={quoteattr(parent)}/><child link={quoteattr(child)}/>"
            f"{origin_text(to_child)}</joint>"
        )
    return written


def _simple(
    model: SdfElements, name: str, joint: Element, kind: str, at: pin.SE3
) -> Iterator[tuple[str, str, Any, str]]:
    """Name, kind, axis and limit of each joint with one degree of freedom."""
    if kind == "fixed":
        yield name, "fixed", None, ""
    elif kind == "ball":
        model.assumed.append(
            f'ball joint "{name}" is three hinges, "{name}_x", "{name}_y" and "{name}"'
        )
        for letter, axis in zip("xyz", np.eye(3), strict=True):
            own = name if letter == "z" else f"{name}_{letter}"
            yield own, "continuous", axis, ""
    elif kind in TWO_HINGES:
        model.assumed.append(f'{kind} joint "{name}" is two hinges, {name}_1 and {name}')
        for tag, own in (("axis", f"{name}_1"), ("axis2", name)):
            axis, limits, each = axis_of(model, name, joint.find(tag), "revolute", at)
            yield own, each, axis, limits
    else:
        axis, limits, each = axis_of(model, name, joint.find("axis"), kind, at)
        yield name, each, axis, limits


def axis_of(
    model: SdfElements, name: str, axis: Element | None, kind: str, at: pin.SE3
) -> tuple[np.ndarray, str, str]:
    """An axis in the joint's frame, its <limit> and <dynamics>, and the URDF kind."""
    element = f'joint "{shown(name)}"'
    xyz = None if axis is None else axis.find("xyz")
    if axis is None or xyz is None:
        raise model.error(element, "it has no <axis> with an <xyz>")
    along = np.array(model.numbers(xyz.text, 3, element, "<xyz>"))
    if not along.any():
        raise model.error(element, "its <axis> has no length")
    frame = xyz.get("expressed_in", "")
    in_model = (axis.findtext("use_parent_model_frame") or "").strip() in ("1", "true")
    if in_model or frame == "__model__":
        along = at.rotation.T @ along
    elif frame and frame != name:
        if frame not in model.links:
            raise model.error(element, f'expressed_in "{shown(frame)}" is no link')
        along = at.rotation.T @ model.placed[frame].rotation @ along
    if axis.find("mimic") is not None:
        model.assumed.append(f"{element}: its <mimic> is left out, it moves on its own")
    limit, dynamics = axis.find("limit"), axis.find("dynamics")
    lower, upper = (
        (sign * _ENDLESS if limit is None else _bound(model, limit, tag, sign, element))
        for tag, sign in (("lower", -1.0), ("upper", 1.0))
    )
    each, text = kind, ""
    if kind == "revolute" and (lower <= -_ENDLESS or upper >= _ENDLESS):
        each = "continuous" if lower <= -_ENDLESS and upper >= _ENDLESS else kind
    if each in ("revolute", "prismatic"):
        effort, speed = (
            NO_LIMIT if limit is None else _bound(model, limit, tag, 1.0, element)
            for tag in ("effort", "velocity")
        )
        effort, speed = (NO_LIMIT if value < 0.0 else value for value in (effort, speed))
        text = (
            f'<limit lower="{max(lower, -NO_LIMIT)!r}" upper="{min(upper, NO_LIMIT)!r}" '
            f'effort="{min(effort, NO_LIMIT)!r}" velocity="{min(speed, NO_LIMIT)!r}"/>'
        )
    if dynamics is not None:
        damping, friction = (
            model.number_in(dynamics, tag, 0.0, element) for tag in ("damping", "friction")
        )
        text += f'<dynamics damping="{damping!r}" friction="{friction!r}"/>'
    return along / np.linalg.norm(along), text, each


def _bound(model: SdfElements, limit: Element, tag: str, sign: float, element: str) -> float:
    text = limit.findtext(tag)
    if text is None or text.strip().lower().lstrip("+-") in ("inf", "infinity"):
        return sign * _ENDLESS
    return model.numbers(text, 1, element, f"<{tag}>")[0]
