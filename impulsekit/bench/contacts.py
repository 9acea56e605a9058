"""Contacts with friction: ``solve`` against bare Pinocchio.

Run with ``python -m impulsekit.bench.contacts``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pinocchio as pin

from ..impact import solve
from ..robot import Robot
from ..scene import Contact, Scene
from .timing import ratio_row, time_in_turn

__all__ = ["main"]

# Four corners of each sole of Talos, in its sole's frame [m].
SOLES = ("left_sole_link", "right_sole_link")
CORNERS = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]


def _state(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    q = robot.neutral()
    q[7:] += rng.uniform(-0.1, 0.1, robot.nq - 7)
    v = 0.2 * rng.normal(size=robot.nv)
    v[2] -= 1.0
    return q, v


def bare_impulse_dynamics(
    robot: Robot, frame: str, at: tuple[float, ...], q: np.ndarray, v: np.ndarray
) -> Callable[[], np.ndarray]:
    """One contact held fast by ``pin.impulseDynamics``: no friction, no law, no books."""
    model = pin.Model(robot.model)
    foot = model.frames[model.getFrameId(frame)]
    placement = foot.placement * pin.SE3(np.eye(3), np.array(at))
    point = pin.Frame("corner", foot.parentJoint, 0, placement, pin.FrameType.OP_FRAME)
    frame_id = model.addFrame(point, False)
    data = model.createData()

    def velocity_after() -> np.ndarray:
        jacobian = pin.computeFrameJacobian(model, data, q, frame_id, pin.LOCAL_WORLD_ALIGNED)
        return pin.impulseDynamics(model, data, q, v, jacobian[:3], 0.0, 0.0)

    return velocity_after


def main() -> None:
    """Measure and write the rows."""
    write = sys.stdout.write
    talos = Robot.from_example("talos", root="freeflyer")
    q, v = _state(talos)
    one = Scene(talos, contacts=[Contact(SOLES[0], at=CORNERS[0], friction=0.5)])
    times = time_in_turn(
        {
            "ours": lambda: solve(one, q, v).dv,
            "bare": bare_impulse_dynamics(talos, SOLES[0], CORNERS[0], q, v),
        }
    )
    write(ratio_row("Talos, one frictional contact", times["ours"], times["bare"], 3.0) + "\n")


if __name__ == "__main__":
    main()
