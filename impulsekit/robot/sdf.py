"""SDF: a model is written anew as a URDF, which all else reads; loops become plain data.

SDF places links in the model's frame and joints in their child link's frame; URDF hangs each
link on its joint. Where the two differ a link without mass stands between.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np
import pinocchio as pin

from ..errors import MjcfError, a_thing, shown
from ..files import open_plain_file, reason_of
from .loop import Loop
from .urdf_repairs import repair_text

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["SdfModel", "read_sdf"]

_KINDS = {"revolute": "revolute", "continuous": "continuous", "prismatic": "prismatic",
          "fixed": "fixed", "ball": "ball", "universal": "universal"}  # fmt: skip
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
# SDF's way to write "no limit" [rad, m].
_ENDLESS = 1e16
# Below this a placement is none [m, rad]: positions in files have fewer digits.
_SAME = 1e-12


@dataclass(frozen=True)
class SdfModel:
    """What is read from an SDF.

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
        raise _error(label, f"<{shown(root.tag)}>", "an SDF has <sdf> with a <model> in it")
    names = [each.get("name", "") for each in models]
    if model is not None and model not in names:
        listed = ", ".join(f'"{name}"' for name in names)
        raise _error(label, f'model "{shown(model)}"', f"no such model; choose {listed}")
    if model is None and len(models) > 1:
        listed = ", ".join(f'"{name}"' for name in names)
        raise _error(label, "<sdf>", f"it holds {len(models)} models ({listed}); name one: model=")
    chosen = models[0] if model is None else models[names.index(model)]
    written = _Writer(chosen, label).written(path)
    return replace(written, assumptions=(*repairs, *written.assumptions))


class _Writer:
    def __init__(self, model: Element, label: str) -> None:
        self.model, self.label = model, label
        self.name = model.get("name") or "robot"
        self.links = {link.get("name", ""): link for link in model.findall("link")}
        self.joints = {joint.get("name", ""): joint for joint in model.findall("joint")}
        self.assumed: list[str] = []
        self.loops: list[Loop] = []
        if model.find("include") is not None or model.find("model") is not None:
            raise self.error("<model>", "it includes other models; write them into one first")
        if not self.links:
            raise self.error("<model>", "it has no link")
        self.placed = {name: self._pose_of_link(name, ()) for name in self.links}
        self.joint_to: dict[str, str] = {}

    def error(self, element: str, sentence: str) -> MjcfError:
        return _error(self.label, element, sentence)

    def written(self, path: str | None) -> SdfModel:
        body: list[str] = []
        closing = []
        for name in self._trees_first():
            child = self._end(name, "child")
            if child in self.joint_to or child == "world":
                closing.append(name)
            else:
                self.joint_to[child] = name
                body += self._joint(name)
        links = [self._link(name) for name in self.links]
        on_world = any(self._end(name, "parent") == "world" for name in self.joint_to.values())
        # A model may write the world down as a link of its own.
        if on_world and "world" not in self.links:
            links.insert(0, '<link name="world"/>')
        for name in closing:
            body += self._loop(name)
        for name, joint in self.joints.items():
            if joint.get("type") == "gearbox":
                self.loops.append(self._gearbox(name))
        text = f"<robot name={quoteattr(self.name)}>" + "".join([*links, *body]) + "</robot>"
        return SdfModel(text, path, tuple(self.loops), tuple(self.assumed))

    def _trees_first(self) -> Iterator[str]:
        """Joints but gearboxes; those whose rows a loop takes most easily come last."""
        rank = {"ball": 1}
        kinds = {name: joint.get("type", "") for name, joint in self.joints.items()}
        for name, kind in kinds.items():
            if kind not in _KINDS and kind != "gearbox":
                known = ", ".join([*_KINDS, "gearbox"])
                raise self.error(
                    f'joint "{shown(name)}"',
                    f'its type is "{shown(kind)}", expected one of {known}',
                )
        own = [name for name, kind in kinds.items() if kind != "gearbox"]
        return iter(sorted(own, key=lambda name: rank.get(kinds[name], 0)))

    # -- places ------------------------------------------------------------------------

    def _pose_of_link(self, name: str, seen: tuple[str, ...]) -> pin.SE3:
        """Where a link is in the model's frame."""
        pose = self.links[name].find("pose")
        if name in seen:
            raise self.error(f'link "{shown(name)}"', "its pose is relative to itself")
        return self._relative_to(pose, (*seen, name)) * self._pose(pose, f'link "{shown(name)}"')

    def _relative_to(self, pose: Element | None, seen: tuple[str, ...]) -> pin.SE3:
        frame = "" if pose is None else pose.get("relative_to") or pose.get("frame") or ""
        if frame in ("", "__model__"):
            return pin.SE3.Identity()
        if frame in self.links:
            return self._pose_of_link(frame, seen)
        if frame in self.joints:
            return self._pose_of_joint(frame, seen)
        raise self.error("<pose>", f'relative_to "{shown(frame)}" names no link or joint')

    def _pose_of_joint(self, name: str, seen: tuple[str, ...] = ()) -> pin.SE3:
        pose = self.joints[name].find("pose")
        own = self._pose(pose, f'joint "{shown(name)}"')
        if pose is not None and (pose.get("relative_to") or pose.get("frame")):
            return self._relative_to(pose, seen) * own
        child = self._end(name, "child")
        return self._pose_of_link(child, seen) * own

    def _pose(self, pose: Element | None, element: str) -> pin.SE3:
        if pose is None or not (pose.text or "").strip():
            return pin.SE3.Identity()
        if pose.get("rotation_format", "euler_rpy") != "euler_rpy" or pose.get("degrees") == "true":
            raise self.error(
                element,
                "its <pose> is in degrees or a quaternion; write roll, pitch, yaw in radian",
            )
        numbers = self.numbers(pose.text, 6, element, "<pose>")
        return pin.SE3(pin.rpy.rpyToMatrix(*numbers[3:]), np.array(numbers[:3]))

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

    def _end(self, joint: str, tag: str) -> str:
        end = self.joints[joint].find(tag)
        link = "" if end is None else (end.text or end.get("link") or "").strip()
        if link != "world" and link not in self.links:
            raise self.error(f'joint "{shown(joint)}"', f'its <{tag}> "{shown(link)}" is no link')
        return link

    # -- links ---------------------------------------------------------------------------

    def _link(self, name: str) -> str:
        link, element = self.links[name], f'link "{shown(name)}"'
        parts = [f"<link name={quoteattr(name)}>", self._inertial(link, element)]
        for tag in ("visual", "collision"):
            for item in link.findall(tag):
                parts.append(self._shape(item, element))
        return "".join([*parts, "</link>"])

    def _inertial(self, link: Element, element: str) -> str:
        inertial = link.find("inertial")
        if inertial is None:
            self.assumed.append(f"{element} has no <inertial>; SDF takes 1 kg and 1 kg m² then")
            mass, moments = 1.0, [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]
            place = pin.SE3.Identity()
        else:
            mass = self._number_in(inertial, "mass", 1.0, element)
            table = inertial.find("inertia")
            defaults = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]
            moments = [
                value if table is None else self._number_in(table, key, value, element)
                for key, value in zip(_MOMENTS, defaults, strict=True)
            ]
            place = self._pose(inertial.find("pose"), element)
        written = " ".join(f'{key}="{v!r}"' for key, v in zip(_MOMENTS, moments, strict=True))
        return f'<inertial>{_origin(place)}<mass value="{mass!r}"/><inertia {written}/></inertial>'

    def _number_in(self, parent: Element, tag: str, default: float, element: str) -> float:
        child = parent.find(tag)
        if child is None:
            return default
        return self.numbers(child.text, 1, element, f"<{tag}>")[0]

    def _shape(self, item: Element, element: str) -> str:
        geometry = item.find("geometry")
        kind = None if geometry is None else next(iter(geometry), None)
        if kind is None or kind.tag not in ("box", "sphere", "cylinder", "mesh", "capsule"):
            what = "nothing" if kind is None else f"<{shown(kind.tag)}>"
            if kind is None or kind.tag != "empty":
                self.assumed.append(f"{element}: a <{item.tag}> of {what} is left out")
            return ""
        own = f" name={quoteattr(item.get('name', ''))}" if item.get("name") else ""
        place = _origin(self._pose(item.find("pose"), element))
        if kind.tag == "mesh":
            uri = kind.find("uri")
            name = "" if uri is None else (uri.text or "").strip()
            scale = kind.find("scale")
            factors = "1 1 1" if scale is None else scale.text
            filename = name.replace("model://", "package://")
            shape = f"<mesh filename={quoteattr(filename)} scale={quoteattr(factors or '')}/>"
        elif kind.tag == "box":
            size = " ".join(map(repr, self._sizes(kind, "size", 3, element)))
            shape = f'<box size="{size}"/>'
        else:
            (radius,) = self._sizes(kind, "radius", 1, element)
            length = ""
            if kind.tag != "sphere":
                length = f' length="{self._sizes(kind, "length", 1, element)[0]!r}"'
            shape = f'<{kind.tag} radius="{radius!r}"{length}/>'
            if kind.tag == "capsule":
                self.assumed.append(f"{element}: a capsule in <{item.tag}> is left out")
                return ""
        return f"<{item.tag}{own}>{place}<geometry>{shape}</geometry></{item.tag}>"

    def _sizes(self, kind: Element, tag: str, count: int, element: str) -> list[float]:
        child = kind.find(tag)
        return self.numbers(None if child is None else child.text, count, element, f"<{tag}>")

    # -- joints --------------------------------------------------------------------------

    def _joint(self, name: str) -> list[str]:
        """The URDF joints that carry the child of a joint of the tree."""
        joint, kind = self.joints[name], self.joints[name].get("type", "")
        parent, child = self._end(name, "parent"), self._end(name, "child")
        above = self.placed.get(parent, pin.SE3.Identity())
        at = self._pose_of_joint(name)
        from_parent, to_child = above.actInv(at), at.actInv(self.placed[child])
        shifted = bool(abs(to_child.homogeneous - np.eye(4)).max() > _SAME)
        simple = list(self._simple(name, joint, kind, at))
        written, last = [], len(simple) - 1
        for k, (own, each, axis, limits) in enumerate(simple):
            below = child if k == last and not shifted else f"{own}__frame"
            if below != child:
                written.append(f"<link name={quoteattr(below)}/>")
            moving = f'<axis xyz="{_listed(axis)}"/>{limits}' if each != "fixed" else ""
            written.append(
                f'<joint name={quoteattr(own)} type="{each}"><parent link={quoteattr(parent)}/>'
                f"<child link={quoteattr(below)}/>{_origin(from_parent)}{moving}</joint>"
            )
            parent, from_parent = below, pin.SE3.Identity()
        if shifted:
            written.append(
                f'<joint name={quoteattr(name + "__fixed")} type="fixed"><parent '
                f"link={quoteattr(parent)}/><child link={quoteattr(child)}/>"
                f"{_origin(to_child)}</joint>"
            )
        return written

    def _simple(
        self, name: str, joint: Element, kind: str, at: pin.SE3
    ) -> Iterator[tuple[str, str, Any, str]]:
        """Name, kind, axis and limit of each joint with one degree of freedom."""
        if kind == "fixed":
            yield name, "fixed", None, ""
        elif kind == "ball":
            self.assumed.append(f'ball joint "{name}" is three hinges, {name}_x, _y and _z')
            for letter, axis in zip("xyz", np.eye(3), strict=True):
                own = name if letter == "z" else f"{name}_{letter}"
                yield own, "continuous", axis, ""
        elif kind == "universal":
            self.assumed.append(f'universal joint "{name}" is two hinges, {name}_1 and {name}')
            for tag, own in (("axis", f"{name}_1"), ("axis2", name)):
                axis, limits, each = self._axis(name, joint.find(tag), "revolute", at)
                yield own, each, axis, limits
        else:
            axis, limits, each = self._axis(name, joint.find("axis"), kind, at)
            yield name, each, axis, limits

    def _axis(
        self, name: str, axis: Element | None, kind: str, at: pin.SE3
    ) -> tuple[np.ndarray, str, str]:
        """An axis in the joint's frame, its <limit> and <dynamics>, and the URDF kind."""
        element = f'joint "{shown(name)}"'
        xyz = None if axis is None else axis.find("xyz")
        if axis is None or xyz is None:
            raise self.error(element, "it has no <axis> with an <xyz>")
        along = np.array(self.numbers(xyz.text, 3, element, "<xyz>"))
        if not along.any():
            raise self.error(element, "its <axis> has no length")
        frame = xyz.get("expressed_in", "")
        in_model = (axis.findtext("use_parent_model_frame") or "").strip() in ("1", "true")
        if in_model or frame == "__model__":
            along = at.rotation.T @ along
        elif frame and frame != name:
            if frame not in self.links:
                raise self.error(element, f'expressed_in "{shown(frame)}" is no link')
            along = at.rotation.T @ self.placed[frame].rotation @ along
        limit, dynamics = axis.find("limit"), axis.find("dynamics")
        lower, upper = (
            (sign * _ENDLESS if limit is None else self._bound(limit, tag, sign, element))
            for tag, sign in (("lower", -1.0), ("upper", 1.0))
        )
        each, text = kind, ""
        if kind == "revolute" and (lower <= -_ENDLESS or upper >= _ENDLESS):
            each = "continuous" if lower <= -_ENDLESS and upper >= _ENDLESS else kind
        if each in ("revolute", "prismatic"):
            effort, speed = (
                1e100 if limit is None else self._bound(limit, tag, 1.0, element)
                for tag in ("effort", "velocity")
            )
            effort, speed = (1e100 if value < 0.0 else value for value in (effort, speed))
            text = (
                f'<limit lower="{max(lower, -1e100)!r}" upper="{min(upper, 1e100)!r}" '
                f'effort="{min(effort, 1e100)!r}" velocity="{min(speed, 1e100)!r}"/>'
            )
        if dynamics is not None:
            damping, friction = (
                self._number_in(dynamics, tag, 0.0, element) for tag in ("damping", "friction")
            )
            text += f'<dynamics damping="{damping!r}" friction="{friction!r}"/>'
        return along / np.linalg.norm(along), text, each

    def _bound(self, limit: Element, tag: str, sign: float, element: str) -> float:
        text = limit.findtext(tag)
        if text is None or text.strip().lower().lstrip("+-") in ("inf", "infinity"):
            return sign * _ENDLESS
        return self.numbers(text, 1, element, f"<{tag}>")[0]

    # -- loops ----------------------------------------------------------------------------

    def _loop(self, name: str) -> list[str]:
        """A joint to a link that hangs elsewhere: frames on both sides, and a constraint."""
        joint, kind = self.joints[name], self.joints[name].get("type", "")
        parent, child = self._end(name, "parent"), self._end(name, "child")
        if kind == "universal":
            raise self.error(
                f'joint "{shown(name)}"', "it closes a loop, which a universal joint cannot here"
            )
        at = self._pose_of_joint(name)
        if kind in ("revolute", "continuous", "prismatic"):
            axis, _, _ = self._axis(name, joint.find("axis"), kind, at)
            at = pin.SE3(at.rotation @ _with_z_along(axis), at.translation)
        written = []
        ends = []
        for tag, link in (("parent", parent), ("child", child)):
            frame = f"{name}__{tag}"
            place = at if link == "world" else self.placed[link].actInv(at)
            written.append(
                f"<link name={quoteattr(frame)}/><joint name={quoteattr(frame + '_fixed')} "
                f'type="fixed"><parent link={quoteattr(link)}/><child link={quoteattr(frame)}/>'
                f"{_origin(place)}</joint>"
            )
            ends.append(frame)
        none = (0.0, 0.0, 0.0)
        loop = {"ball": "point", "fixed": "frame", "prismatic": "slide"}.get(kind, "hinge")
        self.loops.append(Loop(loop, name, ends[1], ends[0], none, none))
        return written

    def _gearbox(self, name: str) -> Loop:
        """theta_child = -ratio theta_parent, both against the reference body."""
        joint, element = self.joints[name], f'joint "{shown(name)}"'
        reference = (joint.findtext("gearbox_reference_body") or "").strip()
        ratio = self._number_in(joint, "gearbox_ratio", 1.0, element)
        speeds = []
        for tag in ("parent", "child"):
            body = self._end(name, tag)
            between = [
                (own, 1.0 if self._end(own, "child") == body else -1.0)
                for own in self.joint_to.values()
                if {self._end(own, "parent"), self._end(own, "child")} == {body, reference}
            ]
            if not between:
                raise self.error(
                    element,
                    f'no joint connects "{shown(body)}" and its reference body '
                    f'"{shown(reference)}"',
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


def _origin(place: pin.SE3) -> str:
    rpy = pin.rpy.matrixToRpy(place.rotation)
    return f'<origin xyz="{_listed(place.translation)}" rpy="{_listed(rpy)}"/>'


def _listed(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


def _text_of(source: Any) -> tuple[str, str | None]:
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        return source.lstrip("\ufeff \t\r\n"), None
    if not isinstance(source, str | os.PathLike):
        raise _error("", "", f"from_sdf takes a path or SDF text, got {a_thing(source)}")
    path = os.fspath(source)
    try:
        with open_plain_file(path) as file:
            return file.read().decode("utf-8-sig").lstrip(), os.path.abspath(path)
    except UnicodeDecodeError:
        raise _error(shown(path, 200), "", "the file is not UTF-8 text") from None
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "the path holds a NUL"
        raise _error(shown(path, 200), "", reason) from None


def _error(source: str, element: str, sentence: str) -> MjcfError:
    where = ": ".join(part for part in (source, element) if part)
    text = f"{where}: {sentence}" if where else sentence
    return MjcfError(text, source=source, element=element)
