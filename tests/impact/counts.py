"""How many calls and lines of Python a solve takes: exact, and the same on every machine."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType
from typing import Any

from benchmarks.problems.blows import AT, LINEAR
from benchmarks.problems.contacts import CORNERS, SOLES
from benchmarks.problems.problem import drawn_state
from impulsekit.chain import pendulum_urdf
from impulsekit.impact import solve
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, Contact, FrameAnchor, PointAnchor, Scene

__all__ = ["MOST", "Counts", "counted_solves", "counts"]


@dataclass(frozen=True)
class Counts:
    """What one call takes.

    Attributes:
        calls: of Python functions and of built-in ones.
        lines: of Python that are run.
    """

    calls: int
    lines: int


# A sixth above what Python 3.11 counts; versions differ in how they count comprehensions.
MOST = {
    "Panda, known blow": Counts(calls=15, lines=36),
    "Talos, known blow": Counts(calls=23, lines=51),
    "Talos, both feet held": Counts(calls=36, lines=108),
    "Three rods, pinned at both ends": Counts(calls=32, lines=92),
    "Talos, one contact": Counts(calls=42, lines=115),
    "Talos, two smooth contacts": Counts(calls=53, lines=140),
}


def counts(call: Callable[[], object]) -> Counts:
    """Calls and lines of one call, after two that are not counted."""
    call()
    call()
    found = {"calls": 0, "lines": 0}

    def on_call(frame: FrameType, event: str, argument: object) -> None:
        found["calls"] += event in ("call", "c_call")

    def on_line(frame: FrameType, event: str, argument: object) -> Any:
        found["lines"] += event == "line"
        return on_line

    # A test that is itself measured for coverage goes on being so.
    profiler, tracer = sys.getprofile(), sys.gettrace()
    try:
        sys.setprofile(on_call)
        call()
        sys.setprofile(profiler)
        sys.settrace(on_line)
        call()
    finally:
        sys.settrace(tracer)
        sys.setprofile(profiler)
    # The call that puts the profiler back counts, too.
    return Counts(found["calls"] - 1, found["lines"])


def counted_solves() -> dict[str, Callable[[], object]]:
    """Solves whose way does not depend on rounding, by name."""
    panda = Robot.from_example("panda")
    talos = Robot.from_example("talos", root="freeflyer")
    blow = AppliedImpulse("gripper_left_base_link", LINEAR, at=AT)
    feet = [FrameAnchor(name) for name in ("leg_left_6_link", "leg_right_6_link")]
    point = Contact(SOLES[0], at=CORNERS[0], friction=0.5)
    corners = [Contact(SOLES[0], at=corner) for corner in CORNERS[:2]]
    rods = Robot.from_urdf(pendulum_urdf(3))
    pushed = AppliedImpulse("link_2", [1.0, 0.0, 0.5], at=[0, 0, -0.5])
    # Across their plane the pin's row moves nothing.
    loop = Scene(rods, [pushed], [PointAnchor("link_3", at=[0, 0, -1])])
    scenes = {
        "Panda, known blow": Scene(panda, [AppliedImpulse("panda_hand", LINEAR)]),
        "Talos, known blow": Scene(talos, [blow]),
        "Talos, both feet held": Scene(talos, [blow], feet),
        "Three rods, pinned at both ends": loop,
        "Talos, one contact": Scene(talos, contacts=[point]),
        "Talos, two smooth contacts": Scene(talos, contacts=corners),
    }
    return {name: _solving(scene) for name, scene in scenes.items()}


def _solving(scene: Scene) -> Callable[[], object]:
    q = scene.robot.neutral()
    v = 0.1 * drawn_state(scene.robot, 0)[1]
    if scene.contacts:
        v[2] -= 1.0
    return lambda: solve(scene, q, v)
