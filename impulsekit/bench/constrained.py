"""A blow on Talos with both feet held: ``solve`` against bare Pinocchio calls.

Run with ``python -m impulsekit.bench.constrained``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import numpy as np
import pinocchio as pin

from ..impact import solve
from ..robot import Robot
from ..scene import AppliedImpulse, FrameAnchor, Scene
from .claim import Claim
from .timing import time_in_turn

__all__ = ["bare_pinocchio", "claims", "held_talos", "main"]

HAND, FEET = "gripper_left_base_link", ("leg_left_6_link", "leg_right_6_link")
AT = (0.1, 0.0, 0.05)
LINEAR = (30.0, -20.0, 100.0)


def bare_pinocchio(robot: Robot, q: np.ndarray, v: np.ndarray) -> Callable[[], np.ndarray]:
    """CRBA, the feet's Jacobians, the blow on the free robot, and impulseDynamics by J."""
    model = pin.Model(robot.model)
    struck = model.frames[model.getFrameId(HAND)]
    placement = struck.placement * pin.SE3(np.eye(3), np.array(AT))
    point = pin.Frame("struck", struck.parentJoint, 0, placement, pin.FrameType.OP_FRAME)
    hand = model.addFrame(point, False)
    feet = [model.getFrameId(name) for name in FEET]
    data = model.createData()
    impulse = np.array([*LINEAR, 0.0, 0.0, 0.0])
    rows = np.empty((12, model.nv))

    def velocity_jump() -> np.ndarray:
        jacobian = pin.computeFrameJacobian(model, data, q, hand, pin.LOCAL_WORLD_ALIGNED)
        known = jacobian.T @ impulse
        for i, foot in enumerate(feet):
            rows[6 * i : 6 * i + 6] = pin.computeFrameJacobian(
                model, data, q, foot, pin.LOCAL_WORLD_ALIGNED
            )
        pin.crba(model, data, q)
        pin.cholesky.decompose(model, data)
        free = v + pin.cholesky.solve(model, data, known)
        return pin.impulseDynamics(model, data, free, rows) - v

    return velocity_jump


def held_talos() -> tuple[Scene, np.ndarray, np.ndarray]:
    """The scene and a state."""
    robot = Robot.from_example("talos", root="freeflyer")
    scene = Scene(
        robot,
        [AppliedImpulse(HAND, LINEAR, at=AT)],
        [FrameAnchor(name) for name in FEET],
    )
    rng = np.random.default_rng(0)
    q = pin.integrate(robot.model, robot.neutral(), rng.uniform(-1.0, 1.0, robot.nv))
    return scene, q, rng.normal(size=robot.nv)


def claims() -> Iterator[Claim]:
    """``solve`` with both feet held."""
    scene, q, v = held_talos()
    bare = bare_pinocchio(scene.robot, q, v)
    ours = lambda: solve(scene, q, v).dv  # noqa: E731
    difference = np.abs(ours() - bare()).max() / np.abs(bare()).max()
    times = time_in_turn({"ours": ours, "bare": bare})
    yield Claim.of_ratio(
        f"{scene.robot.name}, both feet held, 12 rows: solve / bare",
        times["ours"],
        times["bare"],
        2.0,
        note=f"they differ by {difference:.1e}",
    )


def main() -> None:
    """Measure and write the rows."""
    for claim in claims():
        sys.stdout.write(claim.line())


if __name__ == "__main__":
    main()
