"""Newton's cradle: so many in, so many out."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from impulsekit.robot import Robot
from impulsekit.scene import Contact, Law, Scene

from ..urdf import joint_text, link_text, robot_text
from .problem import Problem

__all__ = ["cradles"]

RADIUS = 0.25  # m


def cradles(quick: bool) -> Iterator[Problem]:
    """n equal balls in a row on a rail, of which n // 3 come in at 1 m/s; e = 1, in sequence."""
    for balls in (3, 6) if quick else (3, 6, 12):
        yield _cradle(balls)


def _cradle(balls: int) -> Problem:
    names = [f"ball_{i:02d}" for i in range(balls)]
    parts = [link_text("rail")]
    for i, name in enumerate(names):
        place = (2 * RADIUS * i, 0, 0)
        slide = joint_text(f"{name}_slide", "prismatic", "rail", name, at=place)
        parts += [link_text(name, 1), slide]
    robot = Robot.from_urdf(robot_text("cradle", *parts))
    contacts = [
        Contact(
            right,
            at=[-RADIUS, 0, 0],
            normal=[1, 0, 0],
            origin=[RADIUS, 0, 0],
            against=left,
            restitution=1.0,
        )
        for left, right in pairwise(names)
    ]
    scene = Scene(robot, contacts=contacts, law=Law(order="sequential"))
    coming = balls // 3
    v = np.zeros(balls)
    v[:coming] = 1.0
    return Problem(
        "cradle", balls, scene, robot.neutral(), v, lambda: v[::-1].copy(), "so many in and out"
    )
