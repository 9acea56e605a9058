"""The parts of an SDF model: its links and joints by name, and where each is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import MjcfError, shown

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["SdfElements", "listed", "origin_text", "sdf_error"]


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
        """Where a link is in the model's frame."""
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
