"""Random scenes of one to three example robots, against Kane's equations and what laws say."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pinocchio as pin

from impulsekit.checking import check
from impulsekit.errors import ImpulsekitError
from impulsekit.impact import Impact, solve
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import AppliedImpulse, Contact, JointLock, Law, PointAnchor, Scene
from impulsekit.scene.coefficients import static_friction

from .sweep import Point, Sweeps, seen

ROBOTS = ("double_pendulum", "ur5", "panda", "solo12", "anymal", "allegro_right_hand")
LAWS = [
    Law(restitution=restitution, slip=slip, order=order)
    for restitution in ("newton", "poisson")
    for slip in ("end", "path")
    for order in ("simultaneous", "sequential")
    if not (slip == "path" and order == "simultaneous")
]
SWEEPS = Sweeps()
# Of velocities, over the largest of them.
EXACT = 1e-9
# Loads and energies that residuals are over are at least this [N s, J], and speeds this [m/s].
NO_LOAD, SLOWEST = 1e-12, 1e-3


def random_scene(rng: np.random.Generator, law: Law) -> Scene:
    """Blows, a pin, a lock and up to two contacts on robots side by side."""
    names = rng.choice(ROBOTS, int(rng.integers(1, 4)))
    robot = combine(
        {
            f"r{k}": Robot.from_example(
                str(name), root="freeflyer" if rng.random() < 0.5 else "fixed"
            )
            for k, name in enumerate(names)
        },
        placements={f"r{k}": rng.normal(size=3) for k in range(len(names))},
    )
    links = [link.name for link in robot.links if link.joint_id > 0 and link.mass > 0.0]

    def link() -> str:
        return str(rng.choice(links))

    blows = [
        AppliedImpulse(link(), linear=rng.normal(size=3), at=0.1 * rng.normal(size=3))
        for _ in range(int(rng.integers(0, 3)))
    ]
    holds: list[Any] = []
    if rng.random() < 0.4:
        holds.append(PointAnchor(link(), at=0.1 * rng.normal(size=3)))
    if rng.random() < 0.4:
        joint = str(rng.choice([n for n in robot.joint_names if "root" not in n]))
        holds.append(JointLock(joint))
    contacts = []
    for k in range(int(rng.integers(0, 3))):
        normal = rng.normal(size=3)
        contacts.append(
            Contact(
                link(),
                at=0.1 * rng.normal(size=3),
                normal=normal / np.linalg.norm(normal),
                restitution=float(rng.uniform(0.0, 1.0)),
                friction=float(rng.choice([0.0, 0.3, 1.0])),
                name=f"contact {k}",
            )
        )
    return Scene(robot, blows, holds, contacts, law=law)


def breach_of_law(impact: Impact) -> float:
    """What an answer leaves of what every law says, out of velocities at the points; relative."""
    speeds = [SLOWEST]
    for found in impact.contacts:
        speeds += [float(np.abs(x).max()) for x in (found.velocity_before, found.velocity_after)]
    scale = max(speeds)
    load = max([NO_LOAD] + [float(np.abs(found.impulse).max()) for found in impact.contacts])
    left = 0.0
    for entry, found in zip(impact.scene.contacts, impact.contacts, strict=True):
        normal = np.array(entry.normal)  # type: ignore[union-attr]
        friction = static_friction(entry.friction)  # type: ignore[union-attr]
        pressed = float(normal @ found.impulse)
        rubbed = float(np.linalg.norm(found.impulse - pressed * normal))
        closing = -float(normal @ found.velocity_after) / scale
        left = max(left, -pressed / load, (rubbed - friction * pressed) / load, closing)
    # Impulses work on the mean of the velocities before and after, and nothing else does.
    energy = impact.energy
    size = max(energy.before, energy.after, *map(abs, energy.work.values()), NO_LOAD)
    return max(left, abs(energy.change - sum(energy.work.values())) / size)


@SWEEPS.of("robots", "law", tuple(map(float, range(len(LAWS)))), 1700, logarithmic=False)
def robot_points(value: float, rng: np.random.Generator) -> list[Point]:
    """One to three example robots with all entries: against Kane's equations and what laws say."""
    scene = random_scene(rng, LAWS[int(value)])
    model = scene.robot.model
    q = pin.integrate(model, scene.robot.neutral(), rng.uniform(-1.0, 1.0, model.nv))
    v = rng.normal(size=model.nv)
    start, left = time.perf_counter(), math.nan
    try:
        impact = solve(scene, q, v)
        status, verdict = impact.status.name, "said so"
        seconds = time.perf_counter() - start
        if impact.is_valid():
            left = breach_of_law(impact)
            verdict = "right" if left <= EXACT and check(impact).agrees else "wrong"
    except ImpulsekitError as error:
        status, verdict = type(error).__name__, "said so"
        seconds = time.perf_counter() - start
    return [seen(0, "solve", status, verdict, seconds, error=left)]
