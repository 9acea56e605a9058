"""Newton's cradle: so many in, so many out."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ...robot import Robot
from ...scene import Contact, Law, Scene
from .problem import Problem

__all__ = ["cradles"]

RADIUS = 0.25  # m


def cradles(quick: bool) -> Iterator[Problem]:
    """n equal balls in a row on a rail, of which n // 3 come in at 1 m/s; e = 1, in sequence."""
    for balls in (3, 6) if quick else (3, 6, 12):
        yield _cradle(balls)


def _cradle(balls: int) -> Problem:
    names = [f"ball_{i:02d}" for i in range(balls)]
    lines = ['<robot name="cradle"><link name="rail"/>']
    for i, name in enumerate(names):
        lines.append(
            f'<link name="{name}"><inertial><mass value="1"/>'
            '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="{name}_slide" type="prismatic"><parent link="rail"/>'
            f'<child link="{name}"/><origin xyz="{2 * RADIUS * i!r} 0 0"/><axis xyz="1 0 0"/>'
            '<limit lower="-1e4" upper="1e4" effort="1" velocity="1"/></joint>'
        )
    robot = Robot.from_urdf("".join([*lines, "</robot>"]))
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
