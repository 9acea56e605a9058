"""Batches beside ``solve``, row by row, on random scenes of all example robots.

Run with ``python -m impulsekit.bench.batch_agreement [ROWS]``, 10 000 by default.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..batch.codes import RowStatus
from ..batch.solve import solve_batch
from ..errors import SingularMassError, UrdfError
from ..impact import solve
from ..robot import Robot
from ..robot.examples import example_names
from ..robot.robot import WORLD
from ..scene import AppliedImpulse, Contact, JointImpulse, Scene
from .problems.digits import velocity_after

__all__ = ["Agreement", "agreement", "all_robots", "random_scene", "random_states"]

BAR = 1e-12


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


def all_robots() -> Iterator[Robot]:
    """Every example robot that can be loaded, with a root that lets something move."""
    for i, name in enumerate(example_names()):
        try:
            robot = Robot.from_example(name)
            # Arms stand; what has no joints of its own, and every second other one, flies.
            if robot.nv < 2 or i % 2:
                robot = Robot.from_example(name, root="freeflyer")
        except UrdfError:
            continue
        yield robot


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


def random_states(
    robot: Robot, rows: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """(rows, nq) and (rows, nv): every angle within a turn, every length within a metre."""
    steps = rng.uniform(-1.5, 1.5, (rows, robot.nv))
    q = np.array([pin.integrate(robot.model, robot.neutral(), step) for step in steps])
    return q, rng.normal(size=(rows, robot.nv))


def agreement(scene: Scene, q: np.ndarray, v: np.ndarray) -> Agreement:
    """Solve the rows both ways."""
    batch = solve_batch(scene, q, v)
    worst, harder, statuses = 0.0, 0, 0
    for i, (pose, speed) in enumerate(zip(q, v, strict=True)):
        try:
            impact = solve(scene, pose, speed)
        except SingularMassError:
            statuses += batch.status[i] != RowStatus.SINGULAR_MASS
            continue
        if RowStatus.of(impact.status) != batch.status[i]:
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
        worst = max(worst, apart)
    return Agreement(len(q), worst, harder, statuses)


def _distance(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max())


def main() -> None:
    """Write a line for every robot and kind of scene."""
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    write = sys.stdout.write
    rng = np.random.default_rng(2)
    highest = 0.0
    for robot in all_robots():
        for kind in ("blows", "contact"):
            found = agreement(random_scene(robot, kind, rng), *random_states(robot, rows, rng))
            highest = max(highest, found.worst)
            verdict = "" if found.worst <= BAR and not found.statuses else "   ABOVE"
            write(
                f"{robot.name:36s} nv {robot.nv:3d} {kind:8s} {found.rows:7d} rows   "
                f"{found.worst:.1e}   {found.harder} by 50 digits   "
                f"{found.statuses} statuses differ{verdict}\n"
            )
            sys.stdout.flush()
    write(
        f"largest difference {highest:.1e}   {BAR:g} {'held' if highest <= BAR else 'NOT HELD'}\n"
    )


if __name__ == "__main__":
    main()
