"""The worst impulse that a joint carries over a box of coefficients and poses."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..batch.solve import solve_batch
from ..errors import InputError, RangeError, SetupWarning, check_kind
from ..errors.calls import public
from ..formatting import OneLine
from ..robot import state
from ..scene import Scene
from .box import Box, bounds_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


# [rad] Where the search along a direction ends: the worst case is flat there.
LEAST_STEP = 1e-4
# Of a step that finds nothing worse, the share that is tried next.
GOLDEN = 0.618
# Of a box with more sides not all corners are solved.
MOST_CORNERS = 1024


@public
@dataclass(frozen=True, eq=False, repr=False)
class WorstImpact(OneLine):
    """The largest joint impulse found over a box of coefficients and poses.

    Attributes:
        joint: its name.
        impulse: the size of its reaction force impulse [N s], or couple impulse [N m s].
        restitution, friction: where it was found; None where not varied.
        q: (nq,) the configuration there.
        reaction: (6,) the reaction there, world axes.
        solved, refused: how many impacts were looked at, and how many were not valid.

    Example:
        >>> from impulsekit import Contact, Robot
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", at=[0, 0, -0.1])], gap_bound=1)
        >>> fall = ball.velocity(root_joint=[0, 0, -1, 0, 0, 0])
        >>> limits = {"restitution": (0.2, 0.6), "samples": 2}
        >>> worst_impact(scene, ball.neutral(), fall, "root_joint", **limits).refused
        0
    """

    joint: str
    impulse: float
    restitution: float | None
    friction: float | None
    q: np.ndarray
    reaction: np.ndarray
    solved: int
    refused: int


@public
def worst_impact(
    scene: Scene,
    q: ArrayLike,
    v: ArrayLike,
    joint: str,
    *,
    restitution: Sequence[float] | None = None,
    friction: Sequence[float] | None = None,
    pose: Mapping[str, Sequence[float]] | None = None,
    kind: str = "force",
    samples: int = 200,
) -> WorstImpact:
    """Find the largest impulse that a joint carries over a box of restitution, friction and pose.

    All corners of the box and a Sobol sequence in it are solved, and the worst is improved along
    each axis by golden steps. It is a lower bound of the true worst case, which is at a corner
    where the impulse is monotone.

    Args:
        scene: with contacts.
        q, v: (nq,), (nv,) the state in the middle.
        joint: whose reaction counts.
        restitution, friction: (low, high), for all contacts alike; None leaves those of the scene.
        pose: by joint name (low, high), offsets on its single coordinate [rad, m].
        kind: "force" or "couple".
        samples: how many points inside the box.

    Raises:
        UnknownNameError: no such joint.
        RangeError: bounds out of range or order.
        InputError: nothing is varied, or no impact of the box is valid.

    Example:
        >>> from impulsekit import Contact, Robot
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> stop = Contact("link_1", at=[0, 0, -1], normal=[-1, 0, 0])
        >>> scene = Scene(rod, contacts=[stop], gap_bound=9)
        >>> worst = worst_impact(scene, [0.0], [-1.0], "joint_1", restitution=(0, 0.5), samples=4)
        >>> round(worst.restitution, 6), round(worst.impulse, 6)
        (0.5, 0.25)
    """
    check_kind(scene, Scene, "worst_impact")
    robot = scene.robot
    place = state.checked_configuration(robot.model, q)
    moving = state.checked_velocity(robot.model, v)
    if kind not in ("force", "couple"):
        raise RangeError.of("kind", kind, '"force" or "couple"')
    part = slice(0, 3) if kind == "force" else slice(3, 6)
    bounds = bounds_of(robot, "worst_impact", restitution, friction, pose or {})
    box = _Reactions(scene, place, moving, bounds)
    x, most = _worst(box, samples, robot.joint_id(joint) - 1, part)
    solved, refused = box.solved, box.refused
    q, _, coefficients = box.at(x[None])
    reaction = box.reactions(x[None])[0, robot.joint_id(joint) - 1]
    e, mu = (coefficients.get(name, [None])[0] for name in ("restitution", "friction"))
    return WorstImpact(joint, most, e, mu, q[0], reaction, solved, refused)


def _worst(box: _Reactions, samples: int, row: int, part: slice) -> tuple[np.ndarray, float]:
    """Return the point of the box with the largest reaction of a joint, and its size."""

    def sizes(points: np.ndarray) -> np.ndarray:
        found = np.linalg.norm(box.reactions(points)[:, row, part], axis=1)
        return np.where(np.isnan(found), -1.0, found)

    count = len(box.bounds)
    corners = itertools.islice(itertools.product((0.0, 1.0), repeat=count), MOST_CORNERS)
    points = np.array(list(corners))
    if samples:
        from scipy.stats import qmc

        power = math.ceil(math.log2(max(samples, 2)))
        points = np.vstack([points, qmc.Sobol(count, seed=0).random(2**power)[:samples]])
    found = sizes(points)
    most = float(found.max())
    if most < 0.0:
        raise InputError("worst_impact: no impact of the box is valid")
    # Of equal sizes the last one.
    x = points[np.flatnonzero(found == most)[-1]]
    ways, step = np.vstack([-np.eye(count), np.eye(count)]), 0.25
    while step > LEAST_STEP:
        others = np.clip(x + step * ways, 0.0, 1.0)
        found = sizes(others)
        if found.max() > most:
            x, most = others[found.argmax()], float(found.max())
        else:
            step *= GOLDEN
    return x, most


class _Reactions(Box):
    """The reactions of joints over a box, and how many impacts were solved and refused."""

    solved = refused = 0

    def reactions(self, points: np.ndarray) -> np.ndarray:
        """Return (K, joints, 6) reactions at (K, n) points; NaN where an impact is not valid."""
        q, _, coefficients = self.at(points)
        varied = self.by_contact(coefficients)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SetupWarning)
            batch = solve_batch(self.scene, q, self.v, outputs=("reactions",), **varied)
        self.solved += len(points)
        self.refused += int((~batch.valid).sum())
        return np.where(batch.valid[:, None, None], batch.reactions, np.nan)
