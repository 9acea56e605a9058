"""Sweeps of bilateral rows: redundant by the hundred, nearly dependent, singular."""

from __future__ import annotations

import numpy as np

from benchmarks.truths.impacts import Impacts
from impulsekit.scene import (
    AppliedImpulse,
    FrameAnchor,
    JointCoupling,
    JointLock,
    PointAnchor,
    Scene,
)

from .bodies import Link, random_links, random_state, robot_of, uneven_links
from .sweep import STATES, Case, Sweeps, decades

SWEEPS = Sweeps()


@SWEEPS.of("stretched-arm", "angle from the stretched arm [rad]", (*decades(-16, 0), 0.0), 42)
def stretched(angle: float, rng: np.random.Generator) -> Case:
    """An arm held at its tip, stretched out but for an angle: the rows lose rank."""
    count = int(rng.integers(2, 5))
    links = [
        Link(k - 1, 1.0, (0.3, 0.04, 0.05), "revolute", (0.0, 0.0, 1.0), (0.3 * bool(k), 0.0, 0.0))
        for k in range(count)
    ]
    robot = robot_of(links, "fixed")
    q = angle * rng.uniform(0.5, 2.0, (STATES, robot.nv)) * rng.choice([-1, 1], (STATES, robot.nv))
    q[:, 0] = rng.uniform(-3, 3, STATES)
    tip = f"link_{count - 1}"
    blow = AppliedImpulse("link_0", linear=rng.normal(size=3), at=(0.15, 0.1, 0.0))
    anchor = PointAnchor(tip, at=(0.3, 0.0, 0.0))
    scene = Scene(robot, [blow], constraints=[anchor])
    v = np.zeros((STATES, robot.nv))
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of(
    "redundant-rows", "pins, of three rows each", (2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 100.0), 8
)
def redundant(count: float, rng: np.random.Generator) -> Case:
    """A body pinned at so many points: three rows each, of which six are independent."""
    links = random_links(rng, 2)
    robot = robot_of(links, "freeflyer")
    anchors = [PointAnchor("link_0", at=rng.uniform(-0.3, 0.3, 3)) for _ in range(int(count))]
    blow = AppliedImpulse("link_1", linear=rng.normal(size=3), at=rng.uniform(-0.3, 0.3, 3))
    scene = Scene(robot, [blow], constraints=anchors)
    states = STATES if count <= 8 else 2
    q, v = random_state(robot, rng, states)
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of("close-pins", "distance of the pins [m]", decades(-14, 0), 42)
def close_points(distance: float, rng: np.random.Generator) -> Case:
    """A body pinned at two points that close to each other."""
    links = random_links(rng, int(rng.integers(1, 4)))
    robot = robot_of(links, "freeflyer")
    at = rng.uniform(-0.2, 0.2, 3)
    apart = rng.normal(size=3)
    apart *= distance / np.linalg.norm(apart)
    anchors = [PointAnchor("link_0", at=at), PointAnchor("link_0", at=at + apart)]
    blow = AppliedImpulse("link_0", linear=rng.normal(size=3), at=rng.uniform(-0.3, 0.3, 3))
    scene = Scene(robot, [blow], constraints=anchors)
    q, v = random_state(robot, rng, STATES)
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of("held-mass-ratio", "mass of some links over that of others", decades(-12, 12, 2), 75)
def held_mass_ratio(ratio: float, rng: np.random.Generator) -> Case:
    """A tree of very different masses, gripped, locked and geared."""
    links = uneven_links(ratio, rng, 3, 6)
    robot = robot_of(links, str(rng.choice(["planar", "freeflyer"])))
    last = len(links) - 1
    constraints: list[PointAnchor | FrameAnchor | JointLock | JointCoupling] = []
    kind = int(rng.integers(0, 4))
    if kind == 0:
        constraints.append(PointAnchor(f"link_{last}", at=rng.uniform(-0.2, 0.2, 3)))
    elif kind == 1:
        constraints.append(FrameAnchor(f"link_{last}", directions=("x", "y", "rz")))
    elif kind == 2:
        constraints.append(JointLock(f"joint_{last}"))
        constraints.append(PointAnchor("link_0", at=(0.1, 0.0, 0.0)))
    else:
        constraints.append(JointCoupling(f"joint_{last}", f"joint_{last - 1}", ratio=-1.5))
    blow = AppliedImpulse("link_0", linear=rng.normal(size=3), at=rng.uniform(-0.3, 0.3, 3))
    scene = Scene(robot, [blow], constraints=constraints)
    q, v = random_state(robot, rng, STATES)
    return Case(scene, q, v, Impacts(scene))


@SWEEPS.of("far-grip", "distance of the root from the world's origin [m]", decades(0, 12, 2), 100)
def far_grip(distance: float, rng: np.random.Generator) -> Case:
    """Two links of a tree pinned to each other, that far from the world's origin."""
    links = random_links(rng, 4)
    robot = robot_of(links, "freeflyer")
    q, v = random_state(robot, rng, STATES)
    away = rng.normal(size=(STATES, 3))
    q[:, :3] = distance * away / np.linalg.norm(away, axis=1, keepdims=True)
    given = tuple(rng.uniform(-0.2, 0.2, 3)) if rng.random() < 0.5 else None
    grip = PointAnchor("link_3", "link_0", at=rng.uniform(-0.2, 0.2, 3), other_at=given)
    blow = AppliedImpulse("link_1", linear=rng.normal(size=3))
    scene = Scene(robot, [blow], constraints=[grip])
    return Case(scene, q, v, Impacts(scene))
