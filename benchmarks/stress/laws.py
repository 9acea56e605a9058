"""Sweeps of every contact law, one contact in a plane: restitution, friction, Painlevé, grazing."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.truths.planar import PlanarImpacts
from impulsekit.scene import Contact, Law, Scene
from impulsekit.tolerances import NONZERO

from .bodies import Link, random_links, random_state, robot_of
from .sweep import STATES, Case, Sweeps, decades

SWEEPS = Sweeps()

# The thickness of a rod over its length.
THIN = 1e-3

LAWS = (
    Law("newton", "end"),
    Law("poisson", "end"),
    Law("newton", "path"),
    Law("poisson", "path"),
    Law("stronge", "path"),
)


def planar_landing(rng: np.random.Generator, law: Law, *, e: float, mu: float) -> Case:
    """A tree in the plane z = 0 whose point meets the ground y = 0."""
    links = [
        Link(**{**vars(link), "joint": "revolute"})
        for link in random_links(rng, int(rng.integers(1, 4)), planar=True)
    ]
    robot = robot_of(links, "planar")
    frame = f"link_{int(rng.integers(0, len(links)))}"
    at = (float(rng.uniform(-0.3, 0.3)), float(rng.uniform(-0.3, 0.3)), 0.0)
    contact = Contact(frame, at=at, normal=(0.0, 1.0, 0.0), restitution=e, friction=mu)
    scene = Scene(robot, contacts=[contact], law=law)
    q, v = random_state(robot, rng, STATES, 0.5)
    for i in range(STATES):
        # v is in the body's axes: q has the cosine and sine of its angle.
        c, s = q[i, 2], q[i, 3]
        v[i, 0] -= s
        v[i, 1] -= c
    return Case(scene, q, v, PlanarImpacts(scene))


def _law(rng: np.random.Generator) -> Law:
    return LAWS[int(rng.integers(0, len(LAWS)))]


@SWEEPS.of(
    "law-restitution",
    "restitution e",
    (
        0.0,
        NONZERO,
        *decades(-16, -2, 2),
        0.5,
        *(1.0 - float(f"1e-{k}") for k in range(2, 17, 2)),
        1.0,
    ),
    80,
    logarithmic=False,
)
def law_restitution(e: float, rng: np.random.Generator) -> Case:
    """Every law with that restitution."""
    return planar_landing(rng, _law(rng), e=e, mu=float(rng.choice([0.0, 0.2, 0.7])))


@SWEEPS.of(
    "law-friction",
    "friction µ",
    (0.0, NONZERO, 1e-16, 1e-8, 1e-4, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0),
    110,
    logarithmic=False,
)
def law_friction(mu: float, rng: np.random.Generator) -> Case:
    """Every law with that friction."""
    return planar_landing(rng, _law(rng), e=float(rng.choice([0.0, 0.5, 1.0])), mu=mu)


@SWEEPS.of(
    "painleve",
    "relative distance from the friction of Painlevé's jam",
    (*decades(-15, -1), 0.3),
    80,
)
def painleve(distance: float, rng: np.random.Generator) -> Case:
    """A rod whose friction is that near to the one at which it jams, below or above it."""
    law = _law(rng)
    length, mass = 1.0, 1.0
    # Mass centre half a length along x, thin: inertia m l²/12.
    rod = robot_of([Link(-1, mass, (length, THIN, THIN))], "planar")
    angle = float(rng.uniform(0.3, 1.3))
    # The lower end touches; r from the mass centre to it, W = 1/m + r x r / I.
    r_t, r_n = -0.5 * length * math.cos(angle), -0.5 * length * math.sin(angle)
    inertia = mass * (length**2 + THIN**2) / 12.0
    coupling, normal = -r_t * r_n / inertia, 1.0 / mass + r_t**2 / inertia
    critical = normal / abs(coupling)
    sign = 1.0 if rng.random() < 0.5 else -1.0
    mu = critical * (1.0 + sign * distance)
    contact = Contact(
        "link_0",
        normal=(0.0, 1.0, 0.0),
        friction=mu,
        restitution=float(rng.choice([0.0, 0.5])),
    )
    scene = Scene(rod, contacts=[contact], law=law)
    q = np.zeros((STATES, rod.nq))
    q[:, 2], q[:, 3] = math.cos(angle), math.sin(angle)
    v = np.zeros((STATES, 3))
    world = rng.normal(size=(STATES, 2))
    world[:, 1] = -np.abs(world[:, 1])
    c, s = math.cos(angle), math.sin(angle)
    v[:, 0], v[:, 1] = c * world[:, 0] + s * world[:, 1], -s * world[:, 0] + c * world[:, 1]
    v[:, 2] = 0.3 * rng.normal(size=STATES)
    return Case(scene, q, v, PlanarImpacts(scene))


@SWEEPS.of(
    "law-grazing", "speed of approach [m/s]", (*decades(-300, -50, 50), *decades(-20, 0, 2)), 75
)
def law_grazing(speed: float, rng: np.random.Generator) -> Case:
    """A body without spin that meets the ground at that speed, under every law."""
    law = _law(rng)
    size = (float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.1, 0.3)), 0.1)
    robot = robot_of([Link(-1, float(rng.uniform(0.5, 2.0)), size)], "planar")
    contact = Contact(
        "link_0",
        at=(float(rng.uniform(0, size[0])), -0.5 * size[1], 0.0),
        normal=(0.0, 1.0, 0.0),
        restitution=float(rng.choice([0.0, 0.5, 1.0])),
        friction=float(rng.choice([0.0, 0.3])),
    )
    scene = Scene(robot, contacts=[contact], law=law)
    q = np.tile(robot.neutral(), (STATES, 1))
    v = np.zeros((STATES, 3))
    v[:, 0] = rng.normal(size=STATES) * (0.0 if rng.random() < 0.5 else 1.0)
    v[:, 1] = -speed * rng.uniform(0.5, 2.0, STATES)
    return Case(scene, q, v, PlanarImpacts(scene))
