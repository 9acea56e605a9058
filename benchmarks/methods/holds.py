"""What holds points or frames fast in the world, in plain numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from impulsekit.scene import FrameAnchor, PointAnchor

from ..problems.problem import Problem

__all__ = ["Hold", "hold_of", "is_fixed", "is_held"]


@dataclass(frozen=True, eq=False)
class Hold:
    """A point of a body held in three rows, or a frame of it in six.

    Attributes:
        body: its index.
        rotation, at: (3, 3), (3,) of the frame in the body.
        rows: 3 or 6.
    """

    body: int
    rotation: np.ndarray
    at: np.ndarray
    rows: int


def hold_of(problem: Problem, entry: Any) -> Hold:
    """The hold of an anchor, or of a contact whose point sticks."""
    robot = problem.scene.robot
    frame = robot.model.frames[robot.frame_id(entry.frame)]
    return Hold(
        frame.parentJoint - 1,
        np.array(frame.placement.rotation),
        frame.placement.act(np.array(entry.at)),
        6 if isinstance(entry, FrameAnchor) else 3,
    )


def is_held(problem: Problem, constraint: Any) -> bool:
    """Whether a constraint holds all of a point or a frame at rest in the world."""
    if isinstance(constraint, FrameAnchor):
        whole = len(constraint.directions) == 6
    else:
        whole = isinstance(constraint, PointAnchor)
    still = whole and np.all(np.array(constraint.velocity) == 0.0)
    return bool(still) and is_fixed(problem, constraint.other)


def is_fixed(problem: Problem, frame: str) -> bool:
    """Whether a frame does not move."""
    robot = problem.scene.robot
    return bool(robot.model.frames[robot.frame_id(frame)].parentJoint == 0)
