"""SDF: a model is written anew as a URDF, which all else reads; loops become plain data.

SDF places links in the model's frame and joints in their child link's frame; URDF hangs each
link on its joint. Where the two differ a link without mass stands between.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin

from ..errors import MjcfError, a_thing, shown
from ..files import read_text_file, reason_of
from .sdf_elements import (
    KINDS,
    TWO_HINGES,
    SdfElements,
    axis_of,
    joint_texts,
    link_text,
    origin_text,
    sdf_error,
)
from .source import Loop
from .urdf_repairs import repair_text


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


@dataclass(frozen=True)
class SdfModel:
    """A model read from an SDF.

    Attributes:
        urdf: the model as URDF text.
        path: the file it came from, or None.
        loops: joints to links that another joint carries, and gearboxes.
        assumptions: what was assumed or left out.
    """

    urdf: str
    path: str | None
    loops: tuple[Loop, ...]
    assumptions: tuple[str, ...]


def read_sdf(source: Any, model: str | None = None) -> SdfModel:
    """Read one <model> of an SDF file or text.

    Raises:
        MjcfError: it cannot be read, holds several models and none is named, or has a joint
            that no rigid robot has; the element is named.
    """
    from .urdf import parsed_xml

    text, path = _text_of(source)
    label = path or "SDF text"
    text, repairs = repair_text(text, "sdf")
    root = parsed_xml(text, label, MjcfError)
    models = [root] if root.tag == "model" else list(root.iter("model"))
    if root.tag not in ("sdf", "model", "world") or not models:
        raise sdf_error(label, f"<{shown(root.tag)}>", "an SDF has <sdf> with a <model> in it")
    names = [each.get("name", "") for each in models]
    if model is not None and model not in names:
        listed = ", ".join(f'"{name}"' for name in names)
        raise sdf_error(label, f'model "{shown(model)}"', f"no such model; choose {listed}")
    if model is None and len(models) > 1:
        listed = ", ".join(f'"{name}"' for name in names)
        raise sdf_error(
            label, "<sdf>", f"it holds {len(models)} models ({listed}); name one: model="
        )
    if model is not None and names.count(model) > 1:
        several = f"{names.count(model)} models have this name, each needs one of its own"
        raise sdf_error(label, f'model "{shown(model)}"', several)
    chosen = models[0] if model is None else models[names.index(model)]
    written = _written(SdfElements(chosen, label), path)
    return replace(written, assumptions=(*repairs, *written.assumptions))


def _written(model: SdfElements, path: str | None) -> SdfModel:
    """The model as URDF text, and what has no place in a tree as plain data."""
    body: list[str] = []
    closing, loops = [], []
    joint_to: dict[str, str] = {}
    for name in _trees_first(model):
        child = model.end_of(name, "child")
        if child in joint_to or child == "world":
            closing.append(name)
        else:
            joint_to[child] = name
            body += joint_texts(model, name)
    links = [link_text(model, name) for name in model.links]
    on_world = any(model.end_of(name, "parent") == "world" for name in joint_to.values())
    # A model may write the world down as a link of its own.
    if on_world and "world" not in model.links:
        links.insert(0, '<link name="world"/>')
    for name in closing:
        loop, frames = loop_of(model, name)
        loops.append(loop)
        body += frames
    for name, joint in model.joints.items():
        if joint.get("type") == "gearbox":
            loops.append(gearbox_loop(model, name, joint_to))
    text = f"<robot name={quoteattr(model.name)}>" + "".join([*links, *body]) + "</robot>"
    return SdfModel(text, path, tuple(loops), tuple(model.assumed))


def _trees_first(model: SdfElements) -> Iterator[str]:
    """Joints but gearboxes; those whose rows a loop takes most easily come last."""
    rank = {"ball": 1}
    kinds = {name: joint.get("type", "") for name, joint in model.joints.items()}
    for name, kind in kinds.items():
        if kind not in KINDS and kind != "gearbox":
            known = ", ".join([*KINDS, "gearbox"])
            raise model.error(
                f'joint "{shown(name)}"',
                f'its type is "{shown(kind)}", expected one of {known}',
            )
    own = [name for name, kind in kinds.items() if kind != "gearbox"]
    return iter(sorted(own, key=lambda name: rank.get(kinds[name], 0)))


def _text_of(source: Any) -> tuple[str, str | None]:
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        return source.lstrip("\ufeff \t\r\n"), None
    if not isinstance(source, str | os.PathLike):
        raise sdf_error("", "", f"from_sdf takes a path or SDF text, got {a_thing(source)}")
    path = os.fspath(source)
    try:
        return read_text_file(path).decode("utf-8-sig").lstrip(), os.path.abspath(path)
    except UnicodeDecodeError:
        raise sdf_error(shown(path, 200), "", "the file is not UTF-8 text") from None
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "the path holds a NUL"
        raise sdf_error(shown(path, 200), "", reason) from None
