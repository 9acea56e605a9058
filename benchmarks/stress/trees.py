"""Sweeps of struck trees: masses, inertias, lengths, distances, impulses, sizes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from benchmarks.truths.impacts import Impacts
from impulsekit.robot import Robot
from impulsekit.scene import AppliedImpulse, JointImpulse, Scene

from .bodies import Link, random_links, random_state, robot_of
from .sweep import STATES, Case, Sweeps, decades

SWEEPS = Sweeps()

ROOTS = ("fixed", "planar", "freeflyer")
EXAMPLES = (
    "double_pendulum",
    "ur5",
    "panda",
    "solo12",
    "anymal",
    "allegro_right_hand",
    "tiago",
    "icub",
    "talos",
)


def blow_on(robot: Robot, links: list[Link], rng: np.random.Generator) -> Scene:
    """A tree struck at a random point of a random link, at times with a kick in a joint."""
    struck = int(rng.integers(0, len(links)))
    blow = AppliedImpulse(
        f"link_{struck}",
        linear=rng.normal(size=3),
        angular=0.3 * rng.normal(size=3),
        at=rng.uniform(-0.3, 0.3, 3),
        axes=str(rng.choice(["world", "local"])),
    )
    impulses: list[AppliedImpulse | JointImpulse] = [blow]
    if len(links) > 1 and rng.random() < 0.3:
        impulses.append(JointImpulse(f"joint_{len(links) - 1}", float(rng.normal())))
    return Scene(robot, impulses)


def struck(links: list[Link], rng: np.random.Generator, *, far: float = 0.0) -> Case:
    """A tree struck at random states, its root at a distance."""
    roots = ROOTS if not far else ROOTS[1:]
    root = str(rng.choice(roots))
    robot = robot_of(links, root)
    q, v = random_state(robot, rng, STATES)
    if far:
        free = 2 if root == "planar" else 3
        away = rng.normal(size=(STATES, free))
        q[:, :free] = far * away / np.linalg.norm(away, axis=1, keepdims=True)
    scene = blow_on(robot, links, rng)
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of("mass-ratio", "mass of some links over that of others", decades(-12, 12, 2), 115)
def mass_ratio(ratio: float, rng: np.random.Generator) -> Case:
    """One or more links of a tree are so much heavier than the others."""
    links = random_links(rng, int(rng.integers(2, 6)))
    heavy = rng.random(len(links)) < 0.4
    heavy[int(rng.integers(0, len(links)))] = True
    changed = [
        replace(k, mass=k.mass * ratio) if h else k for k, h in zip(links, heavy, strict=True)
    ]
    return struck(changed, rng)


@SWEEPS.of(
    "inertia", "inertia about the mass centre over that of a solid box", decades(-12, 0, 2), 115
)
def small_inertia(factor: float, rng: np.random.Generator) -> Case:
    """Links whose inertia about their mass centre is so much smaller than a box's."""
    links = random_links(rng, int(rng.integers(1, 5)))
    thin = rng.random(len(links)) < 0.6
    thin[int(rng.integers(0, len(links)))] = True
    changed = [
        replace(k, inertia_scale=factor) if t else k for k, t in zip(links, thin, strict=True)
    ]
    return struck(changed, rng)


@SWEEPS.of("length-ratio", "length of some links over that of others", decades(-9, 9, 3), 75)
def length_ratio(ratio: float, rng: np.random.Generator) -> Case:
    """Links of very different sizes, their masses alike."""
    links = random_links(rng, int(rng.integers(2, 5)))
    changed = []
    for k in links:
        factor = ratio if rng.random() < 0.5 else 1.0
        changed.append(replace(k, size=_times(factor, k.size), offset=_times(factor, k.offset)))
    return struck(changed, rng)


def _times(factor: float, vector: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = vector
    return factor * x, factor * y, factor * z


@SWEEPS.of(
    "singularity", "angle from the singular configuration [rad]", (*decades(-16, 0, 2), 0.0), 75
)
def singularity(angle: float, rng: np.random.Generator) -> Case:
    """An arm stretched out but for an angle, or a wrist whose axes nearly coincide."""
    count = int(rng.integers(2, 6))
    wrist = rng.random() < 0.5
    links = []
    for k in range(count):
        axis = (0.0, 0.0, 1.0) if not wrist or k % 2 == 0 else (1.0, 0.0, 0.0)
        offset = (0.3 if k and not wrist else 0.0, 0.0, 0.0)
        links.append(Link(k - 1, 1.0, (0.3, 0.04, 0.05), "revolute", axis, offset))
    robot = robot_of(links, "fixed")
    q = angle * rng.choice([-1.0, 1.0], (STATES, robot.nv))
    q[:, 0] = rng.uniform(-3, 3, STATES)
    scene = blow_on(robot, links, rng)
    return Case(scene, q, rng.normal(size=q.shape), Impacts(scene))


@SWEEPS.of("far-base", "distance of the root from the world's origin [m]", decades(0, 12, 2), 130)
def far_base(distance: float, rng: np.random.Generator) -> Case:
    """A floating tree that far from the world's origin."""
    return struck(random_links(rng, int(rng.integers(1, 5))), rng, far=distance)


@SWEEPS.of(
    "impulse",
    "size of the blow [N s]",
    (*decades(-320, -300, 4), *decades(-250, 250, 50), 1e290, 1e300),
    40,
)
def impulse_size(size: float, rng: np.random.Generator) -> Case:
    """A blow of that size."""
    links = random_links(rng, int(rng.integers(1, 4)))
    robot = robot_of(links, str(rng.choice(ROOTS)))
    q, _ = random_state(robot, rng, STATES)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    blow = AppliedImpulse(
        f"link_{len(links) - 1}",
        linear=size * direction,
        angular=0.1 * size * rng.uniform(-1, 1, 3),
        at=rng.uniform(-0.3, 0.3, 3),
    )
    scene = Scene(robot, [blow])
    return Case(scene, q, np.zeros((STATES, robot.nv)), Impacts(scene))


@SWEEPS.of(
    "armature",
    "armature of joints over the inertia that they move, from 1 to",
    decades(-6, 6, 2),
    30,
)
def geared_tree(spread: float, rng: np.random.Generator) -> Case:
    """A struck tree whose joints have armature, as every MJCF gives them."""
    case = struck(random_links(rng, int(rng.integers(2, 9))), rng)
    robot = case.scene.robot
    model = pin.Model(robot.model)
    moved = np.diagonal(
        pin.crba(model, model.createData(), pin.neutral(model)).reshape(model.nv, -1)
    )
    geared = np.arange(model.nv) >= (0 if model.names[1] != "root_joint" else model.nvs[1])
    shares = spread ** rng.uniform(0.0, 1.0, model.nv) * geared * (rng.random(model.nv) < 0.8)
    model.armature = shares * moved
    scene = Scene(Robot(model, robot.parts, robot.name), case.scene.impulses)
    return Case(scene, case.q, case.v, Impacts(scene))


@SWEEPS.of(
    "random-trees",
    "links",
    tuple(float(n) for n in (1, 2, 3, 4, 6, 8, 12, 16, 24)),
    60,
    logarithmic=False,
)
def random_tree(count: float, rng: np.random.Generator) -> Case:
    """Trees of that many links at random states."""
    return struck(random_links(rng, int(count)), rng)


@SWEEPS.of(
    "example-robots",
    "robot: " + ", ".join(EXAMPLES),
    tuple(float(i) for i in range(len(EXAMPLES))),
    8,
    logarithmic=False,
)
def example_robot(index: float, rng: np.random.Generator) -> Case:
    """A robot of example-robot-data, struck at a random link."""
    name = EXAMPLES[int(index)]
    root = "freeflyer" if rng.random() < 0.5 else "fixed"
    robot = Robot.from_example(name, root=root)
    moving = [
        link.name
        for link in robot.links
        if robot.model.frames[robot.frame_id(link.name)].parentJoint > 0
    ]
    blow = AppliedImpulse(
        str(rng.choice(moving)), linear=rng.normal(size=3), at=0.1 * rng.normal(size=3)
    )
    scene = Scene(robot, [blow])
    q, v = random_state(robot, rng, 2)
    return Case(scene, q, v, Impacts(scene))
