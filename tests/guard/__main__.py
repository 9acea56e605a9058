"""``python -m tests.guard``: the guard against getting slower, by ratios, never by times.

Solves are timed against bare Pinocchio in turn and held to bounds of about twice what the ratios
are; a ratio that is above is measured again, up to three times in all, for the machine may be
loaded.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np

from impulsekit.bench import constrained, contacts, known_blow
from impulsekit.bench.claim import Claim
from impulsekit.bench.problems.states import drawn_state
from impulsekit.bench.timing import import_times, time_in_turn
from impulsekit.impact import solve
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, Contact, Scene

__all__ = ["guarded", "main"]

TRIES = 3


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
