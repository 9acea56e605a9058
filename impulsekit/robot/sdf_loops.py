"""Joints of SDF that close a loop, and gearboxes: frames in the URDF and plain constraints."""

from __future__ import annotations

from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin

from ..errors import shown
from .loop import Loop
from .sdf_elements import SdfElements, origin_text
from .sdf_joints import TWO_HINGES, axis_of

__all__ = ["gearbox_loop", "loop_of"]


def loop_of(model: SdfElements, name: str) -> tuple[Loop, list[str]]:
    """A joint to a link that hangs elsewhere: frames on both sides, and a constraint."""
    joint, kind = model.joints[name], model.joints[name].get("type", "")
    parent, child = model.end_of(name, "parent"), model.end_of(name, "child")
    if kind in TWO_HINGES:
        raise model.error(
            f'joint "{shown(name)}"', "it closes a loop, which a universal joint cannot here"
        )
    at = model.pose_of_joint(name)
    if kind in ("revolute", "continuous", "prismatic"):
        axis, _, _ = axis_of(model, name, joint.find("axis"), kind, at)
        at = pin.SE3(at.rotation @ _with_z_along(axis), at.translation)
    written = []
    ends = []
    for tag, link in (("parent", parent), ("child", child)):
        frame = f"{name}__{tag}"
        place = at if link == "world" else model.placed[link].actInv(at)
        written.append(
            f"<link name={quoteattr(frame)}/><joint name={quoteattr(frame + '_fixed')} "
            f'type="fixed"><parent link={quoteattr(link)}/><child link={quoteattr(frame)}/>'
            f"{origin_text(place)}</joint>"
        )
        ends.append(frame)
    none = (0.0, 0.0, 0.0)
    loop = {"ball": "point", "fixed": "frame", "prismatic": "slide"}.get(kind, "hinge")
    return Loop(loop, name, ends[1], ends[0], none, none), written


def gearbox_loop(model: SdfElements, name: str, joint_to: Mapping[str, str]) -> Loop:
    """theta_child = -ratio theta_parent, both against the reference body."""
    joint, element = model.joints[name], f'joint "{shown(name)}"'
    reference = (joint.findtext("gearbox_reference_body") or "").strip()
    ratio = model.number_in(joint, "gearbox_ratio", 1.0, element)
    speeds = []
    for tag in ("parent", "child"):
        body = model.end_of(name, tag)
        between = [
            (own, 1.0 if model.end_of(own, "child") == body else -1.0)
            for own in joint_to.values()
            if {model.end_of(own, "parent"), model.end_of(own, "child")} == {body, reference}
        ]
        if not between:
            raise model.error(
                element,
                f'no joint connects "{shown(body)}" and its reference body "{shown(reference)}"',
            )
        speeds.append(between[0])
    (driver, sign_in), (driven, sign_out) = speeds
    return Loop("coupling", name, driven, driver, ratio=-ratio * sign_in * sign_out)


def _with_z_along(axis: np.ndarray) -> np.ndarray:
    """(3, 3) a rotation whose third column is the axis."""
    other = np.eye(3)[int(np.argmin(abs(axis)))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])
