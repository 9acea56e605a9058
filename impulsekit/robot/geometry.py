"""Collision and visual geometry, built on first access; each mesh is read once."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

import coal
import numpy as np
import pinocchio as pin

from ..errors import InputError, UnknownNameError, shown
from .mjcf_shapes import coal_shape
from .robot_xml import Place
from .urdf import read_urdf
from .urdf_elements import depth_first
from .urdf_shapes import UrdfShape, urdf_shapes

if TYPE_CHECKING:
    from .base import RobotBase
    from .source import RobotPart

Stamp = tuple[str, int, int]
"""A file, when it was written [ns], and its size."""

_loaders: WeakValueDictionary[frozenset[Stamp], Any] = WeakValueDictionary()

# The attributes of coal's shapes that make them what they are.
_NUMBERS_OF_SHAPES = {"d", "halfLength", "halfSide", "n", "radii", "radius"}
# How lines of coal's reader begin that give no reason.
_NO_REASON = ("Could not load resource", "Hint:")
# The shapes of a URDF; the length of a capsule is without its caps, in coal as well.
_KINDS = {
    "box": coal.Box,
    "cylinder": coal.Cylinder,
    "sphere": coal.Sphere,
    "capsule": coal.Capsule,
}
# What marks the folder of a package, and how far above a robot file it may be.
_OF_PACKAGES = ("package.xml", "model.config")
PACKAGE_DEPTH = 5
# A mesh thinner than this times its length is flat. Meshes are read in single precision, whose
# rounding is 6e-8 of the length.
FLAT = 1e-6
# Pinocchio's, where a file gives none.
_GREY = (0.9, 0.9, 0.9, 1.0)


def geometry_of(robot: RobotBase, kind: pin.GeometryType) -> pin.GeometryModel:
    """Return the geometry of every part of a robot, named and attached as in its model.

    Raises:
        UrdfError: a mesh that cannot be read; it names the folders that were tried.
    """
    whole = pin.GeometryModel()
    drawn = kind != pin.GeometryType.COLLISION
    for part in robot.parts:
        items = [*_plain_objects(robot, part, drawn=drawn)]
        if not drawn:
            items += _grounds(part)
        written = part.geometry if part.urdf is None else part.urdf
        if written is not None:
            urdf = replace(read_urdf(written), path=part.label)
            found = urdf_shapes(urdf, "visual" if drawn else "collision", mesh_folders(part))
            # As Pinocchio goes.
            order = {joint.child: i for i, joint in enumerate(depth_first(urdf.joints), 1)}
            shapes = sorted(found, key=lambda shape: order.get(shape.link, 0))
            items += _urdf_objects(robot, part, shapes, drawn=drawn)
        for item in items:
            whole.addGeometryObject(item)
    return whole


def _object(
    robot: RobotBase, name: str, frame: str, placement: pin.SE3, shape: Any
) -> pin.GeometryObject:
    """A piece of geometry at a placement in a frame."""
    frame_id = robot.frame_id(frame)
    carrier = robot.model.frames[frame_id]
    at = carrier.placement * placement
    return pin.GeometryObject(name, carrier.parentJoint, frame_id, at, shape)


def _plain_objects(
    robot: RobotBase, part: RobotPart, *, drawn: bool
) -> Iterator[pin.GeometryObject]:
    """The shapes of a part that is no URDF."""
    for shape in part.shapes:
        own = coal_shape(shape, drawn=drawn) if (shape.drawn if drawn else shape.collides) else None
        if own is not None:
            frame = shape.frame if shape.frame == "world" else part.prefix + shape.frame
            at = pin.SE3(shape.rotation, shape.translation)
            item = _object(robot, part.prefix + shape.name, frame, at, own)
            item.meshColor, item.overrideMaterial = np.array(shape.rgba), True
            yield item


def _grounds(part: RobotPart) -> Iterator[pin.GeometryObject]:
    for ground in part.changes.grounds:
        shape = coal.Halfspace(np.array(ground.normal), ground.height)
        placed = np.eye(4) if part.placement is None else np.array(part.placement)
        yield pin.GeometryObject(part.name_of(ground), 0, 0, pin.SE3(placed), shape)


def _urdf_objects(
    robot: RobotBase, part: RobotPart, shapes: Sequence[UrdfShape], *, drawn: bool
) -> Iterator[pin.GeometryObject]:
    """The shapes of a URDF; meshes that are drawn are read once for all robots.

    Of collisions each robot has its own, to which hulls are added.
    """
    loader = coal.CachedMeshLoader()
    if drawn:
        loader = loader_of({shape.path for shape in shapes if shape.path})
        robot._mesh_loaders.append(loader)
    counts: dict[str, int] = {}
    for shape in shapes:
        number = counts[shape.link] = counts.get(shape.link, -1) + 1
        name, link = f"{part.prefix}{shape.link}_{number}", part.prefix + shape.link
        own = _solid(shape, loader, part.label)
        item = _object(robot, name, link, shape.placement, own)
        item.meshPath = shape.path or shape.kind.upper()
        if shape.kind == "mesh":
            item.meshScale = np.array(shape.sizes)
            _check_finite(item, part.label)
        item.overrideMaterial = drawn and shape.rgba is not None
        item.meshColor = np.array((shape.rgba if drawn else None) or _GREY)
        yield item


def _solid(shape: UrdfShape, loader: Any, source: str) -> Any:
    """A shape as coal has it."""
    if shape.kind != "mesh":
        return _KINDS[shape.kind](*shape.sizes)
    try:
        return loader.load(shape.path, np.array(shape.sizes))
    except (RuntimeError, ValueError) as error:
        lines = str(error).partition("message: ")[2].splitlines()
        reasons = [line for line in lines if line and not line.startswith(_NO_REASON)]
        reason = f": {shown(reasons[0], 200)}" if reasons else ""
        place = Place(source, f'link "{shape.link}"')
        raise place.fault(f'"{shape.path}" cannot be read as a mesh{reason}', "mesh") from None


def _check_finite(item: pin.GeometryObject, source: str) -> None:
    """Check that a mesh has no NaN and no infinity in its corners."""
    corners = _corners(item)
    if corners is not None and not np.isfinite(corners).all():
        raise Place(source).fault(
            f'"{item.meshPath}" cannot be read as a mesh: a corner is NaN or infinite', "mesh"
        )


def _corners(item: pin.GeometryObject) -> np.ndarray | None:
    """(k, 3) the corners of a mesh; None of any other shape."""
    vertices = getattr(item.geometry, "vertices", None)
    if vertices is None or not item.meshPath:
        return None
    return np.asarray(vertices() if callable(vertices) else vertices)


def loader_of(paths: Iterable[str]) -> Any:
    """Return coal's reader of these meshes, which keeps what it has read while it is in use.

    Files that were written anew are read anew.
    """
    stamps = frozenset(stamp for path in paths if (stamp := _stamp(path)) is not None)
    loader = _loaders.get(stamps)
    if loader is None:
        loader = _loaders[stamps] = coal.CachedMeshLoader()
    return loader


def _stamp(path: str) -> Stamp | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return path, found.st_mtime_ns, found.st_size


def shape_content(item: pin.GeometryObject) -> Iterator[bytes]:
    """Yield a shape as bytes: its kind, its numbers, and of a mesh all corners and faces.

    What coal works out on the way, such as bounding boxes and hulls, is left out: two objects of
    one shape have one content whatever was asked of them before.
    """
    shape = item.geometry
    yield type(shape).__name__.encode()
    yield np.ascontiguousarray(item.meshScale, dtype=float).tobytes()
    for name in sorted(set(dir(shape)) & _NUMBERS_OF_SHAPES):
        yield name.encode()
        yield np.ascontiguousarray(getattr(shape, name), dtype=float).tobytes()
    for name in ("getSweptSphereRadius", "points", "vertices"):
        if hasattr(shape, name):
            value = getattr(shape, name)
            value = value() if callable(value) else value
            yield name.encode()
            yield np.ascontiguousarray(value, dtype=float).tobytes()
    if hasattr(shape, "tri_indices"):
        faces = [shape.tri_indices(i) for i in range(shape.num_tris)]
        yield np.array([[face[k] for k in range(3)] for face in faces], dtype=np.int64).tobytes()


def _check_solid(item: pin.GeometryObject, where: str) -> None:
    """Check that a mesh encloses a volume: coal's convex hull of a flat one ends the process."""
    corners = _corners(item)
    if corners is None:
        return
    centred = corners - corners.mean(axis=0)
    _, _, axes = np.linalg.svd(centred.T @ centred)
    extents = np.ptp(centred @ axes.T, axis=0)
    if extents[2] <= FLAT * extents[0]:
        begin = f"{where}: " if where else ""
        raise InputError(
            f'{begin}the mesh "{item.meshPath}" is flat, {extents[0]:.3g} m long and '
            f"{extents[2]:.3g} m thick; a body that collides needs a volume"
        )


def folders_of_file(path: str | None) -> list[str]:
    """Return the folders of the meshes of a robot file: its own, and that of its package.

    A ROS package holds package.xml, a model of Gazebo model.config; "package://NAME/..." is
    looked up beside the package that the file is in.
    """
    if path is None:
        return []
    own = folder = os.path.dirname(os.path.abspath(path))
    for _ in range(PACKAGE_DEPTH):
        above = os.path.dirname(folder)
        if any(os.path.isfile(os.path.join(folder, name)) for name in _OF_PACKAGES):
            return [own, above] if above != folder else [own]
        folder = above
    return [own]


def mesh_folders(part: RobotPart) -> list[str]:
    """Return the folders of the meshes of a part: its file's, ``package_dirs``, ROS packages."""
    folders = folders_of_file(part.path)
    ros = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    return list(dict.fromkeys([*folders, *part.package_dirs, *filter(os.path.isabs, ros)]))


def geometry_ids(robot: RobotBase, name: str, where: str = "") -> tuple[tuple[int, ...], int]:
    """Return the collision objects that a name stands for, and the joint that carries them.

    Args:
        robot: the robot.
        name: a link, for all its geometry, or one geometry object.
        where: begins the sentence of an error.

    Raises:
        UnknownNameError: neither a link nor a geometry object.
        InputError: a link without collision geometry, or a mesh without a volume.
    """
    found = robot._geometry_ids.get(name) if isinstance(name, str) else None
    if found is None:
        found = robot._geometry_ids[name] = _find_ids(robot, name, where)
    return found


def _find_ids(robot: RobotBase, name: str, where: str) -> tuple[tuple[int, ...], int]:
    objects = robot.collision_model.geometryObjects
    for index, item in enumerate(objects):
        if item.name == name:
            _check_solid(item, where)
            return (index,), item.parentJoint
    if name not in robot.frame_names:
        known = (*robot.link_names, *(item.name for item in objects))
        raise UnknownNameError.among("link or geometry", name, known, where)
    frame_id = robot.frame_id(name)
    ids = tuple(i for i, item in enumerate(objects) if item.parentFrame == frame_id)
    if not ids:
        raise InputError(f'{where}: link "{name}" has no collision geometry')
    for i in ids:
        _check_solid(objects[i], where)
    return ids, robot.model.frames[frame_id].parentJoint
