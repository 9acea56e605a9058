"""Motions after an impact, all the way to a state that is known to 22 digits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.truths.flight import state_after_flight
from impulsekit.chain import pendulum_urdf
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, Contact, Scene

from ..urdf import one_body
from .blows import AT, LINEAR
from .problem import Problem, drawn_state, exact_or_kept

SOURCE = "Kane's equations, integrated in 40 digits"
TOLERANCE = 1e-8
# A block that lands flat and slides: its family, its side [m], the height it falls from [m], its
# speed across [m/s], and its friction.
SLIDING, SIDE, FALL, ACROSS, FRICTION = "sliding block", 0.2, 0.05, 1.0, 0.3
BODY = (
    '<robot name="racket"><link name="body"><inertial><mass value="1.5"/>'
    '<inertia ixx="0.01" iyy="0.03" izz="0.035" ixy="0.002" ixz="0" iyz="0.001"/></inertial>'
    "</link></robot>"
)


def swings(quick: bool) -> Iterator[Problem]:
    """The pendulum of n rods, struck at its lower end, one second later."""
    for n in (1, 2) if quick else (1, 2, 4):
        robot = Robot.from_urdf(pendulum_urdf(n))
        blow = AppliedImpulse(f"link_{n}", linear=[2.0, 0, 0], at=[0, 0, -1])
        scene = Scene(robot, [blow])
        yield _motion("swing after a blow", n, scene, robot.neutral(), robot.velocity(), 1.0, 16)


def flights(quick: bool) -> Iterator[Problem]:
    """Bodies and robots that fly: a body struck off its centre, Solo12, Talos on the trunk.

    The size is the number of speeds.
    """
    body = Robot.from_urdf(BODY, root="freeflyer")
    blow = AppliedImpulse("body", linear=[0.2, -0.1, 0.3], at=[0.1, 0.05, 0])
    scene = Scene(body, [blow])
    yield _motion("flight after a blow", 6, scene, body.neutral(), body.velocity(), 1.0, 16)
    if quick:
        return
    for name, trunk in (("solo12", "base_link"), ("talos", "torso_2_link")):
        robot = Robot.from_example(name, root="freeflyer")
        q, v = drawn_state(robot, 1, spread=0.3)
        struck = Scene(robot, [AppliedImpulse(trunk, LINEAR, at=AT)])
        yield _motion("flight after a blow", robot.nv, struck, q, 0.5 * v, 0.25, 4)


def sliding_blocks(quick: bool) -> Iterator[Problem]:
    """A block that lands flat on four corners, loses µ v_n across, and slides until it stops."""
    g, half = 9.81, 0.5 * SIDE
    robot = one_body("block", 1, SIDE**2 / 6.0)
    corners = [
        Contact("block", at=[x, y, -half], friction=FRICTION)
        for x in (-half, half)
        for y in (-half, half)
    ]
    scene = Scene(robot, contacts=corners, gravity=[0, 0, -g])
    landed = np.sqrt(2.0 * FALL / g)
    slides = ACROSS - FRICTION * g * landed
    end = ACROSS * landed + slides**2 / (2.0 * FRICTION * g)
    q = robot.configuration(root_joint=[0, 0, half + FALL, 0, 0, 0, 1])
    exact = np.array([end, 0, half, 0, 0, 0, 1, *6 * [0.0]])
    v = robot.velocity(root_joint=[ACROSS, 0, 0, 0, 0, 0])
    yield Problem(SLIDING, 4, scene, q, v, lambda: exact, "closed form", TOLERANCE, 0.5)


def _motion(
    family: str,
    size: int,
    scene: Scene,
    q: np.ndarray,
    v: np.ndarray,
    duration: float,
    steps: int,
) -> Problem:
    def derive() -> Sequence[object]:
        return state_after_flight(scene, q, v, duration, steps=steps)

    exact = exact_or_kept(family, size, scene, q, v, derive, duration)
    return Problem(family, size, scene, q, v, exact, SOURCE, TOLERANCE, duration)
