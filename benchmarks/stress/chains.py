"""Sweeps of struck chains of rods: to the end of Pinocchio, and far beyond it."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from benchmarks.truths.found import Exact, Found
from benchmarks.truths.impacts import Impacts
from benchmarks.truths.numbers import truth_numbers
from benchmarks.truths.residuals import Residuals
from impulsekit.batch.long import long_chain
from impulsekit.chain import chain_urdf
from impulsekit.reference.arithmetic import Array
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, Scene

from .judge import judge
from .sweep import Case, Point, Sweeps

SWEEPS = Sweeps()


def pin_velocities(links: int, blow: Any) -> Array:
    """(links + 1,) the velocities of the points of Whittaker's chain, the struck end first.

    Rods of 1 kg and 1 m; u_{k-1} + 4 u_k + u_{k+1} = 0, and 2 u_0 + u_1 = 6 P at the struck
    end, u_{n-1} + 2 u_n = 0 at the free one (Whittaker, "Analytical Dynamics", p. 175). From
    the free end on the ratios r_k = u_k/u_{k+1} follow from each other.
    """
    number = truth_numbers().number
    ratio = number(-2)
    ratios = []
    for _ in range(links):
        ratios.append(ratio)
        ratio = -4 - 1 / ratio
    ratios.reverse()
    # 2 u_0 + u_1 = u_1 (2 r_0 + 1).
    velocity = 6 * number(blow) / (2 + 1 / ratios[0])
    velocities = [velocity]
    for ratio in ratios:
        velocity = velocity / ratio
        velocities.append(velocity)
    return np.array(velocities, dtype=object)


@SWEEPS.of("chain", "links", (1.0, 2.0, 4.0, 8.0, 16.0, 24.0, 48.0, 96.0, 150.0), 4)
def chain(links: float, rng: np.random.Generator) -> Case:
    """A straight chain struck at its end, by solve and the batch."""
    n = int(links)
    robot = Robot.from_urdf(chain_urdf(n), root="planar")
    blow = AppliedImpulse(f"link_{n}", linear=(0.0, float(rng.uniform(1, 5)), 0.0), at=(1, 0, 0))
    scene = Scene(robot, [blow])
    q = robot.neutral()[None]
    return Case(scene, q, np.zeros((1, robot.nv)), _Straight(scene))


class _Straight:
    """The straight chain by Whittaker's recursion; conditions by Kane's masses up to a size."""

    LARGEST = 24

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def at(self, q: np.ndarray, v: np.ndarray) -> Any:
        """The equations at the straight configuration."""
        if len(v) - 2 <= self.LARGEST:
            return Impacts(self.scene).at(q, v)
        return _Recursion(self.scene, len(v) - 2)


class _Recursion:
    """The answer of the recursion, as speeds of the planar root and the joints."""

    def __init__(self, scene: Scene, links: int) -> None:
        (blow,) = scene.impulses
        if not isinstance(blow, AppliedImpulse):
            raise TypeError(type(blow).__name__)
        self._u = pin_velocities(links, blow.linear[1])[::-1]

    def exact(self, found: Found | None = None) -> Exact | None:
        """The speeds: the near end moves with u_n; joints turn by differences of rates."""
        number = truth_numbers().number
        # Point k is the far end of link k, counted from the root.
        rates = self._u[1:] - self._u[:-1]
        dv = np.array([number(0), self._u[0], rates[0], *(rates[1:] - rates[:-1])], dtype=object)
        spans = np.array([number(1)] * len(dv), dtype=object)
        # The recursion is dominated by its diagonal, 4 against 1 + 1: condition 3. A joint's
        # speed is the sum of three points' velocities, with factors 1, 2 and 1.
        largest = np.max(np.abs(self._u))
        slack = np.array([3 * 4 * largest] * len(dv), dtype=object)
        return Exact(dv, slack, spans)

    def residuals(self, found: Found) -> Residuals:
        """Not formed for long chains."""
        return Residuals(math.nan, math.nan)


@SWEEPS.of("long-chain", "links", (10.0, 100.0, 1e3, 1e4, 1e5), 4)
def long(links: float, rng: np.random.Generator) -> list[Point]:
    """A straight chain of any length, struck at its end, by ``long_chain``."""
    n = int(links)
    blow = float(rng.uniform(1, 5))
    tree = long_chain(n)
    start = time.perf_counter()
    impact = tree.solve([AppliedImpulse(f"link_{n}", linear=(0.0, blow, 0.0), at=(1, 0, 0))])
    seconds = time.perf_counter() - start
    exact = pin_velocities(n, blow)[::-1]
    heads = impact.twists_after
    last = heads[-1, 1] + heads[-1, 5]
    found = Found(np.array([*heads[:, 1], last]), "SOLVED", True, seconds)
    weights = np.array([truth_numbers().number(1)] * (n + 1), dtype=object)
    slack = np.array([3 * np.max(np.abs(exact))] * (n + 1), dtype=object)
    state = _Known(Exact(exact, slack, weights))
    told, _ = judge(state, None, found)
    numbers = (told.error, told.condition, told.share, told.each, told.momentum, told.law)
    return [
        Point("long-chain", links, 0, 0, "long chain", "SOLVED", told.verdict, *numbers, seconds)
    ]


class _Known:
    """An answer that is there already."""

    def __init__(self, exact: Exact) -> None:
        self._exact = exact

    def exact(self, found: Found | None = None) -> Exact | None:
        return self._exact

    def residuals(self, found: Found) -> Residuals:
        return Residuals(math.nan, math.nan)
