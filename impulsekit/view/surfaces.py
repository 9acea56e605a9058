"""Surfaces of triangles: the simple bodies, arrows, tubes and marks that a replay draws."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

# A vector shorter than this has no direction.
NO_DIRECTION = 1e-9

SEGMENTS = 32


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles in a frame of their own.

    Attributes:
        vertices: (n, 3) [m].
        faces: (m, 3) indices of vertices, counter-clockwise seen from outside.
        colors: (n, 3) red, green, blue in [0, 1]; None for one colour throughout.
        smooth: False shades each triangle flat, which keeps the edges of CAD parts.
    """

    vertices: np.ndarray
    faces: np.ndarray
    colors: np.ndarray | None = None
    smooth: bool = True

    @cached_property
    def corners(self) -> np.ndarray:
        """(8, 3) the corners of the box around it, along its axes [m]."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        pick = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)], dtype=bool)
        return np.where(pick, high, low)


def box(lengths: np.ndarray) -> Surface:
    """A box about the origin with the (3,) edge ``lengths`` [m].

    Example:
        >>> box(np.array([1.0, 2.0, 3.0])).faces.shape
        (12, 3)
    """
    vertices: list[np.ndarray] = []
    faces: list[list[int]] = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            start = len(vertices)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                corner = np.zeros(3)
                corner[[axis, u, v]] = side, a * side, b
                vertices.append(0.5 * corner * lengths)
            faces += [[start, start + 1, start + 2], [start, start + 2, start + 3]]
    return Surface(np.array(vertices), np.array(faces))


def lathe(profile: Any, segments: int = SEGMENTS) -> Surface:
    """The surface that a (p, 2) ``profile`` of radius and height [m] sweeps about the z axis.

    A point that stands twice in a row is an edge, which stays sharp.
    """
    profile = np.asarray(profile, dtype=float).reshape(-1, 2)
    angles = np.linspace(0.0, 2.0 * np.pi, segments, endpoint=False)
    ring = np.array([np.cos(angles), np.sin(angles)]).T
    vertices = np.concatenate(
        [np.column_stack([radius * ring, np.full(segments, z)]) for radius, z in profile]
    )
    here = np.arange(segments)
    there = np.roll(here, -1)
    faces = []
    for i in range(len(profile) - 1):
        if np.array_equal(profile[i], profile[i + 1]):
            continue
        low, high = i * segments, (i + 1) * segments
        if profile[i, 0] > 0.0:
            faces.append(np.column_stack([low + here, low + there, high + there]))
        if profile[i + 1, 0] > 0.0:
            faces.append(np.column_stack([low + here, high + there, high + here]))
    return Surface(vertices, np.concatenate(faces))


def ellipsoid(radii: np.ndarray) -> Surface:
    """An ellipsoid about the origin with the (3,) half-axes ``radii`` [m]."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SEGMENTS // 2 + 1)
    profile = np.column_stack([np.cos(angles), np.sin(angles)])
    profile[[0, -1], 0] = 0.0
    ball = lathe(profile)
    return Surface(ball.vertices * radii, ball.faces)


def rounded(radius: float, half_length: float) -> Surface:
    """A capsule along z: a cylinder of twice the ``half_length`` with round ends [m]."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SEGMENTS // 2 + 2)
    heights = radius * np.sin(angles) + np.where(angles > 0.0, half_length, -half_length)
    profile = np.column_stack([radius * np.cos(angles), heights])
    profile[[0, -1], 0] = 0.0
    return lathe(profile)


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


def disc(radius: float, thickness: float) -> Surface:
    """A flat round mark on the xy plane, its normal along z [m]."""
    flat = cylinder(radius, 0.5 * thickness)
    return Surface(flat.vertices, flat.faces)


def tube(points: np.ndarray, radius: float, sides: int = 6) -> Surface:
    """A tube of ``radius`` along the (n, 3) ``points`` [m], n of 2 or more."""
    tangents = np.gradient(points, axis=0)
    lengths = np.linalg.norm(tangents, axis=1, keepdims=True)
    tangents = tangents / np.where(lengths > 0.0, lengths, 1.0)
    # Any direction across will do; carried along so that the tube does not twist.
    across = np.zeros_like(points)
    last = np.eye(3)[int(np.argmin(np.abs(tangents[0])))]
    for i, tangent in enumerate(tangents):
        sideways = last - tangent * tangent.dot(last)
        size = float(np.linalg.norm(sideways))
        if size > NO_DIRECTION:
            last = sideways / size
        across[i] = last
    upright = np.cross(tangents, across)
    angles = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    rings = (
        points[:, None]
        + radius * np.cos(angles)[:, None] * across[:, None]
        + radius * np.sin(angles)[:, None] * upright[:, None]
    )
    here = np.arange(sides)
    there = np.roll(here, -1)
    faces = []
    for i in range(len(points) - 1):
        low, high = i * sides, (i + 1) * sides
        faces.append(np.column_stack([low + here, low + there, high + there]))
        faces.append(np.column_stack([low + here, high + there, high + here]))
    return Surface(rings.reshape(-1, 3), np.concatenate(faces))


def merged(surfaces: list[Surface]) -> Surface:
    """Several surfaces as one, each keeping its colours if all have some."""
    starts = np.cumsum([0, *(len(s.vertices) for s in surfaces[:-1])])
    colors = [s.colors for s in surfaces]
    return Surface(
        np.concatenate([s.vertices for s in surfaces]),
        np.concatenate([s.faces + k for s, k in zip(surfaces, starts, strict=True)]),
        None if any(c is None for c in colors) else np.concatenate(colors),  # type: ignore[arg-type]
        all(s.smooth for s in surfaces),
    )
