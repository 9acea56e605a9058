"""The worst impulse that a joint carries over a box of coefficients and poses."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..display import OneLine
from ..errors import InputError, RangeError, UnknownNameError, check_kind
from ..impact import ImpactSolver
from ..robot import state
from ..scene import Scene
from ..scene.numbers import number

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..robot import Robot

# [rad] Where the search along a direction ends: the worst case is flat there.
LEAST_STEP = 1e-4
# No larger friction is asked about: it holds all.
MOST_FRICTION = 1e9


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
    """The largest impulse that a joint carries over a box of restitution, friction and pose.

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
    bounds = _bounds(robot, restitution, friction, pose or {})
    part = slice(0, 3) if kind == "force" else slice(3, 6)
    search = _Search(scene, place, moving, joint, part, bounds)
    count = len(bounds)
    corners = itertools.product((0.0, 1.0), repeat=count)
    points = [np.array(corner) for corner in itertools.islice(corners, 1024)]
    if samples:
        from scipy.stats import qmc

        power = math.ceil(math.log2(max(samples, 2)))
        points += list(qmc.Sobol(count, seed=0).random(2**power)[:samples])
    sizes = [search.size(point) for point in points]
    # Of equal sizes the last one.
    most, best = max(zip(sizes, range(len(sizes)), strict=True))
    if most < 0.0:
        raise InputError("worst_impact: no impact of the box is valid")
    x = points[best].copy()
    step = 0.25
    while step > LEAST_STEP:
        better = False
        for k, sign in itertools.product(range(count), (-1.0, 1.0)):
            other = x.copy()
            other[k] = min(max(other[k] + sign * step, 0.0), 1.0)
            size = search.size(other)
            if size > most:
                x, most, better = other, size, True
        step = step if better else 0.618 * step
    return search.at(x)


# By "restitution", "friction", or the entry of q that is offset.
_Bounds = dict[str | int, tuple[float, float]]


def _bounds(
    robot: Robot,
    restitution: Sequence[float] | None,
    friction: Sequence[float] | None,
    pose: Mapping[str, Sequence[float]],
) -> _Bounds:
    found: _Bounds = {}
    if restitution is not None:
        found["restitution"] = _interval("restitution", restitution, 0.0, 1.0)
    if friction is not None:
        found["friction"] = _interval("friction", friction, 0.0, MOST_FRICTION)
    for name, ends in pose.items():
        entry = robot.model.joints[robot.joint_id(name)]
        if entry.nq != 1:
            raise InputError(f'pose: joint "{name}" has no single coordinate')
        found[int(entry.idx_q)] = _interval(f'pose["{name}"]', ends, -math.inf, math.inf)
    if not found:
        raise InputError("worst_impact: give restitution=, friction= or pose= to vary")
    return found


def _interval(name: str, ends: Sequence[float], least: float, most: float) -> tuple[float, float]:
    if len(ends) != 2:
        raise RangeError.of(name, ends, "two numbers, low and high")
    low, high = (number(x, name) for x in ends)
    if not least <= low <= high <= most:
        raise RangeError.of(name, (low, high), f"low <= high within {least:g} to {most:g}")
    return low, high


class _Search:
    """The reaction of one joint, for points of the unit cube that stands for the box."""

    def __init__(
        self,
        scene: Scene,
        q: np.ndarray,
        v: np.ndarray,
        joint: str,
        part: slice,
        bounds: _Bounds,
    ) -> None:
        self._scene, self._q, self._v = scene, q, v
        self._joint, self._part, self._bounds = joint, part, bounds
        self.solved = self.refused = 0

    def _impact(self, x: np.ndarray) -> tuple[Any, dict[str, float]]:
        q, scene, changes = self._q.copy(), self._scene, dict[str, float]()
        for t, (key, (low, high)) in zip(x.tolist(), self._bounds.items(), strict=True):
            value = low + t * (high - low)
            if isinstance(key, str):
                changes[key] = value
            else:
                q[key] += value
        if changes:
            contacts: list[Any] = []
            for entry in scene.contacts:
                own: dict[str, Any] = {k: n for k, n in changes.items() if hasattr(entry, k)}
                contacts.append(replace(entry, **own))
            scene = replace(scene, contacts=contacts)
        return ImpactSolver(scene).solve(q, self._v), changes

    def size(self, x: np.ndarray) -> float:
        """The size of the reaction; −1 where the impact is not valid."""
        impact, _ = self._impact(x)
        self.solved += 1
        if not impact.is_valid():
            self.refused += 1
            return -1.0
        return float(np.linalg.norm(self._reaction(impact)[self._part]))

    def at(self, x: np.ndarray) -> WorstImpact:
        """The results at a point."""
        impact, values = self._impact(x)
        reaction = self._reaction(impact)
        return WorstImpact(
            self._joint, float(np.linalg.norm(reaction[self._part])), values.get("restitution"),
            values.get("friction"), impact.q, reaction, self.solved, self.refused,
        )  # fmt: skip

    def _reaction(self, impact: Any) -> np.ndarray:
        if self._joint not in impact.reactions:
            raise UnknownNameError.among("joint", self._joint, tuple(impact.reactions))
        reaction: np.ndarray = impact.reactions[self._joint]
        return reaction
