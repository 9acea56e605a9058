"""Batches beside ``solve``, row by row, on random scenes of all example robots.

Run with ``python -m impulsekit.bench.batch_agreement [ROWS] [-o FILE] [-j PROCESSES]``, 10 000
rows by default. What stands in the file already is not done again.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import pathlib
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..batch.solve import solve_batch
from ..errors import SingularMassError, UrdfError
from ..impact import solve
from ..laws.status import Status
from ..robot import Robot
from ..robot.examples import example_names
from ..robot.robot import WORLD
from ..scene import AppliedImpulse, Contact, JointImpulse, Scene
from .about import about
from .problems.digits import velocity_after

__all__ = ["Agreement", "agreement", "all_robots", "random_scene", "random_states"]

BAR = 1e-12
KINDS = ("blows", "contact")
COLUMNS = ("robot", "nv", "kind", "rows", "worst", "harder", "statuses", "date", "machine")


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
    for name in example_names():
        robot = _robot(name)
        if robot is not None:
            yield robot


def _robot(name: str) -> Robot | None:
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
        worst = max(worst, apart)
    return Agreement(len(q), worst, harder, statuses)


def _distance(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max())


def _line(name: str, kind: str, rows: int) -> dict[str, str] | None:
    """The figures of one robot; the random numbers are the same however the work is shared."""
    robot = _robot(name)
    if robot is None:
        return None
    rng = np.random.default_rng([2, example_names().index(name), KINDS.index(kind)])
    found = agreement(random_scene(robot, kind, rng), *random_states(robot, rows, rng))
    known = about()
    figures = (name, robot.nv, kind, found.rows, f"{found.worst:.1e}", found.harder, found.statuses)
    cells = (*map(str, figures), known["date"], known["machine"])
    return dict(zip(COLUMNS, cells, strict=True))


def main() -> None:
    """Write a line for every robot and kind of scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", type=int, nargs="?", default=10_000)
    parser.add_argument("--out", "-o", type=pathlib.Path, help="CSV file, which is gone on with")
    parser.add_argument("--jobs", "-j", type=int, default=1, help="processes")
    given = parser.parse_args()
    lines: list[dict[str, str]] = []
    if given.out is not None and given.out.exists():
        with given.out.open(newline="") as file:
            lines = [line for line in csv.DictReader(file) if int(line["rows"]) == given.rows]
    done = {(line["robot"], line["kind"]) for line in lines}
    jobs = [(name, kind) for name in example_names() for kind in KINDS if (name, kind) not in done]
    for line in lines:
        _tell(line)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(given.jobs, mp_context=context) as pool:
        for future in as_completed([pool.submit(_line, *job, given.rows) for job in jobs]):
            found = future.result()
            if found is not None:
                lines.append(found)
                _tell(found)
                _keep(lines, given.out)
    highest = max(float(line["worst"]) for line in lines)
    apart = sum(int(line["statuses"]) for line in lines)
    verdict = "held" if highest <= BAR and not apart else "NOT HELD"
    sys.stdout.write(
        f"largest difference {highest:.1e}, {apart} statuses differ   {BAR:g} {verdict}\n"
    )


def _tell(line: dict[str, str]) -> None:
    above = float(line["worst"]) > BAR or int(line["statuses"]) > 0
    sys.stdout.write(
        f"{line['robot']:36s} nv {line['nv']:>3s} {line['kind']:8s} {line['rows']:>7s} rows   "
        f"{line['worst']}   {line['harder']} by 50 digits   "
        f"{line['statuses']} statuses differ{'   ABOVE' if above else ''}\n"
    )
    sys.stdout.flush()


def _keep(lines: list[dict[str, str]], path: pathlib.Path | None) -> None:
    if path is None:
        return
    order = {name: i for i, name in enumerate(example_names())}
    kept = sorted(lines, key=lambda line: (order[line["robot"]], line["kind"]))
    partial = path.with_suffix(".partial")
    with partial.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(kept)
    partial.replace(path)


if __name__ == "__main__":
    main()
