"""Collision and visual geometry, built on first access; each mesh is read once."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

import numpy as np
import pinocchio as pin

from ..errors import InputError, UnknownNameError, UrdfError, shown
from .mjcf_shapes import coal_shape
from .shapes import checked_shapes
from .urdf import plain_urdf, read_urdf

if TYPE_CHECKING:
    from .base import RobotBase
    from .source import RobotPart

Stamp = tuple[str, int, int]
"""A file, when it was written [ns], and its size."""

_FILENAME = re.compile(r"""filename=(["'])(.*?)\1""")
_loaders: WeakValueDictionary[frozenset[Stamp], Any] = WeakValueDictionary()


def mesh_paths(shapes: Mapping[str, Sequence[str]]) -> set[str]:
    """The meshes that elements written by ``checked_shapes`` name."""
    written = (shape for of_link in shapes.values() for shape in of_link)
    return {html.unescape(path) for shape in written for _, path in _FILENAME.findall(shape)}


def loader_of(paths: Iterable[str]) -> Any:
    """coal's reader of these meshes, which keeps what it has read as long as somebody keeps it.

    Files that were written anew are read anew.
    """
    import coal

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


# The attributes of coal's shapes that make them what they are.
_NUMBERS_OF_SHAPES = {"d", "halfLength", "halfSide", "n", "radii", "radius"}
# How lines of coal's reader begin that give no reason.
_NO_REASON = ("Could not load resource", "Hint:")
# What marks the folder of a package, and how far above a robot file it may be.
_OF_PACKAGES = ("package.xml", "model.config")
PACKAGE_DEPTH = 5
# A mesh thinner than this times its length is flat. Meshes are read in single precision, whose
# rounding is 6e-8 of the length.
FLAT = 1e-6


def geometry_of(robot: RobotBase, kind: pin.GeometryType) -> pin.GeometryModel:
    """The geometry of every part of a robot, named and attached as in its model.

    Raises:
        UrdfError: a mesh that cannot be read; it names the folders that were tried.
    """
    whole = pin.GeometryModel()
    tag = "collision" if kind == pin.GeometryType.COLLISION else "visual"
    for part in robot.parts:
        _add_plain(robot, part, kind, whole)
        if kind == pin.GeometryType.COLLISION:
            _add_grounds(part, whole)
        written = part.geometry if part.urdf is None else part.urdf
        if written is None:
            continue
        urdf = replace(read_urdf(written), path=part.label)
        folders = mesh_folders(part)
        shapes = checked_shapes(urdf, tag, folders)
        text = plain_urdf(urdf.name, urdf.inertials, urdf.joints, shapes)
        alone = pin.buildModelFromXML(text)
        try:
            geometry = pin.buildGeomFromUrdfString(
                alone, text, kind, package_dirs=folders, **_kept_loader(robot, kind, shapes)
            )
        except (RuntimeError, ValueError) as error:
            raise _unreadable(str(error), shapes, part.label) from None
        for item in geometry.geometryObjects:
            _check_finite(item, part.label)
            _attach(robot, part.prefix, alone, item)
            whole.addGeometryObject(item)
    return whole


def _kept_loader(
    robot: RobotBase, kind: pin.GeometryType, shapes: Mapping[str, Sequence[str]]
) -> dict[str, Any]:
    """The reader of a part's meshes: those that are drawn are read once for all robots.

    Of collisions each robot has its own, to which hulls are added.
    """
    if kind == pin.GeometryType.COLLISION:
        return {}
    loader = loader_of(mesh_paths(shapes))
    robot.kept_loaders.append(loader)
    return {"mesh_loader": loader}


def _add_plain(
    robot: RobotBase, part: RobotPart, kind: pin.GeometryType, whole: pin.GeometryModel
) -> None:
    """The shapes of a part that is no URDF."""
    drawn = kind != pin.GeometryType.COLLISION
    for shape in part.shapes:
        if not (shape.drawn if drawn else shape.collides):
            continue
        own = coal_shape(shape, drawn=drawn)
        if own is None:
            continue
        frame_id = robot.frame_id(
            shape.frame if shape.frame == "world" else part.prefix + shape.frame
        )
        frame = robot.model.frames[frame_id]
        placement = frame.placement * pin.SE3(shape.rotation, shape.translation)
        item = pin.GeometryObject(
            part.prefix + shape.name, frame.parentJoint, frame_id, placement, own
        )
        item.meshColor = np.array(shape.rgba)
        item.overrideMaterial = True
        whole.addGeometryObject(item)


def _add_grounds(part: RobotPart, whole: pin.GeometryModel) -> None:
    import coal

    for ground in part.changes.grounds:
        shape = coal.Halfspace(np.array(ground.normal), ground.height)
        placed = np.eye(4) if part.placement is None else np.array(part.placement)
        name = part.prefix + ground.name
        whole.addGeometryObject(pin.GeometryObject(name, 0, 0, pin.SE3(placed), shape))


def _unreadable(told: str, shapes: Mapping[str, Sequence[str]], source: str) -> UrdfError:
    """The error for a mesh that coal's reader refused; of its words only the reason is kept."""
    for link, written in shapes.items():
        for shape in written:
            path = html.unescape(shape.partition('filename="')[2].partition('"')[0])
            if path and path in told:
                lines = told.partition("message: ")[2].splitlines()
                reasons = [line for line in lines if line and not line.startswith(_NO_REASON)]
                reason = f": {shown(reasons[0], 200)}" if reasons else ""
                return UrdfError(
                    f'{source}: link "{link}": "{path}" cannot be read as a mesh{reason}',
                    source=source,
                    element="mesh",
                )
    return UrdfError(f"{source}: its geometry cannot be built", source=source, element="mesh")


def _check_finite(item: pin.GeometryObject, source: str) -> None:
    """Prove that a mesh has no NaN and no infinity in its corners.

    Raises:
        UrdfError: it has.
    """
    corners = _corners(item)
    if corners is None or np.isfinite(corners).all():
        return
    raise UrdfError(
        f'{source}: "{item.meshPath}" cannot be read as a mesh: a corner is NaN or infinite',
        source=source,
        element="mesh",
    )


def _corners(item: pin.GeometryObject) -> np.ndarray | None:
    """(k, 3) the corners of a mesh; None of any other shape."""
    vertices = getattr(item.geometry, "vertices", None)
    if vertices is None or not item.meshPath:
        return None
    return np.asarray(vertices() if callable(vertices) else vertices)


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
    """Prove that a mesh encloses a volume: coal's convex hull of a flat one ends the process.

    Raises:
        InputError: it does not.
    """
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
    """Folders of the meshes of a robot file: its own, and that of its package.

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
    """Folders of the meshes of a part: its file's, ``package_dirs``, ROS packages."""
    folders = folders_of_file(part.path)
    ros = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    return list(dict.fromkeys([*folders, *part.package_dirs, *filter(os.path.isabs, ros)]))


def _attach(robot: RobotBase, prefix: str, alone: pin.Model, item: pin.GeometryObject) -> None:
    """Move a geometry object from the model of its URDF alone to the robot's model."""
    frame_alone = alone.frames[item.parentFrame]
    in_frame = frame_alone.placement.inverse() * item.placement
    name = prefix + frame_alone.name
    frame_id = 0 if frame_alone.name == "universe" else robot.frame_id(name)
    frame = robot.model.frames[frame_id]
    item.parentFrame = frame_id
    item.parentJoint = frame.parentJoint
    item.placement = frame.placement * in_frame
    item.name = prefix + item.name


def geometry_ids(robot: RobotBase, name: str, where: str = "") -> tuple[tuple[int, ...], int]:
    """The collision objects that a name stands for, and the joint that carries them.

    Args:
        robot: the robot.
        name: a link, for all its geometry, or one geometry object.
        where: begins the sentence of an error.

    Raises:
        UnknownNameError: neither a link nor a geometry object.
        InputError: a link without collision geometry, or a mesh without a volume.
    """
    found = robot.kept_ids.get(name) if isinstance(name, str) else None
    if found is None:
        found = robot.kept_ids[name] = _find_ids(robot, name, where)
    return found


def _find_ids(robot: RobotBase, name: str, where: str) -> tuple[tuple[int, ...], int]:
    objects = robot.collision_model.geometryObjects
    for index, item in enumerate(objects):
        if item.name == name:
            _check_solid(item, where)
            return (index,), item.parentJoint
    if name not in robot.frame_names:
        known = (*(link.name for link in robot.links), *(item.name for item in objects))
        raise UnknownNameError.among("link or geometry", name, known, where)
    frame_id = robot.frame_id(name)
    ids = tuple(i for i, item in enumerate(objects) if item.parentFrame == frame_id)
    if not ids:
        raise InputError(f'{where}: link "{name}" has no collision geometry')
    for i in ids:
        _check_solid(objects[i], where)
    return ids, robot.model.frames[frame_id].parentJoint
