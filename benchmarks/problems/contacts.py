"""Balls, blocks, feet and rods that strike: closed forms, or Coulomb's law in 50 digits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.truths.digits import velocity_after
from benchmarks.truths.numbers import truth_numbers
from benchmarks.truths.planar import planar_impulses
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import Contact, Law, Scene

from ..urdf import joint_text, link_text, one_body, robot_text
from .problem import Problem, drawn_state, exact_or_kept

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


# Half width and half height [m].
WIDE, HIGH = 0.125, 0.25
MASS = 4.0  # kg


def rocking_blocks(quick: bool) -> Iterator[Problem]:
    """A block that rocks over from one edge to the other, in the plane and in space.

    It keeps (2 h² − b²)/(2 (h² + b²)) of its rate (Housner 1963). The size is the number
    of corners.
    """
    rate = (2 * HIGH**2 - WIDE**2) / (2 * (HIGH**2 + WIDE**2))
    flat = _block("planar")
    corners = [
        Contact("block", at=[x, -HIGH, 0], normal=[0, 1, 0], friction=2.0) for x in (-WIDE, WIDE)
    ]
    v = np.array([-HIGH, -WIDE, 1.0])  # about the edge on the right, which rests
    after = np.array([-HIGH * rate, WIDE * rate, rate])
    yield Problem(
        "rocking block",
        2,
        Scene(flat, contacts=corners),
        flat.configuration(root_joint=[0, HIGH, 1, 0]),
        v,
        lambda: after,
        "Housner 1963",
    )
    block = _block("freeflyer")
    corners = [
        Contact("block", at=[x, y, -HIGH], friction=2.0) for x in (-WIDE, WIDE) for y in (-0.2, 0.2)
    ]
    turned = np.array([-HIGH * rate, 0, WIDE * rate, 0, -rate, 0])
    yield Problem(
        "rocking block",
        4,
        Scene(block, contacts=corners),
        block.configuration(root_joint=[0, 0, HIGH, 0, 0, 0, 1]),
        np.array([-HIGH, 0, -WIDE, 0, -1.0, 0]),
        lambda: turned,
        "Housner 1963",
    )


def landing_blocks(quick: bool) -> Iterator[Problem]:
    """A block that slides as it lands flat on a ring of n points, whose rows have rank six.

    v_n⁺ = −e v_n and |v_t⁺| = |v_t| − µ (1 + e) |v_n|, whatever the points' share.
    """
    e, mu, down = 0.5, 0.25, 1.0
    along = np.array([1.5, 2.0])  # 2.5 m/s
    left = 1.0 - mu * (1.0 + e) * down / 2.5
    for points in (4, 16) if quick else (4, 8, 16, 32):
        block = _block("freeflyer")
        angles = 2.0 * np.pi * (np.arange(points) + 0.5) / points
        ring = [[np.cos(angle), np.sin(angle), -HIGH] for angle in angles]
        contacts = [Contact("block", at=at, restitution=e, friction=mu) for at in ring]
        yield Problem(
            "landing block",
            points,
            Scene(block, contacts=contacts),
            block.configuration(root_joint=[0, 0, HIGH, 0, 0, 0, 1]),
            np.array([*along, -down, 0, 0, 0]),
            lambda: np.array([*(left * along), e * down, 0, 0, 0]),
            "Coulomb's law on the whole block",
        )


def _block(root: str) -> Robot:
    """As wide along y, where it does not turn, as along x."""
    across = MASS * (WIDE**2 + HIGH**2) / 3.0
    upright = 2.0 * MASS * WIDE**2 / 3.0
    # In the plane it turns about z.
    about_z = across if root == "planar" else upright
    return one_body("block", MASS, (across, across, about_z), root=root)


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


ROD_MASS, LENGTH = 2.0, 1.0  # kg, m
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
    return one_body("rod", ROD_MASS, (1, 1, ROD_MASS * LENGTH**2 / 12), root="planar")


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
    mass, inertia = _number(ROD_MASS), _number(ROD_MASS * LENGTH**2 / 12)
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
    x, y = x + p_t / _number(ROD_MASS), y + p_n / _number(ROD_MASS)
    half = _number(LENGTH / 2)
    rate = rate + (-c * half * p_n + s * half * p_t) / _number(ROD_MASS * LENGTH**2 / 12)
    return np.array([float(c * x + s * y), float(c * y - s * x), float(rate)])
