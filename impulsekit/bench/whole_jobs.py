"""Whole jobs against a bound: a check, a page, a chain that grows.

Run with ``python -m impulsekit.bench.whole_jobs``.
"""

from __future__ import annotations

import math
import pathlib
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import pinocchio as pin

from ..batch.long import long_chain
from ..checking import check
from ..impact import solve
from ..robot import Robot
from ..scene import AppliedImpulse, FrameAnchor, Scene
from ..view.recording import Recording
from ..view.replay import replay
from .claim import Claim

__all__ = ["claims", "main"]


def _seconds(
    job: Callable[[], object], rounds: int = 5, clock: Callable[[], float] = time.perf_counter
) -> list[float]:
    """How long each of some rounds took."""
    taken = []
    for _ in range(rounds):
        start = clock()
        job()
        taken.append(clock() - start)
    return taken


def second_check_of_talos() -> list[float]:
    """Seconds to hold Talos, both feet held, against Kane once its URDF has been read."""
    robot = Robot.from_example("talos", root="freeflyer")
    scene = Scene(
        robot,
        [AppliedImpulse("gripper_left_base_link", [0, 0, 1])],
        constraints=[FrameAnchor("left_sole_link"), FrameAnchor("right_sole_link")],
    )
    q = robot.neutral()
    check(solve(scene, q, robot.velocity()))
    return _seconds(lambda: check(solve(scene, q, robot.velocity())))


def page_of_talos() -> list[float]:
    """Seconds to write the page of a 10 s motion of Talos at 60 Hz."""
    robot = Robot.from_example("talos", root="freeflyer")
    t = np.arange(601) / 60.0
    v = 0.3 * np.random.default_rng(0).normal(size=robot.nv)
    q = [pin.integrate(robot.model, robot.neutral(), math.sin(x) * v) for x in t]
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "talos.html"
        return _seconds(lambda: replay(Recording(robot, t, q), page, play=False), rounds=2)


def growth_of_long_chains() -> float:
    """The slope of log time over log links, from 10³ to 10⁶ links; 1 is linear."""
    sizes = (1_000, 10_000, 100_000, 1_000_000)
    taken = []
    for links in sizes:
        chain = long_chain(links)
        blow = [AppliedImpulse(f"link_{links}", linear=[0, 5, 0], at=[1, 0, 0])]
        chain.solve(blow)
        # In processor time: the longest take so long that other load always breaks in.
        taken.append(min(_seconds(partial(chain.solve, blow), clock=time.process_time)))
    return float(np.polyfit(np.log(sizes), np.log(taken), 1)[0])


def claims() -> Iterator[Claim]:
    """A check, a page, the growth of long chains."""
    label = "second check of Talos against Kane"
    yield Claim.of_values(label, second_check_of_talos(), 0.2, "s")
    yield Claim.of_values("page of 10 s of Talos at 60 Hz", page_of_talos(), 10.0, "s")
    label = "long chains, 10³ to 10⁶ links: slope of time"
    yield Claim.of_values(label, [growth_of_long_chains() for _ in range(3)], 1.05)


def main() -> None:
    """Measure and write the rows."""
    for claim in claims():
        sys.stdout.write(claim.line())


if __name__ == "__main__":
    main()
