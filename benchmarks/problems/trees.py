"""Random trees of rigid bodies, struck at a leaf: Kane's equations in 50 digits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, JointImpulse, Scene
from tests.truths.digits import velocity_after

from .kept import exact_or_kept
from .problem import Problem
from .states import drawn_state

__all__ = ["random_tree_urdf", "random_trees", "tree_problem"]


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
