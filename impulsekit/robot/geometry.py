"""Collision and visual geometry, built only when somebody looks."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING

import pinocchio as pin

from ..errors import InputError, UnknownNameError, UrdfError

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["geometry_ids", "geometry_of"]


def geometry_of(robot: Robot, kind: pin.GeometryType) -> pin.GeometryModel:
    """The geometry of every part of a robot, named and attached as in its model.

    Raises:
        UrdfError: a mesh that cannot be read; it names the folders that were tried.
    """
    whole = pin.GeometryModel()
    for part in robot.parts:
        if part.urdf is None:
            continue
        folders = list(part.package_dirs)
        if part.path is not None:
            folders.append(str(pathlib.Path(part.path).parent))
        alone = pin.buildModelFromXML(part.urdf)
        try:
            geometry = pin.buildGeomFromUrdfString(alone, part.urdf, kind, package_dirs=folders)
        except (RuntimeError, ValueError) as error:
            tried = ", ".join(folders) or "none"
            raise UrdfError(
                f"{part.label}: {error} (folders tried: {tried})", source=part.label, element="mesh"
            ) from None
        for item in geometry.geometryObjects:
            _attach(robot, part.prefix, alone, item)
            whole.addGeometryObject(item)
    return whole


def _attach(robot: Robot, prefix: str, alone: pin.Model, item: pin.GeometryObject) -> None:
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


def geometry_ids(robot: Robot, name: str, where: str = "") -> tuple[tuple[int, ...], int]:
    """The collision objects that a name stands for, and the joint that carries them.

    Args:
        robot: the robot.
        name: a link, for all its geometry, or one geometry object.
        where: begins the sentence of an error.

    Raises:
        UnknownNameError: neither a link nor a geometry object.
        InputError: a link without collision geometry.
    """
    objects = robot.collision_model.geometryObjects
    for index, item in enumerate(objects):
        if item.name == name:
            return (index,), item.parentJoint
    if name not in robot.frame_names:
        known = (*(link.name for link in robot.links), *(item.name for item in objects))
        raise UnknownNameError.among("link or geometry", name, known, where)
    frame_id = robot.frame_id(name)
    ids = tuple(i for i, item in enumerate(objects) if item.parentFrame == frame_id)
    if not ids:
        raise InputError(f'{where}: link "{name}" has no collision geometry')
    return ids, robot.model.frames[frame_id].parentJoint
