"""Sweeps of contacts: parallel normals, restitution, friction, grazing, stacks."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from benchmarks.truths.impacts import Impacts
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import AppliedImpulse, Contact, JointStop, Scene
from impulsekit.tolerances import NONZERO

from .bodies import Link, random_links, random_state, robot_of, tilted_contact, uneven_links
from .sweep import STATES, Case, Sweeps, decades

SWEEPS = Sweeps()

BOX = (0.4, 0.2, 0.1)


def falling(
    robot: Robot, rng: np.random.Generator, count: int = STATES, speed: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """States in which the root comes down."""
    q, v = random_state(robot, rng, count, 0.3 * speed)
    if robot.model.joints[1].shortname() == "JointModelFreeFlyer":
        # v is in the body's axes: q keeps the body upright but for a turn about z.
        angle = rng.uniform(-3, 3, count)
        q[:, 3:5] = 0.0
        q[:, 5], q[:, 6] = np.sin(angle / 2), np.cos(angle / 2)
        q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
        v[:, 2] -= speed
    return q, v


@SWEEPS.of("parallel-contacts", "angle between the normals [rad]", decades(-15, 0), 42)
def parallel(angle: float, rng: np.random.Generator) -> Case:
    """Contacts of one body whose normals are that near to each other, at points as near."""
    links = random_links(rng, int(rng.integers(1, 4)))
    robot = robot_of(links, "freeflyer")
    count = int(rng.integers(2, 4))
    mu = 0.0 if rng.random() < 0.6 else float(rng.uniform(0.1, 0.8))
    base = rng.uniform(-0.2, 0.2, 3)
    together = rng.random() < 0.5
    contacts = []
    for _ in range(count):
        tilt = angle * rng.normal(size=2)
        at = base + angle * rng.normal(size=3) if together else rng.uniform(-0.2, 0.2, 3)
        contacts.append(
            Contact(
                "link_0",
                at=at,
                normal=(tilt[0], tilt[1], 1.0),
                friction=mu,
                restitution=float(rng.choice([0.0, 0.5])),
            )
        )
    scene = Scene(robot, contacts=contacts)
    q, v = falling(robot, rng)
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of(
    "restitution",
    "restitution e",
    (
        0.0,
        *decades(-300, -100, 100),
        *decades(-16, -2, 2),
        0.5,
        *(1.0 - float(f"1e-{k}") for k in range(2, 17, 2)),
        1.0,
    ),
    40,
    logarithmic=False,
)
def restitution(e: float, rng: np.random.Generator) -> Case:
    """Trees that fall on one or two points, with that restitution."""
    return _landing(rng, e=e, mu=float(rng.choice([0.0, 0.2, 0.6])))


@SWEEPS.of(
    "friction",
    "friction µ",
    (0.0, NONZERO, 1e-16, 1e-12, 1e-8, 1e-4, 0.01, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
    56,
    logarithmic=False,
)
def friction(mu: float, rng: np.random.Generator) -> Case:
    """Trees that fall on one or two points, with that friction."""
    return _landing(rng, e=float(rng.choice([0.0, 0.3, 0.9])), mu=mu)


def _landing(rng: np.random.Generator, *, e: float, mu: float) -> Case:
    links = random_links(rng, int(rng.integers(1, 4)))
    robot = robot_of(links, "freeflyer")
    chosen = rng.choice(len(links), size=min(len(links), int(rng.integers(1, 3))), replace=False)
    e_t = float(rng.choice([0.0, 0.0, 0.5]))
    contacts: list[Contact | JointStop] = [
        tilted_contact(
            i, rng, restitution=e, friction=mu, tangential_restitution=e_t if mu else 0.0
        )
        for i in chosen.tolist()
    ]
    blows = []
    if rng.random() < 0.3:
        blows.append(AppliedImpulse("link_0", linear=rng.normal(size=3)))
    scene = Scene(robot, blows, contacts=contacts)
    q, v = falling(robot, rng)
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of("grazing", "speed of approach [m/s]", (*decades(-300, -50, 50), *decades(-20, 0)), 35)
def grazing(speed: float, rng: np.random.Generator) -> Case:
    """A box that slides along a plane at 1 m/s and meets it at that speed."""
    size = tuple(rng.uniform(0.1, 0.4, 3))
    links = [Link(-1, float(rng.uniform(0.5, 2)), size)]
    robot = robot_of(links, "freeflyer")
    q, v = falling(robot, rng)
    # Turning only about the upright axis through the contact leaves its approach as it is.
    v[:, :2] = rng.normal(size=(STATES, 2))
    v[:, 2] = -speed * rng.uniform(0.5, 2, STATES)
    v[:, 3:5] = 0.0
    corner = Contact(
        "link_0",
        at=(size[0] * rng.uniform(0, 1), size[1] * rng.uniform(-0.5, 0.5), -0.5 * size[2]),
        restitution=float(rng.choice([0.0, 0.5, 1.0])),
        friction=float(rng.choice([0.0, 0.2, 0.8])),
    )
    scene = Scene(robot, contacts=[corner])
    return Case(scene, q, v, Impacts(scene))


def corners(size: tuple[float, float, float], z: float) -> list[tuple[float, float, float]]:
    """Four corners of a box of ``bodies.Link``, its lower or upper face."""
    return [(x, y, z) for x in (0.0, size[0]) for y in (-0.5 * size[1], 0.5 * size[1])]


@SWEEPS.of("stacks", "boxes", (1.0, 2.0, 3.0, 4.0), 25, logarithmic=False)
def stack(count: float, rng: np.random.Generator) -> Case:
    """Boxes on each other, each on four corners with friction; redundant throughout."""
    n = int(count)
    box = robot_of([Link(-1, 1.0, BOX)], "freeflyer")
    names = [f"box{i}" for i in range(n)]
    parts: dict[str, Any] = dict.fromkeys(names, box)
    robot = box if n == 1 else combine(**parts)
    frames = ["link_0"] if n == 1 else [f"{name}/link_0" for name in names]
    mu, e = float(rng.uniform(0.1, 1.0)), float(rng.choice([0.0, 0.0, 0.3]))
    lower = corners(BOX, -0.5 * BOX[2])
    contacts = [Contact(frames[0], at=at, friction=mu, restitution=e) for at in lower]
    for below, above in itertools.pairwise(frames):
        contacts += [
            Contact(
                above,
                at=at,
                against=below,
                origin=(0.0, 0.0, 0.5 * BOX[2]),
                friction=mu,
                restitution=e,
            )
            for at in lower
        ]
    scene = Scene(robot, contacts=contacts)
    states = 2
    q = np.tile(robot.neutral(), (states, 1))
    for i in range(n):
        q[:, 7 * i + 2] = BOX[2] * (i + 0.5)
    v = 0.3 * rng.normal(size=(states, robot.nv))
    v[:, 2::6] -= 1.0
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of("one-joint", "friction µ", (0.0, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0), 65, logarithmic=False)
def one_joint(mu: float, rng: np.random.Generator) -> Case:
    """A pendulum or slider that meets a plane with friction: W has rank one."""
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    kind = str(rng.choice(["revolute", "prismatic"]))
    link = Link(-1, 1.0, (0.4, 0.1, 0.1), kind, tuple(axis), turn=tuple(rng.uniform(-1, 1, 3)))
    robot = robot_of([link], "fixed")
    contact = Contact(
        "link_0", at=rng.uniform(-0.4, 0.4, 3), friction=mu, restitution=float(rng.choice([0, 0.5]))
    )
    scene = Scene(robot, contacts=[contact])
    q, v = random_state(robot, rng, STATES)
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of("contact-mass-ratio", "mass of some links over that of others", decades(-12, 12, 2), 42)
def contact_mass_ratio(ratio: float, rng: np.random.Generator) -> Case:
    """Trees of very different masses on two points with friction, a joint at its stop."""
    links = uneven_links(ratio, rng, 2, 5)
    robot = robot_of(links, "freeflyer")
    last = len(links) - 1
    mu = float(rng.choice([0.0, 0.4]))
    contacts: list[Contact | JointStop] = [
        Contact("link_0", at=rng.uniform(-0.2, 0.2, 3), friction=mu),
        Contact(f"link_{last}", at=rng.uniform(-0.2, 0.2, 3), friction=mu, restitution=0.5),
    ]
    if links[last].joint != "continuous":
        contacts.append(JointStop(f"joint_{last}", lower=100.0, upper=200.0, restitution=0.3))
    scene = Scene(robot, contacts=contacts)
    q, v = falling(robot, rng)
    return Case(scene, q, v, Impacts(scene))
