"""Surfaces in the player's own terms: simple bodies, meshes, arrows, tubes and marks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

SEGMENTS = 32
# umsgpack's and the player's codes of typed arrays.
_CODES = {"float32": ("Float32Array", 0x17), "uint32": ("Uint32Array", 0x16)}


@dataclass(frozen=True, eq=False)
class Surface:
    """A geometry as three.js writes one, in a frame of its own.

    Attributes:
        geometry: its JSON, without an identifier.
        corners: (8, 3) the corners of the box around it, along its axes [m].
        turn: (4, 4) where the geometry is in the surface's frame.
        colored: whether its vertices have colours of their own.
    """

    geometry: dict[str, Any]
    corners: np.ndarray
    turn: np.ndarray = field(default_factory=lambda: np.eye(4))
    colored: bool = False

    @property
    def flat(self) -> bool:
        """Whether each triangle is shaded flat, which keeps the edges of CAD parts."""
        return "data" in self.geometry


def corners_between(low: Any, high: Any) -> np.ndarray:
    """(8, 3) the corners of a box along the axes, from its least and its greatest [m]."""
    pick = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)], dtype=bool)
    return np.where(pick, high, low)


def typed(values: np.ndarray) -> Any:
    """Numbers as a typed array of the player, of 4 bytes each."""
    import umsgpack

    return umsgpack.Ext(_CODES[values.dtype.name][1], np.ascontiguousarray(values).tobytes())


def mesh(vertices: np.ndarray, faces: np.ndarray, colors: np.ndarray | None = None) -> Surface:
    """Triangles: (n, 3) vertices [m], (m, 3) faces, counter-clockwise from outside, and colours."""

    def packed(values: np.ndarray, dtype: str, size: int) -> dict[str, Any]:
        array = np.asarray(values, dtype=dtype)
        kind = _CODES[dtype][0]
        return {"itemSize": size, "type": kind, "array": typed(array), "normalized": False}

    attributes = {"position": packed(vertices, "float32", 3)}
    if colors is not None:
        attributes["color"] = packed(colors, "float32", 3)
    data = {"attributes": attributes, "index": packed(faces, "uint32", 1)}
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    corners = corners_between(low, high)
    return Surface({"type": "BufferGeometry", "data": data}, corners, colored=colors is not None)


def box(lengths: np.ndarray) -> Surface:
    """A box about the origin with the (3,) edge ``lengths`` [m]."""
    x, y, z = map(float, lengths)
    half = 0.5 * np.asarray(lengths)
    geometry = {"type": "BoxGeometry", "width": x, "height": y, "depth": z}
    return Surface(geometry, corners_between(-half, half))


def lathe(profile: Any, segments: int = SEGMENTS) -> Surface:
    """The surface that a (p, 2) ``profile`` of radius and height [m] sweeps about the z axis.

    A point that stands twice in a row is an edge, which stays sharp.

    Example:
        >>> lathe([(0.5, 0.0), (0.5, 2.0)]).corners[-1].tolist()
        [0.5, 0.5, 2.0]
    """
    profile = np.asarray(profile, dtype=float).reshape(-1, 2)
    points = [{"x": x, "y": y} for x, y in profile.tolist()]
    radius, (low, high) = profile[:, 0].max(), (profile[:, 1].min(), profile[:, 1].max())
    geometry = {
        "type": "LatheGeometry",
        "points": points,
        "segments": segments,
        "phiStart": 0.0,
        "phiLength": 2.0 * np.pi,
    }
    # The player turns profiles about its y axis.
    turn = np.eye(4)
    turn[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    corners = corners_between([-radius, -radius, low], [radius, radius, high])
    return Surface(geometry, corners, turn)


def ellipsoid(radii: np.ndarray) -> Surface:
    """An ellipsoid about the origin with the (3,) half-axes ``radii`` [m]."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SEGMENTS // 2 + 1)
    ball = lathe(np.column_stack([np.maximum(np.cos(angles), 0.0), np.sin(angles)]))
    scale = np.diag([*map(float, radii), 1.0])
    return replace(ball, corners=ball.corners * radii, turn=scale @ ball.turn)


def rounded(radius: float, half_length: float) -> Surface:
    """A capsule along z: a cylinder of twice the ``half_length`` with round ends [m]."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SEGMENTS // 2 + 2)
    heights = radius * np.sin(angles) + np.where(angles > 0.0, half_length, -half_length)
    return lathe(np.column_stack([radius * np.maximum(np.cos(angles), 0.0), heights]))


def cylinder(radius: float, half_length: float, top_radius: float | None = None) -> Surface:
    """A cylinder along z about the origin; with a ``top_radius`` a cone, whole or cut [m]."""
    top = radius if top_radius is None else top_radius
    low, high = (radius, -half_length), (top, half_length)
    return lathe([(0.0, -half_length), low, low, high, high, (0.0, half_length)])


def arrow(length: float, width: float, heads: int = 1) -> Surface:
    """An arrow along z from the origin to ``length``, its shaft ``width`` thick [m].

    Two ``heads`` stand for a couple. A short arrow gets a smaller head, never a longer body.
    """
    head = min(3.2 * width, 0.8 * length / heads)
    shaft, rim = 0.5 * min(width, 0.5 * head), 0.36 * head
    base = length - heads * head
    profile = [(0.0, 0.0), (shaft, 0.0), (shaft, 0.0), (shaft, base), (shaft, base)]
    for i in range(heads):
        z = base + i * head
        profile += [(rim, z), (rim, z), (0.0, z + head), (0.0, z + head)]
    return lathe(profile, 20)


def tube(points: np.ndarray, radius: float) -> Surface:
    """A tube of ``radius`` along the (n, 3) ``points`` [m], n of 2 or more."""
    points = np.asarray(points, dtype=float)
    line: Sequence[Any] = [point.tolist() for point in points]
    geometry = {
        "type": "TubeGeometry",
        "path": {
            "type": "CatmullRomCurve3",
            "points": line,
            "closed": False,
            "curveType": "centripetal",
            "arcLengthDivisions": 2 * len(points),
        },
        "tubularSegments": len(points) - 1,
        "radius": radius,
        "radialSegments": 6,
        "closed": False,
    }
    return Surface(geometry, corners_between(points.min(axis=0), points.max(axis=0)))
