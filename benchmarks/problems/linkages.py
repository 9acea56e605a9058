"""Closed linkages that are struck: maximal coordinates in 50 digits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from impulsekit.chain import pendulum_urdf
from impulsekit.checking.demands import constraint_rows, known_impulses
from impulsekit.checking.system import reference_robot
from impulsekit.reference import Arithmetic
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, PointAnchor, Scene
from tests.truths.digits import DIGITS
from tests.truths.maximal import impact_of_free_bodies

from .kept import exact_or_kept
from .problem import Problem
from .states import drawn_state

__all__ = ["closed_chains"]


def closed_chains(quick: bool) -> Iterator[Problem]:
    """n rods between two pins on the ground, bent at random; 3 are a four-bar.

    The pin at the end gives three rows, of which one, across the plane, is redundant.
    """
    for n in (3, 8) if quick else (3, 8, 16):
        yield _closed(n)


def _closed(n: int) -> Problem:
    robot = Robot.from_urdf(pendulum_urdf(n))
    q, _ = drawn_state(robot, n)
    blow = AppliedImpulse(f"link_{(n + 1) // 2}", linear=[1.0, 0.0, 0.5], at=[0, 0, -0.5])
    pin = PointAnchor(f"link_{n}", at=[0, 0, -1])
    scene = Scene(robot, [blow], [pin])
    v = robot.velocity()
    exact = exact_or_kept("closed chain", n, scene, q, v, lambda: _by_free_bodies(scene, q, v))
    source = "maximal coordinates in 50 digits"
    return Problem("closed chain", n, scene, q, v, exact, source)


def _by_free_bodies(scene: Scene, q: np.ndarray, v: np.ndarray) -> Any:
    """(nv,) v⁺ with every body free and every joint as rows."""
    reference = reference_robot(scene.robot, Arithmetic.mpmath(DIGITS))
    known = known_impulses(reference, scene.impulses)
    rows = constraint_rows(reference, reference.system.kinematics(q), v, scene.constraints)
    found = impact_of_free_bodies(reference.system, q, v, known.loads, known.in_joints, rows)
    return reference.system.arithmetic.array(v) + found.dy
