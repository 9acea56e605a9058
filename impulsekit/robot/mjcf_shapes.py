"""The geoms of a MuJoCo model as plain data, and coal's shapes made from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

__all__ = ["PlainShape", "coal_shape", "rotation_of", "shapes_of"]

_KINDS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
# MuJoCo draws the groups below this one unless it is told otherwise.
_FIRST_HIDDEN_GROUP = 3
# Half the thickness of the plate that a finite plane is drawn as [m].
_PLATE = 1e-3


@dataclass(frozen=True, eq=False)
class PlainShape:
    """A geom.

    Attributes:
        name: as in the file, or "geom_" and its number.
        frame: the body's frame.
        kind: "plane", "sphere", "capsule", "ellipsoid", "cylinder", "box" or "mesh".
        size: MuJoCo's sizes (half lengths) [m].
        rotation, translation: in the body's frame; (3, 3) and (3,).
        vertices, faces: of a mesh, (n, 3) [m] and (m, 3); None for other kinds.
        rgba: its colour.
        collides, drawn: whether it is collision geometry, whether it is drawn.
        friction: the sliding friction of MuJoCo's contacts.
    """

    name: str
    frame: str
    kind: str
    size: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    vertices: np.ndarray | None
    faces: np.ndarray | None
    rgba: tuple[float, ...]
    collides: bool
    drawn: bool
    friction: float


def shapes_of(mj: Any, frames: Sequence[str]) -> tuple[PlainShape, ...]:
    """The geoms of a ``mujoco.MjModel``; height fields and signed distance fields left out.

    Args:
        mj: the model.
        frames: by body, the name of its frame.
    """
    shapes = []
    for i in range(mj.ngeom):
        number = int(mj.geom_type[i])
        if number >= len(_KINDS) or _KINDS[number] == "hfield":
            continue
        vertices = faces = None
        if _KINDS[number] == "mesh":
            mesh = int(mj.geom_dataid[i])
            first, count = int(mj.mesh_vertadr[mesh]), int(mj.mesh_vertnum[mesh])
            vertices = np.array(mj.mesh_vert[first : first + count], dtype=float)
            first, count = int(mj.mesh_faceadr[mesh]), int(mj.mesh_facenum[mesh])
            faces = np.array(mj.mesh_face[first : first + count], dtype=int)
        material = int(mj.geom_matid[i])
        rgba = mj.mat_rgba[material] if material >= 0 else mj.geom_rgba[i]
        shapes.append(
            PlainShape(
                mj.geom(i).name or f"geom_{i}",
                frames[int(mj.geom_bodyid[i])],
                _KINDS[number],
                np.array(mj.geom_size[i], dtype=float),
                rotation_of(mj.geom_quat[i]),
                np.array(mj.geom_pos[i], dtype=float),
                vertices,
                faces,
                tuple(float(value) for value in rgba),
                bool(mj.geom_contype[i] or mj.geom_conaffinity[i]),
                int(mj.geom_group[i]) < _FIRST_HIDDEN_GROUP,
                float(mj.geom_friction[i][0]),
            )
        )
    return tuple(shapes)


def rotation_of(wxyz: np.ndarray) -> np.ndarray:
    """(3, 3) of a quaternion w, x, y, z."""
    w, x, y, z = (float(value) for value in wxyz)
    return pin.Quaternion(w, x, y, z).normalized().toRotationMatrix()


def coal_shape(shape: PlainShape, *, drawn: bool) -> Any:
    """The shape as coal has it; None for a plane without end that is to be drawn."""
    import coal

    size = shape.size
    if shape.kind == "plane":
        if not drawn:
            return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
        if not size[:2].all():
            return None
        return coal.Box(2.0 * size[0], 2.0 * size[1], 2.0 * _PLATE)
    if shape.kind == "sphere":
        return coal.Sphere(size[0])
    if shape.kind == "capsule":
        return coal.Capsule(size[0], 2.0 * size[1])
    if shape.kind == "cylinder":
        return coal.Cylinder(size[0], 2.0 * size[1])
    if shape.kind == "ellipsoid":
        return coal.Ellipsoid(*size)
    if shape.vertices is None or shape.faces is None:
        return coal.Box(*(2.0 * size))
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(shape.faces), len(shape.vertices))
    mesh.addVertices(shape.vertices)
    mesh.addTriangles(shape.faces)
    mesh.endModel()
    if not drawn:
        mesh.buildConvexRepresentation(False)
        return mesh.convex
    return mesh
