"""Sweeps of contacts one after the other, and of slip that turns along the path."""

from __future__ import annotations

import itertools

import numpy as np

from impulsekit.robot import Robot
from impulsekit.scene import Contact, JointImpulse, Law, Scene
from impulsekit.tolerances import NONZERO

from .bodies import Link, random_links, random_state, robot_of, tilted_contact, tree_urdf
from .strikes import Strikes
from .sweep import STATES, Case, Sweeps, decades
from .touched import falling

SWEEPS = Sweeps()

RADIUS = 0.25
ENDS = (Law("newton", "end"), Law("poisson", "end"))
PATHS = (Law("newton", "path"), Law("poisson", "path"), Law("stronge", "path"))


def _in_sequence(law: Law) -> Law:
    return Law(law.restitution, law.slip, "sequential")


@SWEEPS.of(
    "sequence-balls",
    "mass of a ball over that of the one before, or the other way",
    (0.1, 0.2, 0.3, 0.5, 0.9, 1.0, 1.0 + 1e-8, 1.1, 2.0, 3.0, 5.0, 10.0),
    35,
)
def balls_in_a_row(ratio: float, rng: np.random.Generator) -> Case:
    """Balls on a rail, each that much heavier or lighter than the one before, in sequence."""
    count = int(rng.integers(2, 6))
    masses = [1.0]
    for _ in range(count - 1):
        masses.append(masses[-1] * (ratio if rng.random() < 0.5 else 1.0 / ratio))
    cradle = rng.random() < 0.3
    if cradle:
        masses = [1.0] * count
    links = [
        Link(-1, mass, (2 * RADIUS,) * 3, "prismatic", (1.0, 0.0, 0.0), (2 * RADIUS * i, 0.0, 0.0))
        for i, mass in enumerate(masses)
    ]
    robot = Robot.from_urdf(tree_urdf(links, base=True))
    e = float(rng.choice([0.0, 0.3, 0.9, 1.0]))
    contacts = [
        Contact(
            f"link_{right}",
            normal=(1.0, 0.0, 0.0),
            origin=(2 * RADIUS, 0.0, 0.0),
            against=f"link_{left}",
            restitution=e,
        )
        for left, right in itertools.pairwise(range(count))
    ]
    law = _in_sequence((*ENDS, *PATHS)[int(rng.integers(0, 5))])
    blows = [JointImpulse("joint_0", float(rng.uniform(0.5, 2)))] if rng.random() < 0.3 else []
    scene = Scene(robot, blows, contacts=contacts, law=law)
    v = np.zeros((STATES, count))
    coming = int(rng.integers(1, count))
    v[:, :coming] = 1.0 if cradle else rng.uniform(0.5, 2.0, (STATES, coming))
    if not cradle and rng.random() < 0.5:
        v[:, coming:] = -rng.uniform(0.0, 1.0, (STATES, count - coming))
    q = np.zeros((STATES, robot.nq))
    return Case(scene, q, v, Strikes(scene))


def _fall(rng: np.random.Generator, law: Law, points: int, *, e: float, mu: float) -> Case:
    links = random_links(rng, int(rng.integers(1, 4)))
    robot = robot_of(links, "freeflyer")
    contacts = [
        tilted_contact(int(rng.integers(0, len(links))), rng, restitution=e, friction=mu)
        for _ in range(points)
    ]
    scene = Scene(robot, contacts=contacts, law=law)
    q, v = falling(robot, rng, 3)
    return Case(scene, q, v, Strikes(scene))


@SWEEPS.of(
    "sequence-friction",
    "friction µ",
    (0.0, NONZERO, 1e-8, 0.01, 0.1, 0.3, 0.6, 1.0, 3.0, 10.0),
    40,
    logarithmic=False,
)
def rough_sequence(mu: float, rng: np.random.Generator) -> Case:
    """A tree that falls on two or three points with that friction, one after the other."""
    law = _in_sequence(ENDS[int(rng.integers(0, 2))])
    e = float(rng.choice([0.0, 0.3, 0.8]))
    return _fall(rng, law, int(rng.integers(2, 4)), e=e, mu=mu)


@SWEEPS.of(
    "turning-slip",
    "friction µ",
    (1e-8, 1e-4, 0.01, 0.1, 0.3, 0.6, 1.0, 3.0, 10.0),
    50,
    logarithmic=False,
)
def turning_slip(mu: float, rng: np.random.Generator) -> Case:
    """A tree that falls on one point with that friction: slip turns along the path."""
    law = PATHS[int(rng.integers(0, 3))]
    return _fall(rng, law, 1, e=float(rng.choice([0.0, 0.5, 1.0])), mu=mu)


@SWEEPS.of("slow-slip", "speed along the plane [m/s]", (*decades(-16, 4, 2),), 40)
def slow_slip(speed: float, rng: np.random.Generator) -> Case:
    """A box that meets a plane at 1 m/s and slides along it at that speed, along the path."""
    size = tuple(rng.uniform(0.1, 0.4, 3))
    robot = robot_of([Link(-1, float(rng.uniform(0.5, 2)), size)], "freeflyer")
    q, v = random_state(robot, rng, 3, 0.3)
    v[:, :3] = speed * rng.normal(size=(3, 3))
    v[:, 3:] = 0.0
    q[:, 3:7] = 0.0
    q[:, 6] = 1.0
    v[:, 2] = -rng.uniform(0.5, 2, 3)
    contact = Contact(
        "link_0",
        at=(size[0] * rng.uniform(0, 1), size[1] * rng.uniform(-0.5, 0.5), -0.5 * size[2]),
        restitution=float(rng.choice([0.0, 0.5, 1.0])),
        friction=float(rng.choice([0.1, 0.3, 0.8])),
    )
    scene = Scene(robot, contacts=[contact], law=PATHS[int(rng.integers(0, 3))])
    return Case(scene, q, v, Strikes(scene))
