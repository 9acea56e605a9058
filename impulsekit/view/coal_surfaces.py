"""Pinocchio's geometry as surfaces to draw; Collada files keep the colours of their parts."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pinocchio as pin

from .surfaces import Surface, box, cylinder, ellipsoid, merged, rounded

__all__ = ["surface_of"]

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
    mesh = item.geometry
    vertices = np.array(mesh.vertices(), dtype=np.float32).reshape(-1, 3)
    triangles = (mesh.tri_indices(i) for i in range(mesh.num_tris))
    faces = np.array([(t[0], t[1], t[2]) for t in triangles], dtype=np.uint32)
    if not len(faces):
        return None
    if not item.overrideMaterial and item.meshPath.lower().endswith(".dae"):
        colored = _colored(item.meshPath, np.array(item.meshScale).ravel(), vertices)
        if colored is not None:
            return colored
    return Surface(vertices, faces, smooth=False)


def _convex(shape: Any) -> Surface:
    import coal

    points = np.array([shape.point(i) for i in range(shape.num_points)])
    mesh = coal.Convex.convexHull(points, True, "")
    faces = np.array([list(mesh.polygons(i)) for i in range(mesh.num_polygons)])
    return Surface(points, faces, smooth=False)


def _colored(path: str, scale: np.ndarray, vertices: np.ndarray) -> Surface | None:
    """A Collada file with a colour for each part; None if it has none or reads otherwise."""
    if not os.path.isfile(path):
        return None
    try:
        import trimesh

        scene: Any = trimesh.load(path, force="scene")
        surfaces = [_part(mesh) for mesh in scene.dump()]
    except Exception:
        # Colours are a courtesy: whatever a reader stumbles over, the plain mesh is there.
        return None
    surfaces = [surface for surface in surfaces if len(surface.faces)]
    if not surfaces:
        return None
    whole = merged(surfaces)
    scaled = Surface(whole.vertices * scale, whole.faces, whole.colors, smooth=False)
    size = float(np.ptp(vertices, axis=0).max())
    if np.abs(scaled.corners - Surface(vertices, whole.faces).corners).max() > SAME_SIZE * size:
        return None
    return scaled


def _part(mesh: Any) -> Surface:
    material = getattr(mesh.visual, "material", None)
    color = getattr(material, "main_color", None)
    rgb = np.array([230, 230, 230] if color is None else color[:3], dtype=float) / 255.0
    # A corner is stored once for every normal it has; drawn flat, one of them will do.
    corners = np.ascontiguousarray(mesh.vertices, dtype=np.float32)
    _, first, place = np.unique(
        corners.view(np.dtype((np.void, 12))).ravel(), return_index=True, return_inverse=True
    )
    faces = place.reshape(-1)[np.asarray(mesh.faces)]
    return Surface(corners[first], faces, np.tile(rgb, (len(first), 1)), smooth=False)
