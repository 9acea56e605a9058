"""``python -m benchmarks.per_second``: how many impacts a second, beside other programs' steps.

Random states of Solo12 landing on four feet, of Talos on eight points of its soles, and of a Panda
struck at its hand; then how the cost of an impact grows with contacts, degrees of freedom, states
and cores. All in one run; each figure is the best of some rounds.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pinocchio as pin

import impulsekit as ik
from benchmarks.jobs import landing
from benchmarks.methods.registry import methods
from benchmarks.problems.problem import Problem

RESULTS = Path(__file__).parent / "results/per_second"
ROUNDS, STATES, CHECKED = 25, 2048, 100
CORES = os.cpu_count() or 1
PEERS = (
    "pinocchio, impulseDynamics", "pinocchio, ADMM, 1e-09", "pinocchio, crba + cholesky",
    "mujoco, soft contacts, 1000", "mujoco, one step, 0.001", "exudyn, contacts, 1000",
    "exudyn, one step, 1e-06",
)  # fmt: skip
MANY = 10**9

Case = tuple[str, ik.Scene, np.ndarray, np.ndarray]


def blow() -> tuple[ik.Scene, np.ndarray, np.ndarray]:
    """Return a Panda struck at its hand."""
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=[1.0, 2.0, 3.0])])
    return scene, robot.configuration(panda_joint4=-1.5, panda_joint6=1.5), np.zeros(robot.nv)


def cases() -> Iterator[Case]:
    """Yield what is hit, with a state."""
    yield "Solo12 on four feet", *landing("solo12", 0.6, 0.3)
    yield "Talos on eight points", *landing("talos", 0.5)
    yield "Panda, a blow", *blow()


def states_of(scene: ik.Scene, q: np.ndarray, v: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
    """Return (count, nq), (count, nv): joints some 0.05 rad, velocities some 0.2 from a state."""
    model, rng = scene.robot.model, np.random.default_rng(0)
    steps = 0.05 * rng.normal(size=(count, model.nv))
    if scene.contacts:
        steps[:, :6] = 0.0
    many = np.array([pin.integrate(model, q, step) for step in steps])
    return many, v + 0.2 * rng.normal(size=(count, model.nv))


def seconds(call: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Return the least of some rounds."""
    taken = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        taken.append(time.perf_counter() - start)
    return min(taken)


def worst_residual(scene: ik.Scene, q: np.ndarray, v: np.ndarray) -> float:
    """Return the largest residual of the first states."""
    return max(ik.solve(scene, q[i], v[i]).residuals.largest for i in range(min(CHECKED, len(q))))


def rates() -> Iterator[str]:
    """Yield rows: impacts a second of one core, of all, one by one, and the largest residual."""
    yield "| | a core | all cores | one by one | largest residual | 10⁹ impacts, here |"
    yield "|---|---|---|---|---|---|"
    for name, scene, q, v in cases():
        many = states_of(scene, q, v, STATES)
        one = STATES / seconds(partial(ik.solve_batch, scene, *many, threads=1))
        everything = STATES / seconds(partial(ik.solve_batch, scene, *many))
        ik.solve(scene, q, v)
        single = 1.0 / seconds(partial(ik.solve, scene, q, v), 200)
        hours = MANY / everything / 3600
        yield (
            f"| {name} | {one:,.0f} | {everything:,.0f} | {single:,.0f} | "
            f"{worst_residual(scene, *many):.1e} | {hours:.2g} h |"
        )


def peers() -> Iterator[str]:
    """Yield rows: other programs' calls at one of these states, in microseconds."""
    found = {method.label: method for method in methods() if method.label in PEERS}
    yield "| µs a call | " + " | ".join(found) + " |"
    yield "|---" * (len(found) + 1) + "|"
    for name, scene, q, v in cases():
        problem = Problem("per second", 1, scene, q, v, lambda: np.zeros(0), "none")
        row = []
        for method in found.values():
            if not method.suits(problem):
                row.append("–")
                continue
            row.append(f"{1e6 * seconds(method.prepare(problem), 200):.1f}")
        yield f"| {name} | " + " | ".join(row) + " |"


def chain(links: int) -> ik.Scene:
    """Return a free chain struck at its end."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "chain.urdf"
        path.write_text(ik.models.chain_urdf(links), encoding="utf-8")
        robot = ik.Robot.from_urdf(path, root="planar")
    return ik.Scene(robot, [ik.AppliedImpulse(f"link_{links}", linear=[0.0, 5.0, 0.0])])


def growth() -> Iterator[str]:
    """Yield rows: microseconds an impact on one core by what grows."""
    yield "| what grows | µs an impact, one core |"
    yield "|---|---|"

    def cost(scene: ik.Scene, q: np.ndarray, v: np.ndarray, count: int = 4096) -> str:
        many = states_of(scene, q, v, count)
        return f"{1e6 * seconds(partial(ik.solve_batch, scene, *many, threads=1)) / count:.2f}"

    for name, friction in (("solo12", 0.6), ("talos", 0.5)):
        scene, q, v = landing(name, friction)
        for count in (1, 2, 4, 8)[: 3 if name == "solo12" else 4]:
            some = ik.Scene(scene.robot, contacts=scene.contacts[:count])
            yield f"| {name}, {count} contacts | {cost(some, q, v)} |"
    for links in (10, 20, 40, 80):
        scene = chain(links)
        state = scene.robot.neutral(), np.zeros(scene.robot.nv)
        yield f"| a blow on a chain of {links} | {cost(scene, *state)} |"
    scene, q, v = landing("solo12", 0.6, 0.3)
    for count in (8, 64, 512, 4096, 32768):
        yield f"| Solo12 on four feet, {count} states | {cost(scene, q, v, count)} |"


def main() -> int:
    """Write the tables, and print them."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    for name, rows in (("rates", rates), ("peers", peers), ("growth", growth)):
        table = "\n".join(rows()) + "\n"
        (RESULTS / f"{name}.md").write_text(table, encoding="utf-8")
        sys.stdout.write(table + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
