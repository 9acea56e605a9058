"""The bodies of a replay: the shapes on each joint, simple ones where pictures are missing."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin

from ..errors import UrdfError
from ..robot import Robot, RobotPart
from ..robot.masses import Link
from .drawing import Drawing, capsule, cylinder, node_name, node_path, shapes
from .motions import Shown

# A box is drawn no thinner than this share of its longest edge.
THINNEST = 0.04
# The radius of the thinnest rod drawn, of the extent of the scene: four pixels of a picture.
THINNEST_ROD = 1 / 250
# A mass without inertia is drawn as a ball of this density [kg/m³].
DENSITY = 2000.0
# Collada is read twice, by Pinocchio and for its colours; both must agree this well.
SAME_SIZE = 1e-3
# Links without a colour of their own take these in turn, so that neighbours differ.
PALETTE = ((0.36, 0.47, 0.58), (0.66, 0.71, 0.76))
# Where there are several robots, the first one takes the first of these, and so on.
ROBOTS = (
    (0.36, 0.47, 0.58),
    (0.80, 0.47, 0.22),
    (0.35, 0.60, 0.38),
    (0.58, 0.40, 0.66),
    (0.80, 0.66, 0.24),
    (0.25, 0.60, 0.64),
)
# Of several robots, this share of every colour is the robot's own.
OWN_SHARE = 0.6
# The colour Pinocchio gives a visual without a material.
NO_MATERIAL = (0.9, 0.9, 0.9, 1.0)
GHOST_OPACITY = 0.22
# [m] The least size, for a robot whose shapes and joints are all at one point.
LEAST_REACH = 1e-6
# For the camera's fit a motion is looked at in so many poses.
LOOKS = 60
# Which corner of a box has the larger x, y and z.
CORNERS = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)], dtype=bool)


def simple_body(link: Link) -> pin.GeometryObject | None:
    """Return the uniform box with a link's mass and inertia; None for a massless link."""
    if link.mass <= 0.0:
        return None
    shape: coal.ShapeBase = coal.Sphere((3.0 * link.mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0))
    rotation = np.eye(3)
    if link.inertia_in_joint_axes.any():
        lengths, rotation = equivalent_box(link.mass, link.inertia_in_joint_axes)
        shape = coal.Box(*lengths)
    placement = pin.SE3(rotation, link.com_in_joint)
    return pin.GeometryObject(link.name, link.joint_id, link.frame_id, placement, shape)


def equivalent_box(mass: float, inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Compute the uniform box with a ``mass`` [kg] and an ``inertia`` about its centre [kg m²].

    Returns:
        (3,) edge lengths [m], from I_x = m (b² + c²)/12 and the two like it, and (3, 3)
        the edges' directions as columns. Edges too thin to be seen are made thicker.

    Example:
        >>> lengths, _ = equivalent_box(12.0, np.diag([13.0, 10.0, 5.0]))
        >>> [round(float(x), 6) for x in sorted(lengths)]
        [1.0, 2.0, 3.0]
    """
    moments, axes = np.linalg.eigh(inertia)
    if np.count_nonzero(inertia - np.diag(np.diagonal(inertia))) == 0:
        moments, axes = np.diagonal(inertia), np.eye(3)
    if np.linalg.det(axes) < 0.0:
        axes = axes * [1.0, 1.0, -1.0]
    squares = 6.0 * (moments.sum() - 2.0 * moments) / mass
    lengths = np.sqrt(np.maximum(squares, 0.0))
    longest = float(lengths.max())
    if longest == 0.0:
        longest = (mass / DENSITY) ** (1.0 / 3.0)
    return np.maximum(lengths, THINNEST * longest), axes


def drawn_shape(item: pin.GeometryObject) -> shapes.Geometry | None:
    """Return the player's shape of a geometry object, in its own frame; None where it has none."""
    shape = item.geometry
    kind = type(shape).__name__
    if kind == "Box":
        return shapes.Box((2.0 * np.array(shape.halfSide)).tolist())
    if kind in ("Sphere", "Ellipsoid"):
        return shapes.Ellipsoid([shape.radius] * 3 if kind == "Sphere" else np.array(shape.radii))
    if kind in ("Cylinder", "Cone"):
        return cylinder(shape.radius, shape.halfLength, 0.0 if kind == "Cone" else None)
    if kind == "Capsule":
        return capsule(shape.radius, shape.halfLength)
    if kind.startswith("Convex"):
        points = np.array([shape.point(i) for i in range(shape.num_points)])
        hull = coal.Convex.convexHull(points, True, "")
        faces = [list(hull.polygons(i)) for i in range(hull.num_polygons)]
        return shapes.TriangularMeshGeometry(points, faces)
    if not getattr(shape, "num_tris", 0):
        return None
    colored = None if item.overrideMaterial else _colored(item)
    if colored is not None:
        return colored
    triangles = (shape.tri_indices(i) for i in range(shape.num_tris))
    faces = [[t[0], t[1], t[2]] for t in triangles]
    return shapes.TriangularMeshGeometry(np.array(shape.vertices()).reshape(-1, 3), faces)


def _colored(item: pin.GeometryObject) -> shapes.TriangularMeshGeometry | None:
    """Return a Collada file with a colour for each part; None if it has none or reads otherwise."""
    if not (item.meshPath.lower().endswith(".dae") and os.path.isfile(item.meshPath)):
        return None
    try:
        import trimesh

        scene: Any = trimesh.load(item.meshPath, force="scene", process=False)
        parts = [_part(part) for part in scene.dump() if len(part.faces)]
    except Exception:
        # Colours are a courtesy: whatever a reader stumbles over, the plain mesh is there.
        return None
    if not parts:
        return None
    starts = np.cumsum([0, *(len(vertices) for vertices, _, _ in parts[:-1])])
    faces = np.concatenate([faces + k for (_, faces, _), k in zip(parts, starts, strict=True)])
    vertices, colors = (np.concatenate([part[i] for part in parts]) for i in (0, 2))
    vertices = vertices * np.array(item.meshScale).ravel()
    ends, plain = np.array([vertices.min(axis=0), vertices.max(axis=0)]), box_of(item)
    if np.abs(ends - plain).max() > SAME_SIZE * np.ptp(plain, axis=0).max():
        return None
    return shapes.TriangularMeshGeometry(vertices, faces, colors)


def _part(part: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the vertices, faces and colours of a part."""
    material = getattr(part.visual, "material", None)
    color = getattr(material, "main_color", None)
    rgb = np.array([230, 230, 230] if color is None else color[:3], dtype=float) / 255.0
    # A corner is stored once for every normal it has; drawn flat, one of them will do.
    corners = np.asarray(part.vertices, dtype=np.float32)
    corners, place = np.unique(corners, axis=0, return_inverse=True)
    faces = place.reshape(-1)[np.asarray(part.faces)]
    return corners, faces, np.tile(rgb, (len(corners), 1))


def box_of(item: pin.GeometryObject) -> np.ndarray:
    """Return (2, 3): the least and the greatest coordinates of a geometry in its own frame [m]."""
    item.geometry.computeLocalAABB()
    box = item.geometry.aabb_local
    return np.array([box.min_, box.max_])


@dataclass(frozen=True, eq=False)
class BodyShape:
    """One shape fixed to a joint.

    Attributes:
        item: Pinocchio's, with its name, joint and placement; joint 0 is the world.
        shape: the player's.
        color: red, green, blue and opacity.
        body: the link's name.
    """

    item: pin.GeometryObject
    shape: shapes.Geometry
    color: tuple[float, ...]
    body: str

    @property
    def corners(self) -> np.ndarray:
        """(8, 3) the corners of the box around it, in the joint's frame [m]."""
        low, high = box_of(self.item)
        return np.array([self.item.placement.act(x) for x in np.where(CORNERS, high, low)])


def body_shapes(robot: Robot) -> tuple[tuple[BodyShape, ...], tuple[str, ...]]:
    """Return the shapes of a robot, and a sentence for each mesh that could not be read.

    A body without any visual, or a link whose mesh is missing, is drawn as a simple body.
    """
    readable, dropped, notes = _without_missing_meshes(robot)
    found = []
    for item in readable.visual_model.geometryObjects:
        shape = drawn_shape(item)
        if shape is None:
            notes.append(f'"{item.name}" is a {type(item.geometry).__name__}, which is not drawn')
            continue
        body = robot.model.frames[item.parentFrame].name
        found.append(BodyShape(item, shape, _color_of(item, shape), body))
    # A link fixed to one that has a picture needs none of its own.
    pictured = {each.item.parentJoint for each in found}
    for i, link in enumerate(robot.links):
        if link.joint_id in pictured and link.name not in dropped:
            continue
        item = simple_body(link)
        if item is not None:
            color = (*PALETTE[i % len(PALETTE)], 1.0)
            found.append(BodyShape(item, drawn_shape(item), color, link.name))
    # Of several robots, each has its own tint, with a part of the links' own colours.
    for prefix, own in robot_colors(robot).items():
        for i, each in enumerate(found):
            if each.body.startswith(prefix):
                mixed = OWN_SHARE * np.array(own) + (1.0 - OWN_SHARE) * np.array(each.color[:3])
                found[i] = replace(each, color=(*mixed.tolist(), each.color[3]))
    return tuple(found), tuple(notes)


def robot_colors(robot: Robot) -> dict[str, tuple[float, float, float]]:
    """Return by prefix, such as "arm/", the colour of each robot of several."""
    parts = robot.parts if len(robot.parts) > 1 else ()
    return {part.prefix: ROBOTS[i % len(ROBOTS)] for i, part in enumerate(parts)}


def _color_of(item: pin.GeometryObject, shape: shapes.Geometry) -> tuple[float, ...]:
    *color, opacity = (float(c) for c in item.meshColor)
    opacity = opacity if opacity > 0.0 else 1.0
    if getattr(shape, "color", None) is not None:
        # Multiplied with the colours of its vertices.
        return (1.0, 1.0, 1.0, opacity)
    if not item.overrideMaterial and np.allclose([*color, opacity], NO_MATERIAL):
        color = list(PALETTE[item.parentJoint % len(PALETTE)])
    return (*color, opacity)


def _without_missing_meshes(robot: Robot) -> tuple[Robot, set[str], list[str]]:
    """Return the robot without visuals whose meshes cannot be read, those links, and why."""
    dropped: set[str] = set()
    notes: list[str] = []
    try:
        _ = robot.visual_model
    except UrdfError:
        parts = [_cleaned(part, dropped, notes) for part in robot.parts]
        robot = Robot(robot.model, parts, robot.name)
    return robot, dropped, notes


def _cleaned(part: RobotPart, dropped: set[str], notes: list[str]) -> RobotPart:
    """Return a part without the visuals of unreadable meshes; adds to ``dropped`` and ``notes``."""
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
            visuals = [
                (link, visual, mesh.get("filename", "").removeprefix("package://"))
                for link in tree.findall("link")
                for visual in link.findall("visual")
                if (mesh := visual.find("geometry/mesh")) is not None
            ]
            # Those with the mesh that the message names; all of them if it names none.
            named = [each for each in visuals if each[2] and each[2] in str(error)] or visuals
            if not named:
                raise
            for link, visual, _ in named:
                link.remove(visual)
            links = [part.prefix + link.get("name", "") for link, _, _ in named]
            dropped.update(links)
            several = f" and {len(links) - 1} more" if len(links) > 1 else ""
            notes.append(f'"{links[0]}"{several} drawn as a simple body: {error}')


@dataclass(frozen=True, eq=False)
class Actors:
    """A robot's shapes and where its joints are in every frame.

    Attributes:
        shown: the motion.
        shapes: those on its joints.
        places: (F, njoints, 7) of every joint in the world, xyz [m] and quaternion xyzw.
        corners: (n, 3) corners of boxes around the shapes over the motion [m].
        subject: (m, 3) those of moving bodies, for the middle of the picture [m].
        reach: between the radius of one pose and that of the motion [m]; arrows go by it.
        notes: a sentence for each shape that could not be drawn as it is.
    """

    shown: Shown
    shapes: tuple[BodyShape, ...]
    places: np.ndarray
    corners: np.ndarray
    subject: np.ndarray
    reach: float
    notes: tuple[str, ...]

    @classmethod
    def of(cls, shown: Shown, times: np.ndarray) -> Actors:
        """Return the actors of a motion at (F,) ``times`` of it [s]."""
        shapes, notes = body_shapes(shown.robot)
        places = joint_places(shown, times)
        looks = np.unique(np.linspace(0, len(times) - 1, min(LOOKS, len(times))).astype(int))
        own = [
            np.array([x for each in shapes if each.item.parentJoint == i for x in each.corners])
            for i in range(places.shape[1])
        ]
        poses = [_corners(own, places[i]) for i in looks]
        corners = np.concatenate(poses)
        moves = np.ptp(places, axis=0).max(axis=1) > 0.0
        moving = [x for x, one in zip(own, moves, strict=True) if one]
        subject = [_corners(moving, places[i, moves]) for i in looks] if moves.any() else poses
        size = max(float(np.linalg.norm(np.ptp(pose, axis=0))) for pose in poses)
        whole = float(np.linalg.norm(np.ptp(corners, axis=0)))
        reach = max(0.5 * float(np.sqrt(size * whole)), LEAST_REACH)
        shapes = tuple(_thick_enough(each, THINNEST_ROD * whole) for each in shapes)
        return cls(shown, shapes, places, corners, np.concatenate(subject), reach, notes)

    @property
    def nodes(self) -> dict[str, str]:
        """By joint name, the path of its node in the player."""
        names = self.shown.robot.joint_names
        return {name: node_path(_node(i, name)) for i, name in enumerate(names, 1)}

    @property
    def labels(self) -> list[tuple[str, str]]:
        """The node of every shape, with its label on the page: its link and its joint."""
        names = self.shown.robot.joint_names
        return [
            (
                node_path(path),
                f"{each.body}, joint {names[joint - 1]}" if joint else f"{each.body}, fixed",
            )
            for path, each in self._drawn()
            for joint in (each.item.parentJoint,)
        ]

    @property
    def followed(self) -> list[tuple[str, float, list[float]]]:
        """The node, mass [kg] and mass centre in the node [m] of every moving joint."""
        inertias = list(self.shown.robot.model.inertias)[1:]
        return [
            (path, float(body.mass), np.asarray(body.lever).tolist())
            for path, body in zip(self.nodes.values(), inertias, strict=True)
            if body.mass > 0.0
        ]

    def draw(self, drawing: Drawing, times: np.ndarray, ghosts: Sequence[float] = ()) -> None:
        """Draw the bodies and let them move at (F,) playback ``times`` [s].

        Faint copies of those that move stay at the ``ghosts``, instants of the motion [s].
        """
        for i, name in enumerate(self.shown.robot.joint_names, 1):
            drawing.move(_node(i, name), times, self.places[:, i])
        poses = joint_places(self.shown, np.array(ghosts)) if len(ghosts) else ()
        for path, each in self._drawn():
            drawing.add(path, each.shape, each.color)
            drawing.place(path, each.item.placement)
            joint = each.item.parentJoint
            if joint and len(poses):
                copies = [pin.XYZQUATToSE3(pose[joint]) * each.item.placement for pose in poses]
                color = (*each.color[:3], GHOST_OPACITY)
                drawing.add(("ghosts", path[-1]), each.shape, color, copies)

    def _drawn(self) -> list[tuple[tuple[str, ...], BodyShape]]:
        """Return the path of every shape, below that of its joint, and the shape."""
        names = ("world", *self.shown.robot.joint_names)
        return [
            ((*_node(joint, names[joint]), node_name(i, each.item.name)), each)
            for i, each in enumerate(self.shapes)
            for joint in (each.item.parentJoint,)
        ]


def _thick_enough(body: BodyShape, radius: float) -> BodyShape:
    """Return a rod with at least a radius [m]: a long chain of thin ones would be invisible."""
    shape = body.item.geometry
    kind = type(shape).__name__
    if kind not in ("Cylinder", "Capsule") or shape.radius >= min(radius, shape.halfLength):
        return body
    own = cylinder if kind == "Cylinder" else capsule
    return replace(body, shape=own(min(radius, shape.halfLength), shape.halfLength))


def joint_places(shown: Shown, times: np.ndarray) -> np.ndarray:
    """Return (F, njoints, 7): where the joints are at (F,) ``times`` of a motion [s]."""
    model = shown.robot.model
    data = model.createData()
    places = np.empty((len(times), model.njoints, 7))
    for row, q in zip(places, shown.at(times), strict=True):
        pin.forwardKinematics(model, data, q)
        for joint_id, placement in enumerate(data.oMi):
            row[joint_id] = pin.SE3ToXYZQUAT(placement)
    return places


def _node(joint_id: int, name: str) -> tuple[str, str]:
    return ("bodies", node_name(joint_id, name))


def _corners(own: Sequence[np.ndarray], pose: np.ndarray) -> np.ndarray:
    """Return (n, 3) corners in one pose, in the world; joints where there is no shape.

    ``own``: (n, 3) corners of the shapes on each joint, in its frame.
    """
    found = [
        corners @ placement.rotation.T + placement.translation
        for corners, place in zip(own, pose, strict=True)
        if len(corners)
        for placement in (pin.XYZQUATToSE3(place),)
    ]
    return np.concatenate(found) if found else pose[:, :3]
