"""What a robot looks like: the shapes on each joint, whatever is missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ..errors import UrdfError
from ..robot import Robot
from .coal_surfaces import surface_of
from .simple_bodies import simple_body
from .surfaces import Surface

if TYPE_CHECKING:
    from ..robot import RobotPart

__all__ = ["BodyShape", "body_shapes", "robot_colors"]

# Links without a colour of their own take these in turn, so that neighbours differ.
PALETTE: tuple[tuple[float, float, float, float], ...] = (
    (0.36, 0.47, 0.58, 1.0),
    (0.66, 0.71, 0.76, 1.0),
)
# Where there are several robots, the first one takes the first of these, and so on.
ROBOTS: tuple[tuple[float, float, float], ...] = (
    (0.36, 0.47, 0.58),
    (0.80, 0.47, 0.22),
    (0.35, 0.60, 0.38),
    (0.58, 0.40, 0.66),
    (0.80, 0.66, 0.24),
    (0.25, 0.60, 0.64),
)
# Of several robots, this share of every colour is the robot's own.
OWN_SHARE = 0.6
# What Pinocchio paints a visual that has no material.
_NO_MATERIAL = (0.9, 0.9, 0.9, 1.0)


@dataclass(frozen=True, eq=False)
class BodyShape:
    """One surface fixed to a joint.

    Attributes:
        name: the geometry's name in the URDF, or the link's.
        joint_id: the joint that carries it; 0 for what stands still in the world.
        surface: the triangles.
        placement: in the joint's frame.
        color: red, green, blue and opacity.
        simple: whether it stands for a link that has no picture.
        body: the link's name.
    """

    name: str
    joint_id: int
    surface: Surface
    placement: pin.SE3
    color: tuple[float, float, float, float]
    simple: bool = False
    body: str = ""


def body_shapes(robot: Robot) -> tuple[tuple[BodyShape, ...], tuple[str, ...]]:
    """The shapes of a robot, and a sentence for each mesh that could not be read.

    A body without any visual, or a link whose mesh is missing, is drawn as a simple body.
    """
    readable, dropped, notes = _without_missing_meshes(robot)
    shapes = _visuals(readable, notes)
    # What is fixed to a link that has a picture needs none of its own.
    pictured = {shape.joint_id for shape in shapes}
    for i, link in enumerate(robot.links):
        if link.joint_id in pictured and link.name not in dropped:
            continue
        body = simple_body(link)
        if body is not None:
            color = PALETTE[i % len(PALETTE)]
            shapes.append(BodyShape(link.name, link.joint_id, *body, color, True, link.name))
    if len(robot.parts) > 1:
        colors = robot_colors(robot)
        shapes = [_tinted(shape, colors) for shape in shapes]
    return tuple(shapes), tuple(notes)


def robot_colors(robot: Robot) -> dict[str, tuple[float, float, float]]:
    """By prefix, such as "arm/", the colour of each robot of several; the same at every look."""
    return {part.prefix: ROBOTS[i % len(ROBOTS)] for i, part in enumerate(robot.parts)}


def _tinted(shape: BodyShape, colors: Mapping[str, tuple[float, float, float]]) -> BodyShape:
    """A shape in its robot's colour, with a part of its own so that links are told apart."""
    own = next((c for prefix, c in colors.items() if shape.body.startswith(prefix)), None)
    if own is None:
        return shape
    share = OWN_SHARE * np.array(own)
    mixed = (share + (1.0 - OWN_SHARE) * np.array(shape.color[:3])).tolist()
    surface = shape.surface
    if surface.colors is not None:
        surface = replace(surface, colors=share + (1.0 - OWN_SHARE) * surface.colors)
    return replace(shape, surface=surface, color=(*mixed, shape.color[3]))


def _visuals(robot: Robot, notes: list[str]) -> list[BodyShape]:
    """The shapes of the URDFs; what cannot be drawn goes to the notes."""
    shapes: list[BodyShape] = []
    for item in robot.visual_model.geometryObjects:
        surface = surface_of(item)
        if surface is None:
            notes.append(f'"{item.name}" is a {type(item.geometry).__name__}, which is not drawn')
            continue
        red, green, blue, opacity = (float(c) for c in item.meshColor)
        color = (red, green, blue, opacity if opacity > 0.0 else 1.0)
        if not item.overrideMaterial and np.allclose(color, _NO_MATERIAL):
            color = PALETTE[item.parentJoint % len(PALETTE)]
        placement = pin.SE3(item.placement)
        body = robot.model.frames[item.parentFrame].name
        shapes.append(BodyShape(item.name, item.parentJoint, surface, placement, color, body=body))
    return shapes


def _without_missing_meshes(robot: Robot) -> tuple[Robot, set[str], list[str]]:
    """The robot without visuals whose meshes cannot be read, those links, and why."""
    try:
        _ = robot.visual_model
        return robot, set(), []
    except UrdfError:
        pass
    parts: list[RobotPart] = []
    dropped: set[str] = set()
    notes: list[str] = []
    for part in robot.parts:
        parts.append(_cleaned(part, dropped, notes))
    return Robot(robot.model, parts, robot.name), dropped, notes


def _cleaned(part: RobotPart, dropped: set[str], notes: list[str]) -> RobotPart:
    if part.urdf is None:
        return part
    tree = ElementTree.fromstring(part.urdf)
    model = Robot.from_urdf(part.urdf).model
    while True:
        cleaned = replace(part, urdf=ElementTree.tostring(tree, encoding="unicode"))
        try:
            _ = Robot(model, [replace(cleaned, prefix="", placement=None)], "").visual_model
            return cleaned
        except UrdfError as error:
            links = _drop_unreadable(tree, str(error))
            if not links:
                raise
            dropped.update(part.prefix + link for link in links)
            several = f" and {len(links) - 1} more" if len(links) > 1 else ""
            notes.append(f'"{part.prefix}{links[0]}"{several} drawn as a simple body: {error}')


def _drop_unreadable(tree: ElementTree.Element, message: str) -> list[str]:
    """Take out the visuals with the mesh that a message names; all of them if it names none.

    Returns:
        The links that lost one.
    """
    visuals = [
        (link, visual, mesh.get("filename", ""))
        for link in tree.findall("link")
        for visual in link.findall("visual")
        if (mesh := visual.find("geometry/mesh")) is not None
    ]
    named = [entry for entry in visuals if entry[2] and _tail(entry[2]) in message]
    for link, visual, _ in named or visuals:
        link.remove(visual)
    return [link.get("name", "") for link, _, _ in named or visuals]


def _tail(filename: str) -> str:
    return filename.removeprefix("package://").removeprefix("file://")


def corners_of(shapes: Sequence[BodyShape], joint_id: int) -> np.ndarray:
    """(n, 3) corners of boxes around the shapes on a joint, in the joint's frame [m]."""
    corners = [
        shape.placement.act(corner)
        for shape in shapes
        if shape.joint_id == joint_id
        for corner in shape.surface.corners
    ]
    return np.array(corners).reshape(-1, 3)
