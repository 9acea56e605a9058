"""Links and joints of an SDF model, written as URDF."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin

from ..errors import MjcfError, shown

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element


class SdfElements:
    """A <model> of SDF, read as far as its parts are named and placed.

    Attributes:
        label: the file, for messages.
        name: of the model.
        links, joints: their elements by name.
        placed: by link, its placement in the model's frame.
        assumed: what was assumed or left out; readers of the parts add to it.

    Raises:
        MjcfError: it includes other models, has no link, or a pose that cannot be read.
    """

    def __init__(self, model: Element, label: str) -> None:
        self.label = label
        self.name = model.get("name") or "robot"
        self.links = {link.get("name", ""): link for link in model.findall("link")}
        self.joints = {joint.get("name", ""): joint for joint in model.findall("joint")}
        self.assumed: list[str] = []
        if model.find("include") is not None or model.find("model") is not None:
            raise self.error("<model>", "it includes other models; write them into one first")
        if not self.links:
            raise self.error("<model>", "it has no link")
        self.placed = {name: self._pose_of_link(name, ()) for name in self.links}

    def error(self, element: str, sentence: str) -> MjcfError:
        """The error for an element."""
        return sdf_error(self.label, element, sentence)

    def numbers(self, text: str | None, count: int, element: str, what: str) -> list[float]:
        try:
            found = [float(word) for word in (text or "").split()]
        except ValueError:
            found = []
        if len(found) != count or not np.isfinite(found).all():
            plural = "s" if count > 1 else ""
            raise self.error(
                element,
                f'its {what} is "{shown(text or "")}", expected {count} finite number{plural}',
            )
        return found

    def number_in(self, parent: Element, tag: str, default: float, element: str) -> float:
        child = parent.find(tag)
        if child is None:
            return default
        return self.numbers(child.text, 1, element, f"<{tag}>")[0]

    def end_of(self, joint: str, tag: str) -> str:
        end = self.joints[joint].find(tag)
        link = "" if end is None else (end.text or end.get("link") or "").strip()
        if link != "world" and link not in self.links:
            raise self.error(f'joint "{shown(joint)}"', f'its <{tag}> "{shown(link)}" is no link')
        return link

    def read_pose(self, pose: Element | None, element: str) -> pin.SE3:
        if pose is None or not (pose.text or "").strip():
            return pin.SE3.Identity()
        if pose.get("rotation_format", "euler_rpy") != "euler_rpy" or pose.get("degrees") == "true":
            raise self.error(
                element,
                "its <pose> is in degrees or a quaternion; write roll, pitch, yaw in radian",
            )
        numbers = self.numbers(pose.text, 6, element, "<pose>")
        return pin.SE3(pin.rpy.rpyToMatrix(*numbers[3:]), np.array(numbers[:3]))

    def pose_of_joint(self, name: str, seen: tuple[str, ...] = ()) -> pin.SE3:
        pose = self.joints[name].find("pose")
        own = self.read_pose(pose, f'joint "{shown(name)}"')
        if pose is not None and (pose.get("relative_to") or pose.get("frame")):
            return self._relative_to(pose, seen) * own
        child = self.end_of(name, "child")
        return self._pose_of_link(child, seen) * own

    def _pose_of_link(self, name: str, seen: tuple[str, ...]) -> pin.SE3:
        """The pose of a link in the model's frame."""
        pose = self.links[name].find("pose")
        if name in seen:
            raise self.error(f'link "{shown(name)}"', "its pose is relative to itself")
        return self._relative_to(pose, (*seen, name)) * self.read_pose(
            pose, f'link "{shown(name)}"'
        )

    def _relative_to(self, pose: Element | None, seen: tuple[str, ...]) -> pin.SE3:
        frame = "" if pose is None else pose.get("relative_to") or pose.get("frame") or ""
        if frame in ("", "__model__"):
            return pin.SE3.Identity()
        if frame in self.links:
            return self._pose_of_link(frame, seen)
        if frame in self.joints:
            return self.pose_of_joint(frame, seen)
        raise self.error("<pose>", f'relative_to "{shown(frame)}" names no link or joint')


def origin_text(place: pin.SE3) -> str:
    rpy = pin.rpy.matrixToRpy(place.rotation)
    return f'<origin xyz="{listed(place.translation)}" rpy="{listed(rpy)}"/>'


def listed(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


def sdf_error(source: str, element: str, sentence: str) -> MjcfError:
    where = ": ".join(part for part in (source, element) if part)
    text = f"{where}: {sentence}" if where else sentence
    return MjcfError(text, source=source, element=element)


_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def link_text(model: SdfElements, name: str) -> str:
    link, element = model.links[name], f'link "{shown(name)}"'
    parts = [f"<link name={quoteattr(name)}>", _inertial(model, link, element)]
    for tag in ("visual", "collision"):
        for item in link.findall(tag):
            parts.append(_shape(model, item, element))
    return "".join([*parts, "</link>"])


def _inertial(model: SdfElements, link: Element, element: str) -> str:
    inertial = link.find("inertial")
    if inertial is None:
        model.assumed.append(f"{element} has no <inertial>; SDF takes 1 kg and 1 kg m² then")
        mass, moments = 1.0, [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]
        place = pin.SE3.Identity()
    else:
        if (inertial.get("auto") or "").strip() in ("1", "true"):
            raise model.error(
                element,
                'its <inertial auto="true"> is worked out from shapes and densities, which is not '
                "supported; give its <mass>, <pose> and <inertia>",
            )
        if inertial.find("fluid_added_mass") is not None:
            model.assumed.append(f"{element}: its <fluid_added_mass> is left out")
        mass = model.number_in(inertial, "mass", 1.0, element)
        table = inertial.find("inertia")
        defaults = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]
        moments = [
            value if table is None else model.number_in(table, key, value, element)
            for key, value in zip(_MOMENTS, defaults, strict=True)
        ]
        place = model.read_pose(inertial.find("pose"), element)
    written = " ".join(f'{key}="{v!r}"' for key, v in zip(_MOMENTS, moments, strict=True))
    return f'<inertial>{origin_text(place)}<mass value="{mass!r}"/><inertia {written}/></inertial>'


def _shape(model: SdfElements, item: Element, element: str) -> str:
    geometry = item.find("geometry")
    kind = None if geometry is None else next(iter(geometry), None)
    if kind is None or kind.tag not in ("box", "sphere", "cylinder", "mesh", "capsule"):
        what = "nothing" if kind is None else f"<{shown(kind.tag)}>"
        if kind is None or kind.tag != "empty":
            model.assumed.append(f"{element}: a <{item.tag}> of {what} is left out")
        return ""
    own = f" name={quoteattr(item.get('name', ''))}" if item.get("name") else ""
    place = origin_text(model.read_pose(item.find("pose"), element))
    if kind.tag == "mesh":
        uri = kind.find("uri")
        name = "" if uri is None else (uri.text or "").strip()
        scale = kind.find("scale")
        factors = "1 1 1" if scale is None else scale.text
        filename = name.replace("model://", "package://")
        shape = f"<mesh filename={quoteattr(filename)} scale={quoteattr(factors or '')}/>"
    elif kind.tag == "box":
        size = " ".join(map(repr, _sizes(model, kind, "size", 3, element)))
        shape = f'<box size="{size}"/>'
    else:
        (radius,) = _sizes(model, kind, "radius", 1, element)
        length = ""
        if kind.tag != "sphere":
            length = f' length="{_sizes(model, kind, "length", 1, element)[0]!r}"'
        shape = f'<{kind.tag} radius="{radius!r}"{length}/>'
        if kind.tag == "capsule":
            model.assumed.append(f"{element}: a capsule in <{item.tag}> is left out")
            return ""
    return f"<{item.tag}{own}>{place}<geometry>{shape}</geometry></{item.tag}>"


def _sizes(model: SdfElements, kind: Element, tag: str, count: int, element: str) -> list[float]:
    child = kind.find(tag)
    return model.numbers(None if child is None else child.text, count, element, f"<{tag}>")


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
