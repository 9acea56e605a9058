"""Struck chains, trees, closed linkages and example robots: exact fractions, or 50 digits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from benchmarks.truths.digits import DIGITS, velocity_after
from benchmarks.truths.maximal import impact_of_free_bodies
from impulsekit.chain import chain_urdf, pendulum_urdf
from impulsekit.checking.demands import constraint_rows, known_impulses
from impulsekit.checking.system import reference_robot
from impulsekit.reference import Arithmetic
from impulsekit.reference.whittaker import StruckChain, struck_chain, struck_pendulum
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, FrameAnchor, JointImpulse, PointAnchor, Scene

from .problem import Problem, drawn_state, exact_or_kept

IMPULSE = 5  # N s
# What a method may be off [relative]: 160 rods lose some three digits.
TOLERANCE = 1e-12
QUICK, WHOLE = (3, 10, 40), (3, 10, 20, 40, 80, 160)


def struck_chains(quick: bool) -> Iterator[Problem]:
    """Free chains of n rods of 1 kg and 1 m, struck across at one end."""
    for n in QUICK if quick else WHOLE:
        yield chain_problem(n)


def struck_pendulums(quick: bool) -> Iterator[Problem]:
    """The same with the far end on a pin."""
    for n in QUICK if quick else WHOLE:
        yield pendulum_problem(n)


def chain_problem(
    n: int, mass: float = 1.0, length: float = 1.0, impulse: float = IMPULSE
) -> Problem:
    """A free chain of n rods along x, struck towards +y at its end of greatest x."""
    robot = Robot.from_urdf(chain_urdf(n, mass, length), root="planar")
    blow = AppliedImpulse(f"link_{n}", linear=[0, impulse, 0], at=[length, 0, 0])

    def exact() -> np.ndarray:
        truth = struck_chain(n, mass, length, impulse)
        # The root is the far end: its velocity, then turns of each rod against the one before.
        return np.array([0.0, float(truth.point_velocities[-1]), *_joint_rates(truth)])

    source = "fractions (Whittaker, Analytical Dynamics, p. 175)"
    return _rods("struck chain", n, robot, blow, exact, source)


def pendulum_problem(
    n: int, mass: float = 1.0, length: float = 1.0, impulse: float = IMPULSE
) -> Problem:
    """A chain of n rods that hangs from a pin, struck towards +x at its lower end."""
    robot = Robot.from_urdf(pendulum_urdf(n, mass, length))
    blow = AppliedImpulse(f"link_{n}", linear=[impulse, 0, 0], at=[0, 0, -length])

    def exact() -> np.ndarray:
        # Towards +x is a negative turn about y.
        return -np.array(_joint_rates(struck_pendulum(n, mass, length, impulse)))

    source = "fractions (Chang & Huston 1995, example 2)"
    return _rods("struck pendulum", n, robot, blow, exact, source)


def _rods(
    family: str, n: int, robot: Robot, blow: AppliedImpulse, exact: Any, source: str
) -> Problem:
    scene, q, v = Scene(robot, [blow]), robot.neutral(), robot.velocity()
    return Problem(family, n, scene, q, v, exact, source, TOLERANCE)


def _joint_rates(truth: StruckChain) -> list[float]:
    """Rates of the joints from the far end: differences, as fractions, of the rods' rates."""
    rates = [*reversed(truth.link_rates)]
    before = [Fraction(0), *rates[:-1]]
    return [float(rate - above) for rate, above in zip(rates, before, strict=True)]


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


def random_trees(quick: bool) -> Iterator[Problem]:
    """Trees of 5 to 40 bodies on a free base."""
    for bodies in (5, 10) if quick else (5, 10, 20, 40):
        yield tree_problem(bodies)


def tree_problem(bodies: int, seed: int = 0) -> Problem:
    """A tree in a drawn state, struck on its last body, and kicked in its first joint."""
    robot = Robot.from_urdf(random_tree_urdf(bodies, seed), root="freeflyer")
    q, v = drawn_state(robot, seed + 1)
    struck = AppliedImpulse(
        f"body_{bodies - 1}", linear=[1.0, -2.0, 0.5], angular=[0.1, 0.0, -0.2], at=[0.1, 0.0, 0.2]
    )
    scene = Scene(robot, [struck, JointImpulse("joint_1", 0.5)])
    exact = exact_or_kept("random tree", bodies, scene, q, v, lambda: velocity_after(scene, q, v))
    return Problem("random tree", bodies, scene, q, v, exact, "Kane's equations in 50 digits")


def random_tree_urdf(bodies: int, seed: int = 0) -> str:
    """Bodies of 0.1 to 10 kg on revolute, continuous and prismatic joints along skew axes.

    Each hangs on one of the three before it, so trees branch and get deep.
    """
    rng = np.random.default_rng(1000 * seed + bodies)
    lines = [f'<robot name="tree_{bodies}">', _body(0, rng)]
    for k in range(1, bodies):
        kind = ("revolute", "revolute", "continuous", "prismatic")[int(rng.integers(4))]
        parent = int(rng.integers(max(0, k - 3), k))
        axis, place, turn = (_words(rng.uniform(-1.0, 1.0, 3)) for _ in range(3))
        lines.append(_body(k, rng))
        lines.append(
            f'<joint name="joint_{k}" type="{kind}"><parent link="body_{parent}"/>'
            f'<child link="body_{k}"/><origin xyz="{place}" rpy="{turn}"/><axis xyz="{axis}"/>'
            '<limit lower="-100" upper="100" effort="1" velocity="1"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


def _body(k: int, rng: np.random.Generator) -> str:
    mass = 10.0 ** round(float(rng.uniform(-1.0, 1.0)), 0) * float(rng.uniform(0.5, 2.0))
    # The moments of a box: no two of them can be less than the third.
    x, y, z = rng.uniform(0.1, 0.5, 3) ** 2
    ixx, iyy, izz = (round(mass / 12.0 * float(s), 9) for s in (y + z, x + z, x + y))
    return (
        f'<link name="body_{k}"><inertial><origin xyz="{_words(rng.uniform(-0.2, 0.2, 3))}" '
        f'rpy="{_words(rng.uniform(-1.0, 1.0, 3))}"/><mass value="{round(mass, 6)!r}"/>'
        f'<inertia ixx="{ixx!r}" iyy="{iyy!r}" izz="{izz!r}" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )


def _words(values: np.ndarray) -> str:
    """Three numbers in few decimals."""
    return " ".join(repr(round(float(value), 4)) for value in values)


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
