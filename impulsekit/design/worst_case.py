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
    box = _Box(robot, restitution, friction, pose or {})
    search = _Search(scene, place, moving, joint, slice(0, 3) if kind == "force" else slice(3, 6))
    corners = itertools.product((0.0, 1.0), repeat=len(box))
    points = [np.array(corner) for corner in itertools.islice(corners, 1024)]
    if samples:
        from scipy.stats import qmc

        count = 2 ** math.ceil(math.log2(max(samples, 2)))
        points += list(qmc.Sobol(len(box), seed=0).random(count)[:samples])
    best = max(((search.size(box, x), i) for i, x in enumerate(points)), default=(-1.0, 0))
    if best[0] < 0.0:
        raise InputError("worst_impact: no impact of the box is valid")
    x, most = points[best[1]].copy(), best[0]
    step = 0.25
    while step > LEAST_STEP:
        better = False
        for k, sign in itertools.product(range(len(box)), (-1.0, 1.0)):
            other = x.copy()
            other[k] = min(max(other[k] + sign * step, 0.0), 1.0)
            size = search.size(box, other)
            if size > most:
                x, most, better = other, size, True
        step = step if better else 0.618 * step
    return search.at(box, x)


class _Box:
    """The unit cube as coefficients and offsets."""

    def __init__(
        self,
        robot: Robot,
        restitution: Sequence[float] | None,
        friction: Sequence[float] | None,
        pose: Mapping[str, Sequence[float]],
    ) -> None:
        self.names: list[str] = []
        self.bounds: list[tuple[float, float]] = []
        for name, bounds, most in (
            ("restitution", restitution, 1.0),
            ("friction", friction, MOST_FRICTION),
        ):
            if bounds is not None:
                self._add(name, bounds, 0.0, most)
        self.places: list[int] = []
        for name, bounds in pose.items():
            entry = robot.model.joints[robot.joint_id(name)]
            if entry.nq != 1:
                raise InputError(f'pose: joint "{name}" has no single coordinate')
            self.places.append(entry.idx_q)
            self._add(f'pose["{name}"]', bounds, -math.inf, math.inf)
        if not self.names:
            raise InputError("worst_impact: give restitution=, friction= or pose= to vary")

    def _add(self, name: str, bounds: Sequence[float], least: float, most: float) -> None:
        if len(bounds) != 2:
            raise RangeError.of(name, bounds, "two numbers, low and high")
        low, high = (number(x, name) for x in bounds)
        if not least <= low <= high <= most:
            raise RangeError.of(name, (low, high), f"low <= high within {least:g} to {most:g}")
        self.names.append(name)
        self.bounds.append((low, high))

    def __len__(self) -> int:
        return len(self.names)

    def values(self, x: np.ndarray) -> list[float]:
        """The numbers at a point of the unit cube."""
        return [a + t * (b - a) for t, (a, b) in zip(x.tolist(), self.bounds, strict=True)]


class _Search:
    """The reaction of one joint, for points of the box."""

    def __init__(self, scene: Scene, q: np.ndarray, v: np.ndarray, joint: str, part: slice) -> None:
        self._scene, self._q, self._v = scene, q, v
        self._joint, self._part = joint, part
        self.solved = self.refused = 0

    def _impact(self, box: _Box, x: np.ndarray) -> tuple[Any, dict[str, float]]:
        values = dict(zip(box.names, box.values(x), strict=True))
        q, scene = self._q.copy(), self._scene
        offsets = box.values(x)[len(box) - len(box.places) :]
        for place, offset in zip(box.places, offsets, strict=True):
            q[place] += offset
        changes = {k: values[k] for k in ("restitution", "friction") if k in values}
        if changes:
            contacts: list[Any] = []
            for entry in scene.contacts:
                own: dict[str, Any] = {k: n for k, n in changes.items() if hasattr(entry, k)}
                contacts.append(replace(entry, **own))
            scene = replace(scene, contacts=contacts)
        return ImpactSolver(scene).solve(q, self._v), values

    def size(self, box: _Box, x: np.ndarray) -> float:
        """The size of the reaction; −1 where the impact is not valid."""
        impact, _ = self._impact(box, x)
        self.solved += 1
        if not impact.is_valid():
            self.refused += 1
            return -1.0
        return float(np.linalg.norm(self._reaction(impact)[self._part]))

    def at(self, box: _Box, x: np.ndarray) -> WorstImpact:
        """All that is told of a point."""
        impact, values = self._impact(box, x)
        reaction = self._reaction(impact)
        return WorstImpact(
            self._joint,
            float(np.linalg.norm(reaction[self._part])),
            values.get("restitution"),
            values.get("friction"),
            impact.q,
            reaction,
            self.solved,
            self.refused,
        )

    def _reaction(self, impact: Any) -> np.ndarray:
        if self._joint not in impact.reactions:
            raise UnknownNameError.among("joint", self._joint, tuple(impact.reactions))
        reaction: np.ndarray = impact.reactions[self._joint]
        return reaction
