"""The guard against getting slower: counts, which are exact, and ratios, never times.

``counts`` tells how many calls and lines of Python a solve takes; they are the same on every
machine, and a test holds them to ``MOST``. ``python -m impulsekit.bench.guard`` times solves
against bare Pinocchio in turn and holds the ratios to bounds of about twice what they are; a
ratio that is above is measured again, up to three times in all, for the machine may be loaded.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType
from typing import Any

import numpy as np

from ..chain import pendulum_urdf
from ..impact import solve
from ..impact.warm import compile_laws
from ..robot import Robot
from ..scene import AppliedImpulse, Contact, FrameAnchor, PointAnchor, Scene
from . import constrained, contacts, known_blow
from .claim import Claim
from .problems.states import drawn_state
from .timing import import_times, time_in_turn

__all__ = ["MOST", "Counts", "counted_solves", "counts", "guarded", "main"]

TRIES = 3


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
    "Panda, known blow": Counts(calls=15, lines=34),
    "Talos, known blow": Counts(calls=23, lines=51),
    "Talos, both feet held": Counts(calls=67, lines=145),
    "Three rods, pinned at both ends": Counts(calls=93, lines=168),
    "Talos, one contact": Counts(calls=42, lines=92),
    "Talos, two smooth contacts": Counts(calls=166, lines=324),
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
    blow = AppliedImpulse("gripper_left_base_link", known_blow.LINEAR, at=known_blow.AT)
    feet = [FrameAnchor(name) for name in constrained.FEET]
    point = Contact(contacts.SOLES[0], at=contacts.CORNERS[0], friction=0.5)
    corners = [Contact(contacts.SOLES[0], at=corner) for corner in contacts.CORNERS[:2]]
    rods = Robot.from_urdf(pendulum_urdf(3))
    pushed = AppliedImpulse("link_2", [1.0, 0.0, 0.5], at=[0, 0, -0.5])
    # Across their plane the pin's row moves nothing.
    loop = Scene(rods, [pushed], [PointAnchor("link_3", at=[0, 0, -1])])
    scenes = {
        "Panda, known blow": Scene(panda, [AppliedImpulse("panda_hand", known_blow.LINEAR)]),
        "Talos, known blow": Scene(talos, [blow]),
        "Talos, both feet held": Scene(talos, [blow], feet),
        "Three rods, pinned at both ends": loop,
        "Talos, one contact": Scene(talos, contacts=[point]),
        "Talos, two smooth contacts": Scene(talos, contacts=corners),
    }
    return {name: _solving(scene) for name, scene in scenes.items()}


def _solving(scene: Scene) -> Callable[[], object]:
    compile_laws(scene)
    q = scene.robot.neutral()
    v = 0.1 * drawn_state(scene.robot, 0)[1]
    if scene.contacts:
        v[2] -= 1.0
    return lambda: solve(scene, q, v)


def guarded() -> dict[str, Callable[[], Claim]]:
    """The ratios of the command, each measured by a call."""
    panda = Robot.from_example("panda")
    talos = Robot.from_example("talos", root="freeflyer")
    held, q_held, v_held = constrained.held_talos()
    q, v = talos.neutral(), 0.1 * drawn_state(talos, 0)[1] - np.eye(talos.nv)[2]
    sole, corner = contacts.SOLES[0], contacts.CORNERS[0]
    one = Scene(talos, contacts=[Contact(sole, at=corner, friction=0.5)])
    eight = Scene(
        talos,
        contacts=[
            Contact(sole, at=at, friction=0.5) for sole in contacts.SOLES for at in contacts.CORNERS
        ],
    )

    def blow(robot: Robot, frame: str, bound: float) -> Callable[[], Claim]:
        scene = Scene(robot, [AppliedImpulse(frame, known_blow.LINEAR, at=known_blow.AT)])
        state, rest = robot.neutral(), robot.velocity()
        bare = known_blow.bare_pinocchio(robot, frame, state)
        return _ratio(f"{robot.name}, known blow", lambda: solve(scene, state, rest), bare, bound)

    return {
        "panda": blow(panda, "panda_hand", 3.0),
        "talos": blow(talos, "gripper_left_base_link", 2.5),
        "held": _ratio(
            "talos, both feet held",
            lambda: solve(held, q_held, v_held),
            constrained.bare_pinocchio(talos, q_held, v_held),
            3.5,
        ),
        "contact": _ratio(
            "talos, one contact",
            lambda: solve(one, q, v),
            contacts.bare_impulse_dynamics(talos, sole, corner, q, v),
            5.5,
        ),
        "contacts": _ratio(
            "talos, eight foot points",
            lambda: solve(eight, q, v),
            contacts.bare_admm(talos, q, v, 0.5, 1e-8),
            0.9,
        ),
        "import": _import_ratio("import impulsekit", 0.2),
        "import of solve": _import_ratio("from impulsekit import Robot, Scene, solve", 2.0),
    }


def _ratio(
    label: str, ours: Callable[[], object], bare: Callable[[], object], bound: float
) -> Callable[[], Claim]:
    def measured() -> Claim:
        times = time_in_turn({"ours": ours, "bare": bare})
        return Claim.of_ratio(f"{label}: solve / bare", times["ours"], times["bare"], bound)

    return measured


def _import_ratio(statement: str, bound: float) -> Callable[[], Claim]:
    def measured() -> Claim:
        ours, theirs = import_times([statement, "import pinocchio"], rounds=5).values()
        return Claim.of_ratio(f"{statement} / import pinocchio", ours, theirs, bound)

    return measured


def main() -> int:
    """Write a line for each ratio; 1 if one stays above its bound."""
    kept = True
    for measured in guarded().values():
        for _ in range(TRIES):
            claim = measured()
            if claim.met:
                break
        sys.stdout.write(claim.line())
        kept = kept and claim.met
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
