"""The reaction of a joint to a blow, and where to strike to spare it.

The wrench that a joint carries is linear in the blow: R = B(c) n for a unit blow n at a
point c, and B is affine in c along a line. So the sparing point and the worst direction
have closed forms.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..errors import InputError, quoted
from ..errors.calls import public
from ..formatting import OneLine
from ..robot import Robot
from ..robot.arrays import lock
from ..scene import Scene
from ..scene.numbers import vector
from .response import Response, unit_vector

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# [m] Points nearer than this are one: coordinates of robots are given to micrometres.
ONE_POINT = 1e-12
# What a joint carries changes along a line by less than this share of itself: by rounding alone.
UNMOVED = 1e-12
# Of the line: how well the least is placed; its value errs by the square of that.
PLACED = 1e-10


@public
@dataclass(frozen=True, eq=False, repr=False)
class SparedJoint(OneLine):
    """The point and direction of a blow that loads a joint least.

    Attributes:
        joint, frame: the joint, and the struck frame.
        at: (3,) the point in the frame's coordinates [m], read-only.
        direction: (3,) of the blow in world axes, unit, read-only.
        along: position of the point on the searched line, 0 at its start, 1 at its end.
        share: magnitude of the joint's linear impulse over that of the blow; 0 for no load.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> spared = spare_joint(rod, [0.0], "joint_1", "link_1", [0, 0, 0], [0, 0, -1], [1, 0, 0])
        >>> round(spared.along, 9), round(spared.share, 9)
        (0.666666667, 0.0)
    """

    joint: str
    frame: str
    at: np.ndarray
    direction: np.ndarray
    along: float
    share: float


@public
@dataclass(frozen=True, eq=False, repr=False)
class WorstBlow(OneLine):
    """The directions of a blow at a point that load a joint most and least.

    Attributes:
        direction: (3,) of the largest load, unit, world axes, read-only.
        share: the joint's impulse over that of the blow; for ``kind="couple"`` the couple
            [m].
        kindest, kindest_share: the direction of the smallest load.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> worst = worst_blow(rod, [0.0], "joint_1", "link_1", at=[0, 0, -1])
        >>> worst.share >= worst.kindest_share
        True
    """

    direction: np.ndarray
    share: float
    kindest: np.ndarray
    kindest_share: float


@public
def reaction_map(
    scene: Scene | Robot, q: ArrayLike, joint: str, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)
) -> np.ndarray:
    """Return the reaction impulse of a joint by an impulsive wrench at a point: a (6, 6) matrix.

    Both wrenches are linear before angular in world axes; that of the joint is the one
    that the parent gives the child, at the joint's origin.

    Args:
        scene, q, joint: as for ``spare_joint``.
        frame, at: the struck point, in the frame's coordinates [m].

    Raises:
        UnknownNameError, ShapeError, NotFiniteError, StateError, InputError.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> pin_load = reaction_map(rod, [0.0], "joint_1", "link_1", at=[0, 0, -1])
        >>> float(round(pin_load[0, 0], 12))  # a blow at the end: half of it, the same way
        0.5
    """
    return Response(scene, q).reaction_map(joint, frame, at)


@public
def spare_joint(
    scene: Scene | Robot,
    q: ArrayLike,
    joint: str,
    frame: str,
    start: ArrayLike,
    end: ArrayLike,
    direction: ArrayLike | None = None,
) -> SparedJoint:
    """Find the point on a line, and the direction, where a blow loads a joint least.

    Args:
        scene, q: the robot, or a scene whose constraints apply, at a configuration.
        joint: the joint whose load is to be small.
        frame: the struck frame.
        start, end: (3,) two points of the line in the frame [m].
        direction: of the blow in world axes; the line then extends beyond both points. By
            default the best of all directions, between the two points.

    Raises:
        InputError: start and end are one point, or all points of the line are equal.
        UnknownNameError, ShapeError, NotFiniteError, StateError.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> found = spare_joint(rod, [0.0], "joint_1", "link_1", [0, 0, 0], [0, 0, -1], [1, 0, 0])
        >>> round(found.along, 12), round(found.share, 12)
        (0.666666666667, 0.0)
    """
    response = Response(scene, q)
    first, last = np.array(vector(start, "start")), np.array(vector(end, "end"))
    if np.linalg.norm(last - first) < ONE_POINT:
        raise InputError("spare_joint: start and end are one point, expected a line between two")
    at_start = response.reaction_map(joint, frame, first)
    rotation = response.mechanics.frame_placement(frame).rotation
    # A blow n at c + s b is n at c and the couple s b × n.
    base, slope = at_start[:3, :3], at_start[:3, 3:] @ pin.skew(rotation @ (last - first))
    if direction is not None:
        n = unit_vector(direction, "direction")
        s = _nearest(base @ n, slope @ n)
    else:
        s = _best_place(base, slope)
        n = np.linalg.svd(base + s * slope)[2][-1]
    share = float(np.linalg.norm((base + s * slope) @ n))
    at = first + s * (last - first)
    lock(at, n)
    return SparedJoint(joint, frame, at, n, float(s), share)


@public
def centre_of_percussion(
    scene: Scene | Robot, q: ArrayLike, joint: str, frame: str | None = None
) -> SparedJoint:
    """Return the centre of percussion of the link behind a revolute joint.

    It lies on the line from the joint to the mass centre of its body; the blow is normal to
    that line and to the axis. The bodies further out move with their joints.

    Args:
        scene, q: as for ``spare_joint``.
        joint: a joint with one axis of rotation.
        frame: the frame of the point's coordinates; by default the joint's own.

    Raises:
        InputError: the joint does not turn about one axis, or its mass centre is on it.
        UnknownNameError, StateError.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> centre_of_percussion(rod, [0.4], "joint_1").at.round(12).tolist()
        [0.0, 0.0, -0.666666666667]
    """
    response = Response(scene, q)
    robot = response.robot
    joint_id = robot.joint_id(joint)
    model = robot.model
    data = model.joints[joint_id].createData()
    own = model.joints[joint_id]
    own.calc(data, response.q)
    subspace = np.asarray(data.S).reshape(6, -1)
    if subspace.shape[1] != 1 or np.linalg.norm(subspace[3:]) < 0.5:
        raise InputError(f'joint "{joint}" does not turn about one axis')
    axis = subspace[3:, 0]
    centre = model.inertias[joint_id].lever
    radius = centre - axis * (axis @ centre)
    if np.linalg.norm(radius) < ONE_POINT:
        raise InputError(f'the mass centre of the body behind joint "{joint}" is on its axis')
    placement = response.mechanics.joint_placement(joint_id)
    across = placement.rotation @ np.cross(axis, radius)
    foot = centre - radius
    struck = frame if frame is not None else _frame_of(robot, joint_id, joint)
    item = model.frames[robot.frame_id(struck)]
    if item.parentJoint != joint_id:
        raise InputError(f'frame "{struck}" is not on the body behind joint "{joint}"')
    start, end = (item.placement.actInv(point) for point in (foot, foot + radius))
    return spare_joint(response.scene, response.q, joint, struck, start, end, across)


@public
def worst_blow(
    scene: Scene | Robot,
    q: ArrayLike,
    joint: str,
    frame: str,
    at: ArrayLike = (0.0, 0.0, 0.0),
    *,
    kind: str = "force",
) -> WorstBlow:
    """Find the directions of a blow at a point that load a joint most and least.

    Args:
        kind: "force" for the joint's linear impulse, "couple" for its angular one.

    Raises:
        InputError: an unknown kind.
        UnknownNameError, ShapeError, NotFiniteError, StateError.

    Example:
        >>> from impulsekit import Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> round(worst_blow(rod, [0.0], "joint_1", "link_1", [0, 0, -2 / 3]).share, 12)
        1.0
    """
    if kind not in ("force", "couple"):
        raise InputError(f'worst_blow: kind must be "force" or "couple", got {quoted(kind)}')
    rows = slice(0, 3) if kind == "force" else slice(3, 6)
    table = Response(scene, q).reaction_map(joint, frame, at)[rows, :3]
    _, values, ways = np.linalg.svd(table)
    worst, kindest = ways[0].copy(), ways[-1].copy()
    lock(worst, kindest)
    return WorstBlow(worst, float(values[0]), kindest, float(values[-1]))


def _nearest(base: np.ndarray, slope: np.ndarray) -> float:
    """Return the s at which |base + s slope| is least."""
    size = float(slope @ slope)
    if size <= UNMOVED**2 * float(base @ base) or size == 0.0:
        raise InputError(
            "spare_joint: the joint carries the same wherever on the line it is struck"
        )
    return float(-(base @ slope) / size)


def _best_place(base: np.ndarray, slope: np.ndarray) -> float:
    """Return the s at which the smallest singular value of base + s slope is least, by search."""
    from scipy.optimize import minimize_scalar

    def least(s: float) -> float:
        return float(np.linalg.svd(base + s * slope, compute_uv=False)[-1])

    grid = np.linspace(0.0, 1.0, 41)
    best = float(grid[int(np.argmin([least(s) for s in grid]))])
    near = (max(0.0, best - 0.025), min(1.0, best + 0.025))
    found = minimize_scalar(least, bounds=near, method="bounded", options={"xatol": PLACED})
    return float(found.x) if found.fun <= least(best) else best


def _frame_of(robot: Robot, joint_id: int, joint: str) -> str:
    """Return a frame that sits at a joint."""
    for frame in robot.model.frames:
        if frame.parentJoint == joint_id and frame.type == pin.FrameType.JOINT:
            return str(frame.name)
    raise InputError(f'joint "{joint}" has no frame of its own; name one')
