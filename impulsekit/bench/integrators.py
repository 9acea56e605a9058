"""The integrators of ``simulate``: run time against error on three scenes; where time goes.

Run with ``python -m impulsekit.bench.integrators [DIAGRAM.svg]``. The errors are against
references of their own: closed forms for the ball, Kane's equations for the pendulum
integrated apart from Pinocchio, and for Talos the laws of free flight, of energy and of
momentum.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from ..chain import pendulum_urdf
from ..motion import Trajectory, simulate
from ..robot import Robot
from ..scene import AppliedImpulse, Contact, Scene
from .claim import Claim

__all__ = ["Case", "Row", "cases", "claims", "main", "share_of_libraries"]

# The settings of each method, from loose to tight.
SETTINGS: dict[str, list[dict[str, float]]] = {
    "dop853": [{"rtol": 10.0**-k, "atol": 10.0 ** (-k - 2)} for k in range(4, 13, 2)],
    "radau": [{"rtol": 10.0**-k, "atol": 10.0 ** (-k - 2)} for k in (3, 5, 7, 9)],
    "rk4": [{"step": h} for h in (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)],
    "semi-implicit": [{"step": h} for h in (4e-3, 1e-3, 2.5e-4)],
}


@dataclass(frozen=True)
class Case:
    """A scene, its start, and how far an answer is from the truth."""

    name: str
    scene: Scene
    q: np.ndarray
    v: np.ndarray
    duration: float
    error: Callable[[Trajectory], float]
    unit: str


@dataclass(frozen=True)
class Row:
    """One run. ``seconds``: wall time; ``evaluations``: of the accelerations."""

    case: str
    method: str
    setting: float
    seconds: float
    evaluations: int
    error: float


def cases() -> list[Case]:
    """A bouncing ball, the struck pendulum of ten links, Talos in flight."""
    return [_ball(), _pendulum(), _talos()]


def _ball() -> Case:
    urdf = (
        '<robot name="ball"><link name="ball"><inertial><mass value="0.5"/>'
        '<inertia ixx="5e-4" iyy="5e-4" izz="5e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        "</robot>"
    )
    ball = Robot.from_urdf(urdf, root="freeflyer")
    scene = Scene(ball, contacts=[Contact("ball", restitution=0.9)])
    q = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    fall = np.sqrt(2.0 / 9.81)
    wanted = fall + np.concatenate([[0.0], 2.0 * fall * np.cumsum(0.9 ** np.arange(1, 6))])

    def error(motion: Trajectory) -> float:
        times = np.array([t for t, _ in motion.impacts][:6])
        return float(np.abs(times - wanted[: len(times)]).max()) if len(times) == 6 else np.inf

    return Case("bouncing ball", scene, q, ball.velocity(), 4.5, error, "s of impact times")


def _pendulum() -> Case:
    mass, length, blow = 14.5939, 0.3048, 133.447
    robot = Robot.from_urdf(pendulum_urdf(10, mass, length))
    struck = AppliedImpulse("link_10", linear=[blow, 0, 0], at=[0, 0, -length])
    known = _kane_end(10, mass, length, blow, 1.0)
    data = robot.model.createData()
    tip = robot.frame_id("link_10")

    def error(motion: Trajectory) -> float:
        pin.framesForwardKinematics(robot.model, data, motion.q[-1])
        end = data.oMf[tip].act(np.array([0.0, 0.0, -length]))
        return float(np.abs(end[[0, 2]] - known).max())

    scene = Scene(robot, impulses=[struck])
    return Case(
        "struck pendulum", scene, robot.neutral(), robot.velocity(), 1.0, error, "m of the free end"
    )


def _kane_end(count: int, mass: float, length: float, blow: float, t: float) -> np.ndarray:
    """(2,) x and z of the free end at t, by Kane's equations with absolute angles."""
    from scipy.integrate import solve_ivp

    index = np.arange(count)
    masses = mass * length**2 * (0.5 + count - 1 - np.maximum.outer(index, index))
    np.fill_diagonal(masses, mass * length**2 * (1.0 / 3.0 + count - 1 - index))
    weights = mass * 9.81 * length * (0.5 + count - 1 - index)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        angle, speed = y[:count], y[count:]
        between = np.subtract.outer(angle, angle)
        active = -(masses * np.sin(between)) @ speed**2 - weights * np.sin(angle)
        return np.concatenate([speed, np.linalg.solve(masses * np.cos(between), active)])

    start = np.concatenate(
        [np.zeros(count), np.linalg.solve(masses, np.full(count, blow * length))]
    )
    found = solve_ivp(rates, (0.0, t), start, method="DOP853", rtol=1e-13, atol=1e-13)
    angle = found.y[:count, -1]
    return length * np.array([np.sin(angle).sum(), -np.cos(angle).sum()])


def _talos() -> Case:
    talos = Robot.from_example("talos", root="freeflyer")
    v = np.random.default_rng(0).normal(size=talos.nv)

    def error(motion: Trajectory) -> float:
        energy, momentum = motion.energy(), motion.momentum()
        kept = np.ptp(energy.total) / energy.kinetic[0]
        linear = momentum.linear - np.outer(motion.t, talos.mass * np.array([0, 0, -9.81]))
        size = talos.mass * 9.81 * motion.t[-1]
        return float(max(kept, np.abs(linear - linear[0]).max() / size))

    return Case("Talos in flight", Scene(talos), talos.neutral(), v, 1.0, error, "relative")


def run(case: Case, method: str, setting: dict[str, Any]) -> Row:
    """One run of a case, timed twice; the faster counts."""
    taken = []
    for _ in range(2):
        start = time.perf_counter()
        motion = simulate(
            case.scene, case.q, case.v, duration=case.duration, samples=21, method=method, **setting
        )
        taken.append(time.perf_counter() - start)
    error = case.error(motion) if motion.status.finished else np.inf
    value = setting.get("rtol", setting.get("step", np.nan))
    return Row(case.name, method, value, min(taken), motion.evaluations, error)


def share_of_libraries(duration: float = 5.0) -> float:
    """The part of a flight of Talos by DOP853 that is spent inside Pinocchio and scipy.

    Their calls are timed alone, at the same sizes, and counted as often as the flight
    makes them; the whole flight is timed around it.
    """
    from scipy.integrate import DOP853

    case = _talos()
    model = case.scene.robot.model
    data, zero = model.createData(), np.zeros(model.nv)
    x, v = 0.01 * case.v, case.v

    def pinocchio_calls() -> None:
        q = pin.integrate(model, case.q, x)
        pin.aba(model, data, q, v, zero)
        turn, speed = pin.Motion(x[:6]), pin.Motion(v[:6])
        once = turn.cross(speed)
        twice = turn.cross(once)
        (speed + once * 0.5 + twice * 0.1 + turn.cross(turn.cross(twice)) * 0.1).vector  # noqa: B018

    rates = np.concatenate([case.v, np.ones(model.nv)])
    y = np.zeros(2 * model.nv)

    def scipy_steps(count: int) -> int:
        solver = DOP853(lambda t, y: rates, 0.0, y, 1e9, max_step=1e-3, first_step=1e-3)
        for _ in range(count):
            solver.step()
            solver.dense_output()
        return solver.nfev

    best = 0.0
    for _ in range(3):
        start = time.perf_counter()
        motion = simulate(case.scene, case.q, case.v, duration=duration, samples=2)
        whole = time.perf_counter() - start
        start = time.perf_counter()
        for _ in range(2000):
            pinocchio_calls()
        one = (time.perf_counter() - start) / 2000
        start = time.perf_counter()
        calls = scipy_steps(300)
        step = (time.perf_counter() - start) / calls
        best = max(best, motion.evaluations * (one + step) / whole)
    return best


def claims() -> Iterator[Claim]:
    """Where the time of a flight goes."""
    shares = [share_of_libraries() for _ in range(3)]
    yield Claim(
        "flight of Talos: share inside Pinocchio and scipy",
        0.75,
        sorted(shares)[1],
        min(shares),
        max(shares),
        at_least=True,
    )


def draw(rows: list[Row], path: Path) -> None:
    """Run time against error, one panel a scene."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot as plt

    names = list(dict.fromkeys(row.case for row in rows))
    units = {case.name: case.unit for case in cases()}
    figure, panels = plt.subplots(
        1, len(names), figsize=(4.2 * len(names), 4), layout="constrained"
    )
    for axes, name in zip(panels, names, strict=True):
        for method in SETTINGS:
            own = [r for r in rows if r.case == name and r.method == method]
            own = [r for r in own if np.isfinite(r.error)]
            axes.loglog(
                [max(r.error, 1e-16) for r in own], [r.seconds for r in own], "o-", label=method
            )
        axes.set_title(name)
        axes.set_xlabel(f"error [{units[name]}]")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("run time [s]")
    panels[0].legend(frameon=False)
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def main(arguments: list[str]) -> None:
    """Print the table, the share, and draw the diagram if a file is named."""
    rows = []
    head = (
        f"{'scene':16s} {'method':14s} {'rtol, step':>10s} {'ms':>9s} {'calls':>8s} {'error':>9s}"
    )
    write = sys.stdout.write
    write(head + "\n")
    for case in cases():
        for method, settings in SETTINGS.items():
            for setting in settings:
                row = run(case, method, setting)
                rows.append(row)
                write(
                    f"{row.case:16s} {row.method:14s} {row.setting:10.1e} "
                    f"{1e3 * row.seconds:9.2f} {row.evaluations:8d} {row.error:9.1e}\n"
                )
    write(f"flight of Talos: {share_of_libraries():.0%} inside Pinocchio and scipy\n")
    if arguments:
        draw(rows, Path(arguments[0]))


if __name__ == "__main__":
    main(sys.argv[1:])
