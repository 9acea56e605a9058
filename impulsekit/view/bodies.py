"""The shapes of a robot on each joint, with simple bodies where pictures are missing."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from ..errors import UrdfError
from ..robot import Robot
from .surfaces import Surface, box, cylinder, ellipsoid, mesh, rounded

if TYPE_CHECKING:
    from ..robot import RobotPart
    from ..robot.masses import Link

# A box is drawn no thinner than this share of its longest edge.
THINNEST = 0.04
# A mass without inertia is drawn as a ball of this density [kg/m³].
DENSITY = 2000.0


def simple_body(link: Link) -> tuple[Surface, pin.SE3] | None:
    """A surface for a link and its placement in the link's joint; None for a massless link.

    The box is uniform, and has the link's mass, mass centre and inertia.
    """
    if link.mass <= 0.0:
        return None
    if not link.inertia_in_joint_axes.any():
        radius = (3.0 * link.mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0)
        return ellipsoid(np.full(3, radius)), pin.SE3(np.eye(3), link.com_in_joint)
    lengths, rotation = equivalent_box(link.mass, link.inertia_in_joint_axes)
    return box(lengths), pin.SE3(rotation, link.com_in_joint)


def equivalent_box(mass: float, inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The uniform box with a ``mass`` [kg] and a (3, 3) ``inertia`` about its centre [kg m²].

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


# Collada is read twice, by Pinocchio and for its colours; both must agree this well.
SAME_SIZE = 1e-3


def surface_of(item: pin.GeometryObject) -> Surface | None:
    """The surface of a geometry object in its own frame; None where there is none to draw."""
    shape = item.geometry
    kind = type(shape).__name__
    if kind == "Box":
        return box(2.0 * np.array(shape.halfSide))
    if kind == "Sphere":
        return ellipsoid(np.full(3, shape.radius))
    if kind == "Ellipsoid":
        return ellipsoid(np.array(shape.radii))
    if kind == "Cylinder":
        return cylinder(shape.radius, shape.halfLength)
    if kind == "Cone":
        return cylinder(shape.radius, shape.halfLength, top_radius=0.0)
    if kind == "Capsule":
        return rounded(shape.radius, shape.halfLength)
    if hasattr(shape, "vertices") and hasattr(shape, "tri_indices"):
        return _triangles(item)
    if kind.startswith("Convex"):
        return _convex(shape)
    return None


def _triangles(item: pin.GeometryObject) -> Surface | None:
    shape = item.geometry
    vertices = np.array(shape.vertices(), dtype=np.float32).reshape(-1, 3)
    triangles = (shape.tri_indices(i) for i in range(shape.num_tris))
    faces = np.array([(t[0], t[1], t[2]) for t in triangles], dtype=np.uint32)
    if not len(faces):
        return None
    plain = mesh(vertices, faces)
    if not item.overrideMaterial and item.meshPath.lower().endswith(".dae"):
        return _colored(item.meshPath, np.array(item.meshScale).ravel(), plain) or plain
    return plain


def _convex(shape: Any) -> Surface:
    import coal

    points = np.array([shape.point(i) for i in range(shape.num_points)])
    hull = coal.Convex.convexHull(points, True, "")
    return mesh(points, np.array([list(hull.polygons(i)) for i in range(hull.num_polygons)]))


def _colored(path: str, scale: np.ndarray, plain: Surface) -> Surface | None:
    """A Collada file with a colour for each part; None if it has none or reads otherwise."""
    if not os.path.isfile(path):
        return None
    try:
        import trimesh

        scene: Any = trimesh.load(path, force="scene", process=False)
        parts = [_part(part) for part in scene.dump() if len(part.faces)]
    except Exception:
        # Colours are a courtesy: whatever a reader stumbles over, the plain mesh is there.
        return None
    if not parts:
        return None
    starts = np.cumsum([0, *(len(vertices) for vertices, _, _ in parts[:-1])])
    faces = np.concatenate([faces + k for (_, faces, _), k in zip(parts, starts, strict=True)])
    vertices, colors = (np.concatenate([part[i] for part in parts]) for i in (0, 2))
    whole = mesh(vertices * scale, faces, colors)
    size = float(np.ptp(plain.corners, axis=0).max())
    same = np.abs(whole.corners - plain.corners).max() <= SAME_SIZE * size
    return whole if same else None


def _part(part: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The vertices, faces and colours of a part."""
    material = getattr(part.visual, "material", None)
    color = getattr(material, "main_color", None)
    rgb = np.array([230, 230, 230] if color is None else color[:3], dtype=float) / 255.0
    # A corner is stored once for every normal it has; drawn flat, one of them will do.
    corners = np.asarray(part.vertices, dtype=np.float32)
    corners, place = np.unique(corners, axis=0, return_inverse=True)
    faces = place.reshape(-1)[np.asarray(part.faces)]
    return corners, faces, np.tile(rgb, (len(corners), 1))


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
    return replace(shape, color=(*mixed, shape.color[3]))


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
        if surface.colored:
            # Multiplied with the colours of its vertices.
            color = (1.0, 1.0, 1.0, color[3])
        elif not item.overrideMaterial and np.allclose(color, _NO_MATERIAL):
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
