"""Several robots and free objects in one world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, ShapeError, UnknownNameError, a_thing, shown
from ..errors.calls import public
from .arrays import array_of, floats
from .placing import rotation_matrix
from .robot import Robot

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# Entries of R Rᵀ that differ by more from the unit matrix: numbers written with ten digits pass.
ORTHONORMAL = 1e-9


@public
def combine(
    *robots: Mapping[str, Robot],
    placements: Mapping[str, ArrayLike | pin.SE3] | None = None,
    **more: Robot,
) -> Robot:
    """Combine several robots into one, side by side in one world.

    Every name is prefixed with the name of its robot: "arm/elbow", "ball/root_joint". The
    states are stacked in the order given.

    Args:
        robots: the robots by name, as mappings. more: the same as keywords.
        placements: placement of each robot's root in the world: (3,) a point [m], (4, 4) a
            homogeneous matrix, or a ``pin.SE3``; the origin by default.

    Raises:
        InputError: no robot, or a name that is empty or contains a slash.
        UnknownNameError: a placement of an unknown robot.
        ShapeError: a placement of the wrong shape.

    Example:
        >>> arm = Robot.from_example("panda")
        >>> both = combine(left=arm, right=arm, placements={"right": [0, 1, 0]})
        >>> both.nv, both.joint_names[9]
        (18, 'right/panda_joint1')
    """
    for given in robots:
        if not isinstance(given, Mapping):
            raise InputError(
                f"combine: robots are given by name, as in combine(arm=arm, ball=ball), got "
                f"{a_thing(given)}"
            )
    if not isinstance(placements, Mapping | None):
        raise InputError(
            f"combine: placements must be a mapping by name, got {a_thing(placements)}"
        )
    named = {**{name: robot for given in robots for name, robot in given.items()}, **more}
    if not named:
        raise InputError("combine needs one robot or more")
    for name in placements or {}:
        if name not in named:
            raise UnknownNameError.among("robot", name, named, "placements")
    world = pin.Model()
    parts = []
    frame_names: dict[str, str] = {}
    for name, robot in named.items():
        if not isinstance(robot, Robot):
            raise InputError(f'combine: "{name}" is {a_thing(robot)}, not a Robot')
        if not name or "/" in name or name == "world" or not name.isprintable():
            raise InputError(
                f'combine: "{shown(name)}" cannot be a robot\'s name; give printable text '
                'without "/", and not "world"'
            )
        placement = _placement((placements or {}).get(name), name)
        model = _numbered(robot.model, f"{name}/", frame_names)
        world = pin.appendModel(world, model, 0, placement)
        for part in robot.parts:
            within = (
                pin.SE3.Identity() if part.placement is None else _placement(part.placement, name)
            )
            matrix = (placement * within).homogeneous
            parts.append(
                replace(
                    part,
                    prefix=f"{name}/{part.prefix}",
                    placement=tuple(tuple(map(float, row)) for row in matrix),
                )
            )
    for i in range(1, world.nframes):
        world.frames[i].name = frame_names[world.frames[i].name]
    _restore(world, [robot.model for robot in named.values()])
    return Robot(world, parts, "+".join(named))


def _numbered(model: pin.Model, prefix: str, names: dict[str, str]) -> pin.Model:
    """A copy whose joints have the prefix and whose frames have numbers; ``names`` takes theirs.

    A URDF may call a link and a joint alike, and ``pin.appendModel`` looks for parent frames by
    name alone.
    """
    model = pin.Model(model)
    for i in range(1, model.njoints):
        model.names[i] = prefix + model.names[i]
    for i in range(1, model.nframes):
        number = f"{prefix}{i}"
        names[number] = prefix + model.frames[i].name
        model.frames[i].name = number
    return model


def _restore(world: pin.Model, models: list[pin.Model]) -> None:
    """Set what ``pin.appendModel`` leaves out, and inertias that it has summed anew.

    Joints and degrees of freedom stand in the world in the order of the models.
    """
    joints = dofs = 0
    for model in models:
        for i in range(1, model.njoints):
            world.inertias[joints + i] = model.inertias[i]
        for field in ("armature", "lowerVelocityLimit"):
            getattr(world, field)[dofs : dofs + model.nv] = getattr(model, field)
        joints += model.njoints - 1
        dofs += model.nv


def _placement(value: Any, name: str) -> pin.SE3:
    if value is None or isinstance(value, pin.SE3):
        return value or pin.SE3.Identity()
    what = f'placement of "{name}"'
    array = floats(value, what)
    if array.shape == (3,):
        return pin.SE3(np.eye(3), array_of(array, (3,), what))
    if array.shape != (4, 4):
        raise ShapeError.of(what, (4, 4), array.shape, "or a point (3,)")
    rotation_matrix("rotation", array[:3, :3], f"{what}: its 3×3 part", most=ORTHONORMAL)
    return pin.SE3(array_of(array, (4, 4), what))
