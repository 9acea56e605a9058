"""Shapes as bodies that fly, with what they are by definition: how far they reach, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import impulsekit as ik

__all__ = ["KINDS", "Shape", "pair", "shape_of"]

KINDS = ("box", "cylinder", "capsule", "sphere")


@dataclass(frozen=True)
class Shape:
    """A shape about its centre: half sizes, or radius and half length, or radii [m]."""

    kind: str
    sizes: tuple[float, ...]

    @property
    def geom(self) -> str:
        """Of MuJoCo's language."""
        return f'<geom name="%s" type="{self.kind}" size="{" ".join(map(repr, self.sizes))}"/>'

    def reach(self, way: np.ndarray) -> float:
        """The support function."""
        x, y, z = way
        a, *more = self.sizes
        across = np.hypot(x, y)
        return {
            "box": lambda: np.abs(way) @ np.array(self.sizes),
            "sphere": lambda: a,
            "capsule": lambda: more[0] * abs(z) + a,
            "cylinder": lambda: more[0] * abs(z) + a * across,
        }[self.kind]()

    def outside(self, point: np.ndarray) -> float:
        """How far a point is outside, in the shape's own frame [m]; not positive inside."""
        x, y, z = point
        a, *more = self.sizes
        across = np.hypot(x, y)
        return {
            "box": lambda: (np.abs(point) - self.sizes).max(),
            "sphere": lambda: np.linalg.norm(point) - a,
            "capsule": lambda: np.hypot(across, max(abs(z) - more[0], 0.0)) - a,
            "cylinder": lambda: max(abs(z) - more[0], across - a),
        }[self.kind]()


def shape_of(kind: str, rng: np.random.Generator) -> Shape:
    """One of some size."""
    sizes = rng.uniform(0.05, 0.4, 3)
    count = {"sphere": 1, "capsule": 2, "cylinder": 2}.get(kind, 3)
    return Shape(kind, tuple(sizes[:count].tolist()))


def pair(first: Shape, other: Shape) -> ik.Robot:
    """Two bodies, "a" and "b", with these shapes as geometry "one" and "two"."""
    return ik.combine(
        **{
            name: ik.Robot.from_mjcf(
                f'<mujoco><worldbody><body name="{name}"><freejoint name="free"/>'
                f'<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{shape.geom % geometry}'
                "</body></worldbody></mujoco>"
            )
            for name, shape, geometry in (("a", first, "one"), ("b", other, "two"))
        }
    )
