"""Example robots that are struck, free or held: Kane's equations in 50 digits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, FrameAnchor, PointAnchor, Scene
from tests.truths.digits import velocity_after

from .kept import exact_or_kept
from .problem import Problem
from .states import drawn_state

__all__ = ["AT", "LINEAR", "held_robots", "struck_robots"]

# Robot, root, where it is struck, and what holds it.
PANDA = ("panda", "fixed", "panda_hand")
SOLO = ("solo12", "freeflyer", "FR_FOOT")
TALOS = ("talos", "freeflyer", "gripper_left_base_link")
AT = (0.1, 0.0, 0.05)  # m
LINEAR = (0.3, -0.2, 1.0)  # N s


def struck_robots(quick: bool) -> Iterator[Problem]:
    """A blow on the hand or a foot; the size is the number of speeds."""
    for name, root, frame in (PANDA, TALOS) if quick else (PANDA, SOLO, TALOS):
        robot = Robot.from_example(name, root=root)
        yield _problem("struck robot", robot.nv, robot, frame, ())


def held_robots(quick: bool) -> Iterator[Problem]:
    """The same with points or feet held fast; the size is the number of rows."""
    talos = Robot.from_example(TALOS[0], root=TALOS[1])
    soles = [FrameAnchor(f"leg_{side}_6_link") for side in ("left", "right")]
    if not quick:
        solo = Robot.from_example(SOLO[0], root=SOLO[1])
        feet = [PointAnchor(foot) for foot in ("FL_FOOT", "HL_FOOT", "HR_FOOT")]
        yield _problem("held robot", 9, solo, SOLO[2], feet)
        yield _problem("held robot", 6, talos, TALOS[2], soles[:1])
    yield _problem("held robot", 12, talos, TALOS[2], soles)


def _problem(
    family: str,
    size: int,
    robot: Robot,
    frame: str,
    held: Sequence[FrameAnchor | PointAnchor],
) -> Problem:
    q, v = drawn_state(robot, size)
    scene = Scene(robot, [AppliedImpulse(frame, LINEAR, at=AT)], held)
    exact = exact_or_kept(family, size, scene, q, v, lambda: velocity_after(scene, q, v))
    return Problem(family, size, scene, q, v, exact, "Kane's equations in 50 digits")
