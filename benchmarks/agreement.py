"""Batches beside ``solve`` on all example robots: ``python -m benchmarks.agreement [ROWS]``."""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np

from impulsekit.batch.solve import solve_batch
from impulsekit.errors import SingularMassError, UrdfError
from impulsekit.impact import solve
from impulsekit.laws.status import Status
from impulsekit.robot import Robot
from impulsekit.robot.base import WORLD
from impulsekit.robot.examples import example_names
from impulsekit.scene import AppliedImpulse, Contact, JointImpulse, Scene
from tests.truths.digits import velocity_after

from .stress.bodies import random_state

BAR = 1e-12
KINDS = ("blows", "contact")


@dataclass(frozen=True)
class Agreement:
    """How far a batch is from ``solve``.

    Attributes:
        rows: how many were compared.
        worst: the largest difference of v⁺ of a row that is valid, relative to its speeds
            before and to the jump; where it is above the bar, by how much the batch is
            further from the answer in 50 digits.
        harder: how many rows were held against 50 digits.
        statuses: how many rows have another status.
    """

    rows: int
    worst: float
    harder: int
    statuses: int


def loaded_robot(name: str) -> Robot | None:
    """The example robot; None where it cannot be loaded."""
    try:
        robot = Robot.from_example(name)
        # Arms stand; what has no joints of its own, and every second other one, flies.
        if robot.nv < 2 or example_names().index(name) % 2:
            robot = Robot.from_example(name, root="freeflyer")
    except UrdfError:
        return None
    return robot


def random_scene(robot: Robot, kind: str, rng: np.random.Generator) -> Scene:
    """A random scene: "blows", or "contact" for a foot with friction under a blow."""
    frames = [one.name for one in robot.links if one.joint_id > 0 and one.name != WORLD]

    def frame() -> str:
        return str(rng.choice(frames))

    joint = str(rng.choice(robot.joint_names))
    size = robot.model.joints[robot.joint_id(joint)].nv
    blow = AppliedImpulse(
        frame(), rng.normal(size=3), rng.normal(size=3), at=0.1 * rng.normal(size=3)
    )
    if kind == "blows":
        local = AppliedImpulse(frame(), rng.normal(size=3), axes="local")
        return Scene(robot, [blow, local, JointImpulse(joint, tuple(rng.normal(size=size)))])
    foot = Contact(
        frame(),
        at=0.1 * rng.normal(size=3),
        normal=tuple(rng.normal(size=3)),
        friction=float(rng.uniform(0.0, 1.0)),
        restitution=float(rng.uniform(0.0, 1.0)),
    )
    return Scene(robot, [blow], contacts=[foot])


def agreement(scene: Scene, q: np.ndarray, v: np.ndarray) -> Agreement:
    """Solve the rows both ways."""
    batch = solve_batch(scene, q, v)
    worst, harder, statuses = 0.0, 0, 0
    for i, (pose, speed) in enumerate(zip(q, v, strict=True)):
        try:
            impact = solve(scene, pose, speed)
        except SingularMassError:
            statuses += batch.status[i] != Status.SINGULAR_MASS
            continue
        if impact.status != batch.status[i]:
            statuses += 1
            continue
        if not impact.status.valid:
            continue
        size = np.abs(speed).max() + np.abs(impact.dv).max()
        apart = _distance(batch.v_after[i], impact.v_after) / size
        if apart > BAR:
            harder += 1
            exact = np.array([float(x) for x in velocity_after(scene, pose, speed)])
            theirs = _distance(impact.v_after, exact)
            apart = max(0.0, _distance(batch.v_after[i], exact) - theirs) / size
        worst = max(worst, float(apart))
    return Agreement(len(q), worst, harder, statuses)


def _distance(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max())


def main(rows: int = 10_000) -> int:
    """Write a line for every robot and kind of scene; 1 if one is above the bar."""
    kept = True
    for index, name in enumerate(example_names()):
        robot = loaded_robot(name)
        if robot is None:
            continue
        for kind in KINDS:
            rng = np.random.default_rng([2, index, KINDS.index(kind)])
            found = agreement(random_scene(robot, kind, rng), *random_state(robot, rng, rows))
            held = found.worst <= BAR and not found.statuses
            kept = kept and held
            sys.stdout.write(f"{name:36s} {kind:8s} {found}{'' if held else '   ABOVE'}\n")
            sys.stdout.flush()
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
