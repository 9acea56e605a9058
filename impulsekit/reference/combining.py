"""Several trees in one world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from impulsekit.errors import RangeError, ShapeError, UnknownNameError
from impulsekit.reference.arithmetic import Arithmetic, Array
from impulsekit.reference.body import WORLD, Bodies, Body
from impulsekit.reference.joint import UNIT_TOLERANCE

if TYPE_CHECKING:
    from impulsekit.reference.tree import Tree

__all__ = ["combined_bodies"]


def combined_bodies(
    parts: Mapping[str, Tree], placements: Mapping[str, tuple[Any, Any]] | None
) -> Bodies:
    """The bodies of all parts; arguments and errors are those of ``Tree.combine``."""
    if not parts:
        raise RangeError.of("number of parts", 0, "1 or more")
    wanted = dict(placements or {})
    for name in wanted:
        if name not in parts:
            raise UnknownNameError.among("part", name, parts)
    numbers = next(iter(parts.values())).arithmetic
    bodies: list[Body] = []
    speed_names: list[str] = []
    coordinate_names: list[str] = []
    for name, part in parts.items():
        if part.arithmetic.name != numbers.name:
            raise RangeError.of(
                f'arithmetic of the part "{name}"', part.arithmetic.name, numbers.name
            )
        first = len(bodies)
        for body in part.bodies:
            joint = replace(
                body.joint,
                name=f"{name}/{body.joint.name}",
                mimics=f"{name}/{body.joint.mimics}" if body.joint.mimics else "",
                first_coordinate=body.joint.first_coordinate + len(coordinate_names),
                first_speed=body.joint.first_speed + len(speed_names),
            )
            if body.parent == WORLD and name in wanted:
                joint = replace(joint, placement=_placement(name, wanted[name], numbers))
            parent = WORLD if body.parent == WORLD else body.parent + first
            bodies.append(replace(body, name=f"{name}/{body.name}", parent=parent, joint=joint))
        speed_names += [f"{name}/{speed}" for speed in part.speed_names]
        coordinate_names += [f"{name}/{coordinate}" for coordinate in part.coordinate_names]
    return Bodies(tuple(bodies), tuple(speed_names), tuple(coordinate_names))


def _placement(part: str, placement: tuple[Any, Any], numbers: Arithmetic) -> tuple[Array, Array]:
    translation, turned = placement
    origin = numbers.finite_array(translation, f'translation of the part "{part}"')
    matrix = numbers.finite_array(turned, f'rotation of the part "{part}"')
    for what, value, shape in (("translation", origin, (3,)), ("rotation", matrix, (3, 3))):
        if value.shape != shape:
            raise ShapeError.of(f'{what} of the part "{part}"', shape, value.shape)
    error = max(abs(entry) for entry in (matrix @ matrix.T - numbers.eye(3)).flat)
    if error > UNIT_TOLERANCE:
        raise RangeError.of(f'rotation of the part "{part}"', turned, "an orthogonal matrix")
    return matrix, origin
