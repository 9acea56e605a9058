"""``impulsekit.crocoddyl.ImpactAction`` beside Crocoddyl's own bilateral impulse action.

It runs in an environment of its own, because Crocoddyl 3.2 is for Pinocchio 4.0:

    python -m benchmarks.crocoddyl_action --set-up FOLDER    # needs a network
    FOLDER/bin/python -m benchmarks.crocoddyl_action

One line a case: times of calc and calcDiff [µs] and the largest difference of Fx and Lx from
Crocoddyl's numerical ones, relative to their largest entries.
"""

from __future__ import annotations

import subprocess
import sys
import time
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
# Crocoddyl brings its own.
BROUGHT = ("pin", "example-robot-data")
REPEATS = 200
CASES = {
    "Solo12 on four feet": ("solo12", ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"), 3),
    "Talos on two soles": ("talos", ("left_sole_link", "right_sole_link"), 6),
}
CORNERS = [(0.1, 0.05, 0.0), (0.1, -0.05, 0.0), (-0.1, 0.05, 0.0), (-0.1, -0.05, 0.0)]


def set_up(folder: Path) -> None:
    """Make the environment: Crocoddyl with its Pinocchio, and impulsekit as it is here.

    Raises:
        subprocess.CalledProcessError: pip could not install it.
    """
    from .methods.crocoddyl import set_up as with_crocoddyl

    python = with_crocoddyl(folder)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = [each for each in project["dependencies"] if not each.startswith(BROUGHT)]
    for more in (needed, ["--no-deps", str(ROOT)]):
        subprocess.run([python, "-m", "pip", "install", "--quiet", *more], check=True)


def actions(name: str, frames: tuple[str, ...], rows: int) -> tuple[Any, Any, Any, np.ndarray]:
    """Our action without and with costs, Crocoddyl's own one, and a state x."""
    import crocoddyl
    import pinocchio as pin

    import impulsekit as ik
    from impulsekit.control import ImpactCost
    from impulsekit.crocoddyl import ImpactAction

    robot = ik.Robot.from_example(name, root="freeflyer")
    points = [(0.0, 0.0, 0.0)] if rows == 3 else CORNERS
    contacts = [ik.Contact(f, at=at, friction=0.9) for f in frames for at in points]
    scene = ik.Scene(robot, contacts=contacts, gap_bound=np.inf)
    state = crocoddyl.StateMultibody(robot.model)
    impulses = crocoddyl.ImpulseModelMultiple(state)
    for frame in frames:
        place = state, robot.frame_id(frame)
        own = (
            crocoddyl.ImpulseModel3D(*place, pin.LOCAL_WORLD_ALIGNED)
            if rows == 3
            else crocoddyl.ImpulseModel6D(*place, pin.LOCAL_WORLD_ALIGNED)
        )
        impulses.addImpulse(frame, own)
    theirs = crocoddyl.ActionModelImpulseFwdDynamics(
        state, impulses, crocoddyl.CostModelSum(state, 0), 0.0, 1e-12, True
    )
    bend = 0.3 if rows == 3 else 0.05
    q = pin.integrate(robot.model, robot.neutral(), bend * np.sin(1.0 + np.arange(robot.nv)))
    v = 0.1 * np.cos(np.arange(robot.nv))
    v[:3] += pin.Quaternion(q[3:7]).matrix().T @ [0.0, 0.0, -1.0]
    costs = [ImpactCost("contact_impulses", 0.1)] if rows == 3 else [ImpactCost("v_after", 0.1)]
    ours, priced = ImpactAction(state, scene), ImpactAction(state, scene, costs)
    return ours, priced, theirs, np.concatenate([q, v])


def microseconds(action: Any, x: np.ndarray) -> float:
    """The median time of calc and calcDiff [µs]."""
    data, u, times = action.createData(), np.zeros(0), []
    for _ in range(REPEATS):
        start = time.perf_counter()
        action.calc(data, x, u)
        action.calcDiff(data, x, u)
        times.append(time.perf_counter() - start)
    return 1e6 * float(np.median(times))


def difference(action: Any, x: np.ndarray) -> float:
    """The largest relative difference of Fx and Lx from numerical ones."""
    import crocoddyl

    numerical, u = crocoddyl.ActionModelNumDiff(action), np.zeros(0)
    data, theirs = action.createData(), numerical.createData()
    for model, own in ((action, data), (numerical, theirs)):
        model.calc(own, x, u)
        model.calcDiff(own, x, u)
    pairs = ((data.Fx, theirs.Fx), (data.Lx, theirs.Lx))
    return max(float(np.abs(a - b).max() / max(1.0, np.abs(b).max())) for a, b in pairs)


def main() -> int:
    """Print a line for each case, or make the environment."""
    if "--set-up" in sys.argv:
        set_up(Path(sys.argv[-1]))
        return 0
    warnings.simplefilter("ignore")
    for title, case in CASES.items():
        ours, priced, theirs, x = actions(*case)
        sys.stdout.write(
            f"{title}: ours {microseconds(ours, x):.0f}, bilateral {microseconds(theirs, x):.0f}, "
            f"differences {difference(priced, x):.1e}\n"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
