"""Conditions on a ``pin.Model`` or a joint: right dynamics, and data that fit into memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError, UnknownNameError, a_thing
from ..errors.calls import public
from ..files import free_memory
from .arrays import LARGEST

# Measured: 0.5 GB for 200 degrees of freedom, 4 GB for 400 (tensors of second derivatives).
BYTES = 63
# One for what solves, one for its results.
COPIES = 2
# Below this nothing has to be looked up.
ALWAYS_FITS = 100


def check_capacity(model: pin.Model, copies: int = COPIES) -> None:
    """Check that data can be made for a model, before the system kills the process for it.

    Raises:
        RangeError: it would not fit into the memory that is free.
    """
    if model.nv <= ALWAYS_FITS:
        return
    needed, free = copies * BYTES * model.nv**3, free_memory()
    if needed > free:
        raise RangeError(
            f"a robot of {model.nv} degrees of freedom needs {needed / 1e9:.1f} GB, and "
            f"{free / 1e9:.1f} GB are free; impulsekit.long takes large trees",
            what="degrees of freedom",
            value=model.nv,
            allowed="what fits into memory",
        )


@public
def planar_root(
    forward: Sequence[float] = (1.0, 0.0, 0.0), up: Sequence[float] = (0.0, 0.0, 1.0)
) -> pin.JointModel:
    """Return a root that moves in any plane: along two directions, and about the third.

    ``root="sagittal"`` is this one with the defaults: x, z and pitch.

    Args:
        forward, up: the directions of the plane, at right angles; any lengths.

    Returns:
        A joint for ``Robot.from_urdf(..., root=...)``: its q and v are the ways along ``forward``
        and ``up`` [m], and the angle about up × forward [rad], positive when ``up`` turns
        towards ``forward``.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError: they span no plane.

    Example:
        >>> planar_root(forward=[0, 1, 0]).nv
        3
    """
    ways = []
    for given, name in ((forward, "forward"), (up, "up")):
        way = np.array([float(x) for x in given])
        length = float(np.linalg.norm(way))
        if way.shape != (3,) or not np.isfinite(length) or length == 0.0:
            raise InputError(f"planar_root: {name} must be a direction, three numbers, not zero")
        ways.append(way / length)
    if abs(ways[0].dot(ways[1])) > LEVEL:
        raise InputError("planar_root: forward and up must be at right angles")
    joint = pin.JointModelComposite(pin.JointModelPrismaticUnaligned(ways[0]))
    joint.addJoint(pin.JointModelPrismaticUnaligned(ways[1]))
    joint.addJoint(pin.JointModelRevoluteUnaligned(np.cross(ways[1], ways[0])))
    return joint


# Directions whose cosine is larger are not at right angles.
LEVEL = 1e-9
ROOTS: dict[str, Callable[[], Any] | None] = {
    "fixed": None,
    "planar": pin.JointModelPlanar,
    "sagittal": planar_root,
    "freeflyer": pin.JointModelFreeFlyer,
}


def check_depth_first(model: pin.Model) -> None:
    """Check that every joint hangs on the one before it, or on one that that one hangs on."""
    way = [0]
    for joint_id in range(1, model.njoints):
        parent = model.parents[joint_id]
        if parent not in way:
            names = model.names
            raise InputError(
                f'from_model: joint "{names[joint_id]}" is a child of "{names[parent]}" but comes '
                f'after "{names[way[-1]]}", which is not; add joints depth first, each '
                "followed by all its descendants"
            )
        del way[way.index(parent) + 1 :]
        way.append(joint_id)


def check_finite(model: pin.Model) -> None:
    """Check that joints, where they are and what they carry are finite numbers.

    Raises:
        InputError: it names the joint.
    """
    for joint_id in range(1, model.njoints):
        what = f'joint "{model.names[joint_id]}"'
        # A joint that mimics another moves as that one.
        if model.joints[joint_id].shortname() != "JointModelMimic":
            _check_motion(model.joints[joint_id], what)
        if not np.isfinite(model.jointPlacements[joint_id].homogeneous).all():
            raise InputError(f"{what}: its placement is not finite")
        if not np.isfinite(model.inertias[joint_id].matrix()).all():
            raise InputError(f"{what}: the inertia it carries is not finite")
    if not np.isfinite(model.armature).all():
        raise InputError("armature: not finite")


def _check_motion(joint: Any, what: str) -> None:
    """Check that the way of a joint is made of numbers in range: its axis, its pitch."""
    alone = pin.Model()
    joint_id = alone.addJoint(0, joint, pin.SE3.Identity(), "joint")
    own, data = alone.joints[joint_id], alone.joints[joint_id].createData()
    own.calc(data, pin.neutral(alone))
    ways = np.concatenate([data.S.ravel(), data.M.homogeneous.ravel()])
    if not np.isfinite(ways).all():
        raise InputError(
            f"{what}, a {joint.shortname()}, has an axis or a pitch that is not a finite number"
        )
    # As a pin.JointModelHX() has whose pitch was never set.
    if not np.abs(ways).max() <= LARGEST:
        raise InputError(
            f"{what}, a {joint.shortname()}, has an axis or a pitch beyond {LARGEST:g}: give its "
            "pitch [m/rad] to its constructor"
        )


def root_joint(root: str | pin.JointModel) -> tuple[Any, str]:
    """Return the joint that stands for ``root`` (None where it is fixed) and its name.

    Raises:
        UnknownNameError, InputError: it is none, or not made of finite numbers.
    """
    if isinstance(root, str):
        if root not in ROOTS:
            raise UnknownNameError.among("root", root, ROOTS)
        kind = ROOTS[root]
        return (None if kind is None else kind()), root
    shortname = getattr(root, "shortname", None)
    if shortname is None:
        raise InputError(
            'root must be "fixed", "planar", "sagittal", "freeflyer" or a pin.JointModel, '
            f"got {a_thing(root)}"
        )
    _check_motion(root, "root")
    return root, shortname()
