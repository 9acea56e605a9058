"""Faults in making robots, and in their states."""

# One fault a line, however long; wrong types are what it is about.
# ruff: noqa: E501
# mypy: disable-error-code="arg-type, list-item"

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from impulsekit.chain import chain_urdf, pendulum_urdf
from impulsekit.errors import AssumptionWarning
from impulsekit.impact import solve
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import AppliedImpulse, Scene

from .fault import Fault
from .things import ARM, arm, arm_text, ball, joint, link, struck


def _q(what: str, robot: Any, **joints: Any) -> Fault:
    return Fault(what, lambda: robot().configuration(**joints))


def _v(what: str, robot: Any, **joints: Any) -> Fault:
    return Fault(what, lambda: robot().velocity(**joints))


def _solved(what: str, q: Any, v: Any) -> Fault:
    return Fault(what, lambda: solve(struck(), q, v))


def _struck_body(**moments: str) -> None:
    with warnings.catch_warnings():
        # Moments that no body has are told when the robot is made; what the blow says is asked.
        warnings.simplefilter("ignore", AssumptionWarning)
        robot = Robot.from_urdf(arm_text(link("body", **moments)), "freeflyer")
    scene = Scene(robot, [AppliedImpulse("body", linear=[0, 0, 1])])
    solve(scene, robot.neutral(), robot.velocity())


def _massless_arm() -> None:
    text = arm_text(
        link("base"),
        '<link name="upper_arm"/>',
        joint("shoulder", parent="base", child="upper_arm"),
    )
    robot = Robot.from_urdf(text)
    scene = Scene(robot, [AppliedImpulse("upper_arm", linear=[1, 0, 0])])
    solve(scene, robot.neutral(), robot.velocity())


def _too_large() -> None:
    robot = Robot.from_urdf(chain_urdf(1000))
    scene = Scene(robot, [AppliedImpulse("link_1000", linear=[0, 1, 0])])
    # As on a machine with a gigabyte: what is free varies, and the words with it.
    from impulsekit.robot import model_checks

    free = model_checks.free_memory
    model_checks.free_memory = lambda: 1e9
    try:
        _ = solve(scene, robot.neutral(), robot.velocity()).energy
    finally:
        model_checks.free_memory = free


BAD_ROTATION = np.diag([1.0, 1.0, 2.0, 1.0])
HALF = [0, 0, 1, 0, 0, 0, 0.5]

FAULTS = (
    Fault("misspells the name of an example robot", lambda: Robot.from_example("pandaa")),
    Fault("gives a number as the name of an example", lambda: Robot.from_example(7)),
    Fault("asks for an example that exists as SDF only", lambda: Robot.from_example("cassie")),
    Fault("misspells a root", lambda: Robot.from_urdf(ARM, "freeflier")),
    Fault("gives True as a root", lambda: Robot.from_urdf(ARM, True)),
    Fault("gives a URDF where a model is wanted", lambda: Robot.from_model(ARM)),
    Fault("combines nothing", lambda: combine()),
    Fault("combines a list", lambda: combine([arm()])),
    Fault("places robots by a list", lambda: combine(arm=arm(), placements=[[0, 0, 1]])),
    Fault("combines a path", lambda: combine(arm="arm.urdf")),
    Fault("combines under a name with a slash", lambda: combine({"left/arm": arm()})),
    Fault("combines under the world's name", lambda: combine(world=arm())),
    Fault("places a robot that is not there", lambda: combine(arm=arm(), placements={"amr": [0, 0, 1]})),
    Fault("places a robot by two numbers", lambda: combine(arm=arm(), placements={"arm": [0, 1]})),
    Fault("places a robot at infinity", lambda: combine(arm=arm(), placements={"arm": [0, 0, math.inf]})),
    Fault("places a robot by a matrix that stretches", lambda: combine(arm=arm(), placements={"arm": BAD_ROTATION})),
    Fault("places a robot by words", lambda: combine(arm=arm(), placements={"arm": "left"})),
    Fault("makes a chain of no links", lambda: chain_urdf(0)),
    Fault("makes a chain of 2.5 links", lambda: chain_urdf(2.5)),
    Fault("makes a chain without mass", lambda: chain_urdf(3, mass=0)),
    Fault("makes a pendulum of infinite length", lambda: pendulum_urdf(3, length=math.inf)),
    Fault("makes a chain of stubby rods", lambda: chain_urdf(3, radius=0.5)),
    Fault("makes a chain whose name is a number", lambda: chain_urdf(3, name=7)),
    _q("misspells a joint in a configuration", arm, elbwo=0.3),
    _q("moves a fixed joint", arm, wrist=0.3),
    _q("gives a joint's angle in words", arm, elbow="bent"),
    _q("gives a joint's angle as NaN", arm, elbow=math.nan),
    _q("gives a joint with one angle two", arm, elbow=[0.1, 0.2]),
    _q("gives a joint nested angles", arm, elbow=[[0.1]]),
    _q("gives a free-flyer a point alone", ball, root_joint=[0, 0, 1]),
    _q("gives a quaternion of half the length", ball, root_joint=HALF),
    _q("gives a quaternion of zeros", ball, root_joint=[0] * 7),
    _v("misspells a joint in a velocity", arm, sholder=1),
    _v("gives a free-flyer three speeds", ball, root_joint=[1, 0, 0]),
    _v("gives an infinite speed", arm, elbow=math.inf),
    _solved("solves with a q too short", [0], [0, 0]),
    _solved("solves with a v too long", [0, 0], [0, 0, 0]),
    _solved("solves with a column for q", [[0], [0]], [0, 0]),
    _solved("solves with a NaN in q", [math.nan, 0], [0, 0]),
    _solved("solves with an infinite v", [0, 0], [0, math.inf]),
    _solved("solves with words for q", "neutral", [0, 0]),
    _solved("solves with None for v", [0, 0], None),
    _solved("solves with a complex v", [0, 0], [1j, 0]),
    Fault("strikes a joint that moves no mass", _massless_arm),
    Fault("strikes a body whose inertia no body has", lambda: _struck_body(ixy="0.5")),
    Fault("strikes a body without mass", lambda: _struck_body(mass="0", ixx="0", iyy="0", izz="0")),
    Fault("asks for the energy of a chain that does not fit into memory", _too_large),
)  # fmt: skip
