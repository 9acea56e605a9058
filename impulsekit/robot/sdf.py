"""SDF: a model becomes the elements of a URDF, and its loops plain data.

SDF places links in the model's frame and joints in their child link's frame; URDF hangs each
link on its joint. Where the two differ a link without mass stands between.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from ..errors import MjcfError, UrdfError, shown
from .arrays import LARGEST
from .robot_xml import Place, element, parsed_xml, text_of
from .source import Loop
from .urdf import UrdfText, checked_urdf
from .urdf_elements import MOMENTS
from .urdf_repairs import repair_text

KINDS = ("revolute", "continuous", "prismatic", "fixed", "ball", "universal", "revolute2")
# Two hinges in series.
TWO_HINGES = ("universal", "revolute2")
# The constraint that closes a loop, by kind of joint; hinges for all others.
_LOOPS = {"ball": "point", "fixed": "frame", "prismatic": "slide"}
# SDF's way to write "no limit" [rad, m].
_ENDLESS = 1e16
# Below this a placement is none [m, rad]: positions in files have fewer digits.
_SAME = 1e-12


@dataclass(frozen=True)
class SdfModel:
    """A model read from an SDF.

    Attributes:
        urdf: the model as a URDF that has passed the check.
        path: the file it came from, or None.
        loops: joints to links that another joint carries, and gearboxes.
        assumptions: what was assumed or left out.
    """

    urdf: UrdfText
    path: str | None
    loops: tuple[Loop, ...]
    assumptions: tuple[str, ...]


def read_sdf(source: Any, model: str | None = None) -> SdfModel:
    """Read one <model> of an SDF file or text.

    Raises:
        MjcfError: it cannot be read, holds several models and none is named, or has a joint
            that no rigid robot has; the element is named.
    """
    text, path = text_of(source, "from_sdf takes a path or SDF text, got", MjcfError)
    path = None if path is None else os.path.abspath(path)
    file = Place(path or "SDF text", kind=MjcfError)
    text, repairs = repair_text(text, "sdf")
    root = parsed_xml(text, file.source, MjcfError)
    models = [root] if root.tag == "model" else list(root.iter("model"))
    names = [each.get("name", "") for each in models]
    if root.tag not in ("sdf", "model", "world") or not models:
        sentence = "an SDF has <sdf> with a <model> in it"
        raise file.at(f"<{shown(root.tag)}>").fault(sentence)
    known = ", ".join(f'"{name}"' for name in names)
    if model is None and len(models) > 1:
        sentence = f"it holds {len(models)} models ({known}); name one: model="
        raise file.at("<sdf>").fault(sentence)
    if model is not None and names.count(model) != 1:
        several = f"{names.count(model)} models have this name, each needs one of its own"
        reason = several if model in names else f"no such model; choose {known}"
        raise file.at(f'model "{shown(model)}"').fault(reason)
    chosen = SdfElements(models[0 if model is None else names.index(model)], file)
    robot, loops = chosen.robot()
    try:
        urdf = checked_urdf(robot, "", None, source=file.source)
    except UrdfError as error:
        words = str(error).replace("a URDF", "a robot")
        raise MjcfError(words, source=file.source, element=error.element) from None
    assumed = (*repairs, *chosen.assumed, *urdf.assumptions)
    return SdfModel(urdf, path, loops, assumed)


class SdfElements:
    """A <model> of SDF, read as far as its parts are named and placed.

    Attributes:
        name: of the model.
        links, joints: their elements by name.
        placed: by link, its placement in the model's frame.
        assumed: what was assumed or left out; readers of the parts add to it.

    Raises:
        MjcfError: it includes other models, has no link, or a pose that cannot be read.
    """

    def __init__(self, model: Element, file: Place) -> None:
        self._file = file
        self.name = model.get("name") or "robot"
        self.links = {link.get("name", ""): link for link in model.findall("link")}
        self.joints = {joint.get("name", ""): joint for joint in model.findall("joint")}
        self.assumed: list[str] = []
        place = file.at("<model>")
        if model.find("include") is not None or model.find("model") is not None:
            raise place.fault("it includes other models; write them into one first")
        if not self.links:
            raise place.fault("it has no link")
        self.placed = {name: self._pose_of_link(name, ()) for name in self.links}

    def robot(self) -> tuple[Element, tuple[Loop, ...]]:
        """Return the model as a <robot>, and what has no place in a tree."""
        body: list[Element] = []
        closing = []
        joint_to: dict[str, str] = {}
        for name in self._trees_first():
            child = self._end_of(name, "child")
            if child in joint_to or child == "world":
                closing.append(name)
            else:
                joint_to[child] = name
                body += self._joint(name)
        links = [self._link(name) for name in self.links]
        on_world = any(self._end_of(name, "parent") == "world" for name in joint_to.values())
        # A model may write the world down as a link of its own.
        if on_world and "world" not in self.links:
            links.insert(0, element("link", name="world"))
        loops = [self._loop(name, body) for name in closing]
        for name, joint in self.joints.items():
            if joint.get("type") == "gearbox":
                loops.append(self._gearbox(name, joint_to))
        return element("robot", *links, *body, name=self.name), tuple(loops)

    def _trees_first(self) -> list[str]:
        """Joints but gearboxes; those whose rows a loop takes most easily come last."""
        kinds = {name: joint.get("type", "") for name, joint in self.joints.items()}
        for name, kind in kinds.items():
            if kind not in KINDS and kind != "gearbox":
                known = ", ".join([*KINDS, "gearbox"])
                place = self._place("joint", name)
                raise place.fault(f'its type is "{shown(kind)}", expected one of {known}')
        own = [name for name, kind in kinds.items() if kind != "gearbox"]
        return sorted(own, key=lambda name: kinds[name] == "ball")

    # -- numbers and poses ----------------------------------------------------------

    def _place(self, tag: str, name: str) -> Place:
        return self._file.at(f'{tag} "{shown(name)}"')

    def _end_of(self, joint: str, tag: str) -> str:
        end = self.joints[joint].find(tag)
        link = "" if end is None else (end.text or end.get("link") or "").strip()
        if link != "world" and link not in self.links:
            raise self._place("joint", joint).fault(f'its <{tag}> "{shown(link)}" is no link')
        return link

    def _pose_of_joint(self, name: str, seen: tuple[str, ...] = ()) -> pin.SE3:
        pose = self.joints[name].find("pose")
        own = _pose(pose, self._place("joint", name))
        if pose is not None and (pose.get("relative_to") or pose.get("frame")):
            return self._relative_to(pose, seen) * own
        return self._pose_of_link(self._end_of(name, "child"), seen) * own

    def _pose_of_link(self, name: str, seen: tuple[str, ...]) -> pin.SE3:
        """The pose of a link in the model's frame."""
        pose, place = self.links[name].find("pose"), self._place("link", name)
        if name in seen:
            raise place.fault("its pose is relative to itself")
        return self._relative_to(pose, (*seen, name)) * _pose(pose, place)

    def _relative_to(self, pose: Element | None, seen: tuple[str, ...]) -> pin.SE3:
        frame = "" if pose is None else pose.get("relative_to") or pose.get("frame") or ""
        if frame in ("", "__model__"):
            return pin.SE3.Identity()
        if frame in self.links:
            return self._pose_of_link(frame, seen)
        if frame in self.joints:
            return self._pose_of_joint(frame, seen)
        sentence = f'relative_to "{shown(frame)}" names no link or joint'
        raise self._file.at("<pose>").fault(sentence)

    # -- links ----------------------------------------------------------------------

    def _link(self, name: str) -> Element:
        link, place = self.links[name], self._place("link", name)
        items = [*link.findall("visual"), *link.findall("collision")]
        shapes = [self._shape(item, place) for item in items]
        return element("link", self._inertial(link.find("inertial"), place), *shapes, name=name)

    def _inertial(self, inertial: Element | None, place: Place) -> Element:
        mass, moments = 1.0, dict(zip(MOMENTS, (1.0, 0.0, 0.0, 1.0, 0.0, 1.0), strict=True))
        at = pin.SE3.Identity()
        if inertial is None:
            self.assumed.append(
                f"{place.element} has no <inertial>; SDF takes 1 kg and 1 kg m² then"
            )
        else:
            if (inertial.get("auto") or "").strip() in ("1", "true"):
                raise place.fault(
                    'its <inertial auto="true"> is worked out from shapes and densities, which is '
                    "not supported; give its <mass>, <pose> and <inertia>"
                )
            if inertial.find("fluid_added_mass") is not None:
                self.assumed.append(f"{place.element}: its <fluid_added_mass> is left out")
            mass = _number_in(inertial, "mass", 1.0, place)
            table = inertial.find("inertia")
            if table is not None:
                moments = {k: _number_in(table, k, usual, place) for k, usual in moments.items()}
            at = _pose(inertial.find("pose"), place)
        return element(
            "inertial", _origin(at), element("mass", value=mass), element("inertia", **moments)
        )

    def _shape(self, item: Element, place: Place) -> Element | None:
        geometry = item.find("geometry")
        kind = None if geometry is None else next(iter(geometry), None)
        tag = "" if kind is None else kind.tag
        if kind is None or tag not in ("box", "sphere", "cylinder", "mesh"):
            if tag != "empty":
                what = f"<{shown(tag)}>" if tag else "nothing"
                self.assumed.append(f"{place.element}: a <{item.tag}> of {what} is left out")
            return None
        if tag == "mesh":
            uri = (kind.findtext("uri") or "").strip().replace("model://", "package://")
            own: dict[str, Any] = {"filename": uri, "scale": kind.findtext("scale", "1 1 1")}
        else:
            keys = {"box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "length")}[tag]
            own = {
                key: place.numbers(kind.findtext(key), 3 if tag == "box" else 1, f"<{key}>")
                for key in keys
            }
        named = {"name": name} if (name := item.get("name")) else {}
        origin = _origin(_pose(item.find("pose"), place))
        return element(item.tag, origin, element("geometry", element(tag, **own)), **named)

    # -- joints ---------------------------------------------------------------------

    def _joint(self, name: str) -> Iterator[Element]:
        """The URDF joints that carry the child of a joint of the tree, and links between them."""
        parent, child = self._end_of(name, "parent"), self._end_of(name, "child")
        at = self._pose_of_joint(name)
        origin = self.placed.get(parent, pin.SE3.Identity()).actInv(at)
        to_child = at.actInv(self.placed[child])
        shifted = bool(abs(to_child.homogeneous - np.eye(4)).max() > _SAME)
        simple = list(self._simple(name, at))
        for k, (own, kind, parts) in enumerate(simple):
            below = child if k == len(simple) - 1 and not shifted else f"{own}__frame"
            if below != child:
                yield element("link", name=below)
            yield _joint_element(own, kind, parent, below, origin, *parts)
            parent, origin = below, pin.SE3.Identity()
        if shifted:
            yield _joint_element(f"{name}__fixed", "fixed", parent, child, to_child)

    def _simple(self, name: str, at: pin.SE3) -> Iterator[tuple[str, str, list[Element]]]:
        """Name, kind, axis and limit of each joint with one degree of freedom."""
        joint, kind = self.joints[name], self.joints[name].get("type", "")
        if kind == "fixed":
            yield name, "fixed", []
        elif kind == "ball":
            # A repair makes three hinges of it.
            yield name, "spherical", []
        elif kind in TWO_HINGES:
            self.assumed.append(f'{kind} joint "{name}" is two hinges, {name}_1 and {name}')
            for tag, own in (("axis", f"{name}_1"), ("axis2", name)):
                yield own, *self._moving(name, _child(joint, tag), "revolute", at)
        else:
            yield name, *self._moving(name, _child(joint, "axis"), kind, at)

    def _axis(self, name: str, axis: Element, at: pin.SE3) -> np.ndarray:
        """(3,) an axis in the joint's frame, of unit length."""
        place, xyz = self._place("joint", name), axis.find("xyz")
        if xyz is None:
            raise place.fault("it has no <axis> with an <xyz>")
        along = np.array(place.numbers(xyz.text, 3, "<xyz>"))
        if not along.any():
            raise place.fault("its <axis> has no length")
        frame = xyz.get("expressed_in", "")
        in_model = (axis.findtext("use_parent_model_frame") or "").strip() in ("1", "true")
        if in_model or frame == "__model__":
            along = at.rotation.T @ along
        elif frame and frame != name:
            if frame not in self.links:
                raise place.fault(f'expressed_in "{shown(frame)}" is no link')
            along = at.rotation.T @ self.placed[frame].rotation @ along
        return along / np.linalg.norm(along)

    def _moving(
        self, name: str, axis: Element, kind: str, at: pin.SE3
    ) -> tuple[str, list[Element]]:
        """The kind of a joint in URDF, and its <axis>, <limit> and <dynamics>."""
        place, parts = self._place("joint", name), [element("axis", xyz=self._axis(name, axis, at))]
        if axis.find("mimic") is not None:
            self.assumed.append(f"{place.element}: its <mimic> is left out, it moves on its own")
        limit, dynamics = axis.find("limit"), axis.find("dynamics")
        bounds = {
            tag: _bound(limit, tag, sign * _ENDLESS, place)
            for tag, sign in (("lower", -1.0), ("upper", 1.0), ("effort", 1.0), ("velocity", 1.0))
        }
        for tag in ("effort", "velocity"):
            bounds[tag] = LARGEST if bounds[tag] < 0.0 or limit is None else bounds[tag]
        endless = bounds["lower"] <= -_ENDLESS, bounds["upper"] >= _ENDLESS
        if kind == "revolute" and all(endless):
            kind = "continuous"
        if kind != "continuous":
            within = {tag: min(max(x, -LARGEST), LARGEST) for tag, x in bounds.items()}
            parts.append(element("limit", **within))
        if dynamics is not None:
            own = {t: _number_in(dynamics, t, 0.0, place) for t in ("damping", "friction")}
            parts.append(element("dynamics", **own))
        return kind, parts

    def _loop(self, name: str, body: list[Element]) -> Loop:
        """A joint to a link that hangs elsewhere: frames on both sides, and a constraint."""
        kind, at = self.joints[name].get("type", ""), self._pose_of_joint(name)
        if kind in TWO_HINGES:
            place = self._place("joint", name)
            raise place.fault("it closes a loop, which a universal joint cannot here")
        if kind in ("revolute", "continuous", "prismatic"):
            axis = self._axis(name, _child(self.joints[name], "axis"), at)
            at = pin.SE3(at.rotation @ _with_z_along(axis), at.translation)
        for tag in ("parent", "child"):
            link, frame = self._end_of(name, tag), f"{name}__{tag}"
            origin = at if link == "world" else self.placed[link].actInv(at)
            body.append(element("link", name=frame))
            body.append(_joint_element(f"{frame}_fixed", "fixed", link, frame, origin))
        ends, none = (f"{name}__child", f"{name}__parent"), (0.0, 0.0, 0.0)
        return Loop(_LOOPS.get(kind, "hinge"), name, *ends, none, none)

    def _gearbox(self, name: str, joint_to: Mapping[str, str]) -> Loop:
        """theta_child = -ratio theta_parent, both against the reference body."""
        joint, place = self.joints[name], self._place("joint", name)
        reference = (joint.findtext("gearbox_reference_body") or "").strip()
        ratio = _number_in(joint, "gearbox_ratio", 1.0, place)
        speeds = []
        for tag in ("parent", "child"):
            body = self._end_of(name, tag)
            between = [
                (own, 1.0 if self._end_of(own, "child") == body else -1.0)
                for own in joint_to.values()
                if {self._end_of(own, "parent"), self._end_of(own, "child")} == {body, reference}
            ]
            if not between:
                ends = f'"{shown(body)}" and its reference body "{shown(reference)}"'
                raise place.fault(f"no joint connects {ends}")
            speeds.append(between[0])
        (driver, sign_in), (driven, sign_out) = speeds
        return Loop("coupling", name, driven, driver, ratio=-ratio * sign_in * sign_out)


def _pose(pose: Element | None, place: Place) -> pin.SE3:
    if pose is None or not (pose.text or "").strip():
        return pin.SE3.Identity()
    if pose.get("rotation_format", "euler_rpy") != "euler_rpy" or pose.get("degrees") == "true":
        raise place.fault(
            "its <pose> is in degrees or a quaternion; write roll, pitch, yaw in radian"
        )
    numbers = place.numbers(pose.text, 6, "<pose>")
    return pin.SE3(pin.rpy.rpyToMatrix(*numbers[3:]), np.array(numbers[:3]))


def _child(parent: Element, tag: str) -> Element:
    found = parent.find(tag)
    return Element(tag) if found is None else found


def _number_in(parent: Element, tag: str, default: float, place: Place) -> float:
    child = parent.find(tag)
    return default if child is None else place.number(child.text, f"<{tag}>")


def _bound(limit: Element | None, tag: str, endless: float, place: Place) -> float:
    text = None if limit is None else limit.findtext(tag)
    if text is None or text.strip().lower().lstrip("+-") in ("inf", "infinity"):
        return endless
    return place.number(text, f"<{tag}>")


def _origin(place: pin.SE3) -> Element:
    return element("origin", xyz=place.translation, rpy=pin.rpy.matrixToRpy(place.rotation))


def _joint_element(
    name: str, kind: str, parent: str, child: str, origin: pin.SE3, *parts: Element
) -> Element:
    ends = element("parent", link=parent), element("child", link=child)
    return element("joint", *ends, _origin(origin), *parts, name=name, type=kind)


def _with_z_along(axis: np.ndarray) -> np.ndarray:
    """(3, 3) a rotation whose third column is the axis."""
    other = np.eye(3)[int(np.argmin(abs(axis)))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])
