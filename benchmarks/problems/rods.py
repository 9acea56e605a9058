"""Rods that fall on a rough floor: closed forms, evaluated in 50 digits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import Contact, Law, Scene
from tests.truths.numbers import truth_numbers
from tests.truths.planar import planar_impulses

from ..urdf import one_body
from .problem import Problem

__all__ = ["falling_rods", "rods_along_the_path", "smooth_rods"]

MASS, LENGTH = 2.0, 1.0  # kg, m
FRICTION, RESTITUTION = 0.3, 0.5
# What a method may be off along the path [relative]: one that goes in steps has an error of them.
ALONG_THE_PATH = 1e-9


def falling_rods(quick: bool) -> Iterator[Problem]:
    """n rods at angles of their own, which fall on their ends at one instant.

    Newton's law with slip at the end: each sticks with P = −W⁻¹ (u + e u_n n), or slides
    with P_t = ∓µ P_n.
    """
    for count in (1, 4) if quick else (1, 4, 16):
        yield _falling(count)


def smooth_rods(quick: bool) -> Iterator[Problem]:
    """One rod on a smooth floor, P = (1 + e) m v/(1 + 3 cos² θ): what compliance tends to."""
    yield _falling(1, 0.0, "smooth rod")


def rods_along_the_path(quick: bool) -> Iterator[Problem]:
    """One rod under Stronge's law, whose slip stops on the way and may turn about (Routh)."""
    q, v = _start(1)
    robot = _rod()
    law = Law(restitution="stronge", slip="path")
    scene = Scene(robot, contacts=[_contact("rod", FRICTION)], law=law)

    def exact() -> np.ndarray:
        state = _in_long_numbers(q[0], v[0])
        return _after(state, _only(state, FRICTION, law))

    source = "Routh's construction in 50 digits"
    yield Problem("rod along its path", 1, scene, q[0], v[0], exact, source, ALONG_THE_PATH)


def _falling(count: int, friction: float = FRICTION, family: str = "falling rod") -> Problem:
    rod = _rod()
    robot = rod if count == 1 else combine({f"r{i:02d}": rod for i in range(count)})
    names = ["rod"] if count == 1 else [f"r{i:02d}/rod" for i in range(count)]
    q, v = _start(count)
    scene = Scene(robot, contacts=[_contact(name, friction) for name in names])

    def exact() -> np.ndarray:
        return np.concatenate(
            [_after(s, _only(s, friction, Law())) for s in map(_in_long_numbers, q, v)]
        )

    source = "closed form in 50 digits"
    return Problem(family, count, scene, q.ravel(), v.ravel(), exact, source)


def _rod() -> Robot:
    return one_body("rod", MASS, (1, 1, MASS * LENGTH**2 / 12), root="planar")


def _contact(frame: str, friction: float) -> Contact:
    end = [-LENGTH / 2, 0.0, 0.0]
    return Contact(frame, at=end, normal=[0, 1, 0], restitution=RESTITUTION, friction=friction)


def _start(count: int) -> tuple[np.ndarray, np.ndarray]:
    """(n, 4) x, y, cosine and sine; (n, 3) velocities in the rods' own axes."""
    half = (np.arange(count) + 1.5) / (2.0 * count + 2.0)  # tan(α/2), α between 0 and 90°
    cosine, sine = (1 - half**2) / (1 + half**2), 2 * half / (1 + half**2)
    q = np.stack([0.1 * np.arange(count), sine * LENGTH / 2, cosine, sine], axis=1)
    along = np.linspace(0.3, 6.0, count) if count > 1 else np.array([0.3])
    x, y = along, np.full(count, -2.0)
    return q, np.stack([cosine * x + sine * y, cosine * y - sine * x, np.zeros(count)], axis=1)


def _number(value: float) -> Any:
    return truth_numbers().number(value)


def _in_long_numbers(q: np.ndarray, v: np.ndarray) -> tuple[Any, ...]:
    """Cosine, sine and the velocities in world axes."""
    c, s, a, b, rate = map(_number, (q[2], q[3], *v))
    return c, s, c * a - s * b, s * a + c * b, rate


def _contact_space(state: tuple[Any, ...]) -> tuple[Any, ...]:
    """W as tt, tn, nn, and the velocity t, n of the end that strikes."""
    c, s, x, y, rate = state
    arm_x, arm_y = -c * _number(LENGTH / 2), -s * _number(LENGTH / 2)
    mass, inertia = _number(MASS), _number(MASS * LENGTH**2 / 12)
    return (
        1 / mass + arm_y**2 / inertia,
        -arm_x * arm_y / inertia,
        1 / mass + arm_x**2 / inertia,
        x - rate * arm_y,
        y + rate * arm_x,
    )


def _only(state: tuple[Any, ...], friction: float, law: Law) -> Any:
    """P (t, n), the only one that the law allows."""
    mu, e = _number(friction), _number(RESTITUTION)
    (impulse,) = planar_impulses(_contact_space(state), e, mu, law.restitution, law.slip)
    return impulse


def _after(state: tuple[Any, ...], impulse: tuple[Any, Any]) -> np.ndarray:
    """(3,) velocities in the rod's own axes."""
    c, s, x, y, rate = state
    p_t, p_n = impulse
    x, y = x + p_t / _number(MASS), y + p_n / _number(MASS)
    half = _number(LENGTH / 2)
    rate = rate + (-c * half * p_n + s * half * p_t) / _number(MASS * LENGTH**2 / 12)
    return np.array([float(c * x + s * y), float(c * y - s * x), float(rate)])
