"""Feet that strike the ground: Kane's equations and Coulomb's law in 50 digits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from impulsekit.robot import Robot
from impulsekit.scene import Contact, Scene
from tests.truths.digits import velocity_after

from .kept import exact_or_kept
from .problem import Problem
from .states import drawn_state

__all__ = ["CORNERS", "FEET", "SOLES", "feet", "landing_state", "single_feet", "smooth_feet"]

# Four corners of each sole of Talos, in the sole's frame [m].
SOLES = ("left_sole_link", "right_sole_link")
CORNERS = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]
FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")
SOURCE = "Kane's equations and Coulomb's law in 50 digits"


def single_feet(quick: bool) -> Iterator[Problem]:
    """One point with friction on the ground; the size is the number of speeds."""
    robots = [("talos", SOLES[0], CORNERS[0])]
    if not quick:
        robots.insert(0, ("solo12", FEET[1], (0.0, 0.0, 0.0)))
    for words, friction, along in (("sticks", 0.7, 0.0), ("slides", 0.2, 2.0)):
        for name, frame, at in robots:
            robot = Robot.from_example(name, root="freeflyer")
            contact = Contact(frame, at=at, friction=friction, restitution=0.3)
            yield _landing(f"foot that {words}", robot.nv, robot, [contact], along)


def feet(quick: bool) -> Iterator[Problem]:
    """All feet at once, with friction; the size is the number of points.

    Those that slip are one point a foot: where more points slip than a foot has freedoms,
    the law itself has many answers, each with velocities of its own.
    """
    talos = Robot.from_example("talos", root="freeflyer")
    if not quick:
        solo = Robot.from_example("solo12", root="freeflyer")
        heels = [Contact(sole, at=CORNERS[0], friction=0.1) for sole in SOLES]
        yield _landing("slipping feet", 2, talos, heels)
        yield _landing("slipping feet", 4, solo, [Contact(foot, friction=0.1) for foot in FEET])
        yield _landing("feet", 4, solo, [Contact(foot, friction=0.5) for foot in FEET])
    yield _landing("feet", 8, talos, _corners(0.5))


def smooth_feet(quick: bool) -> Iterator[Problem]:
    """The same without friction: eight points on two planes, two of them redundant."""
    if not quick:
        solo = Robot.from_example("solo12", root="freeflyer")
        contacts = [Contact(foot, restitution=0.4) for foot in FEET]
        yield _landing("smooth feet", 4, solo, contacts)
    talos = Robot.from_example("talos", root="freeflyer")
    yield _landing("smooth feet", 8, talos, _corners(0.0))


def _corners(friction: float) -> list[Contact]:
    return [Contact(sole, at=at, friction=friction) for sole in SOLES for at in CORNERS]


def landing_state(robot: Robot, seed: int, along: float) -> tuple[np.ndarray, np.ndarray]:
    """q and v near the neutral pose, upright, that comes down at some 1 m/s."""
    _, v = drawn_state(robot, seed)
    q = robot.neutral()
    q[7:] += drawn_state(robot, seed + 1, spread=0.1)[0][7:]
    return q, 0.3 * v + np.array([along, 0.0, -1.0] + [0.0] * (robot.nv - 3))


def _landing(
    family: str, size: int, robot: Robot, contacts: Sequence[Contact], along: float = 0.0
) -> Problem:
    q, v = landing_state(robot, size, along)
    scene = Scene(robot, contacts=contacts)
    exact = exact_or_kept(family, size, scene, q, v, lambda: velocity_after(scene, q, v))
    return Problem(family, size, scene, q, v, exact, SOURCE)
