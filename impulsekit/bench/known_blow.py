"""One known blow: ``solve`` against bare Pinocchio calls that do the same work.

Run with ``python -m impulsekit.bench.known_blow``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import numpy as np
import pinocchio as pin

from ..impact import solve
from ..robot import Robot
from ..robot.combine import combine
from ..scene import AppliedImpulse, Scene
from .claim import Claim
from .timing import import_times, time_in_turn

__all__ = ["AT", "LINEAR", "bare_pinocchio", "claims", "main"]

AT = (0.1, 0.0, 0.05)
LINEAR = (0.3, -0.2, 1.0)


def bare_pinocchio(robot: Robot, frame: str, q: np.ndarray) -> Callable[[], np.ndarray]:
    """Jacobian, CRBA, sparse Cholesky, as one would write them by hand for one scene."""
    model = pin.Model(robot.model)
    struck = model.frames[model.getFrameId(frame)]
    placement = struck.placement * pin.SE3(np.eye(3), np.array(AT))
    point = pin.Frame("struck", struck.parentJoint, 0, placement, pin.FrameType.OP_FRAME)
    frame_id = model.addFrame(point, False)
    data = model.createData()
    impulse = np.array([*LINEAR, 0.0, 0.0, 0.0])

    def velocity_jump() -> np.ndarray:
        jacobian = pin.computeFrameJacobian(model, data, q, frame_id, pin.LOCAL_WORLD_ALIGNED)
        pin.crba(model, data, q)
        pin.cholesky.decompose(model, data)
        return pin.cholesky.solve(model, data, jacobian.T @ impulse)

    return velocity_jump


def _state(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    q = pin.integrate(robot.model, robot.neutral(), rng.uniform(-1.0, 1.0, robot.nv))
    return q, rng.normal(size=robot.nv)


def _solving(robot: Robot, frame: str) -> Callable[[], np.ndarray]:
    scene = Scene(robot, [AppliedImpulse(frame, LINEAR, at=AT)])
    q, v = _state(robot)
    return lambda: solve(scene, q, v).dv


def claims() -> Iterator[Claim]:
    """``solve`` on Panda, Talos and one of four Pandas; imports."""
    panda = Robot.from_example("panda")
    talos = Robot.from_example("talos", root="freeflyer")
    for robot, frame in ((panda, "panda_hand"), (talos, "gripper_left_base_link")):
        ours, bare = _solving(robot, frame), bare_pinocchio(robot, frame, _state(robot)[0])
        difference = np.abs(ours() - bare()).max() / np.abs(bare()).max()
        times = time_in_turn({"ours": ours, "bare": bare})
        yield Claim.of_ratio(
            f"{robot.name}, nv {robot.nv}: solve / bare Pinocchio",
            times["ours"],
            times["bare"],
            1.5,
            note=f"they differ by {difference:.1e}",
        )
    four = combine(a=panda, b=panda, c=panda, d=panda)
    times = time_in_turn(
        {"four": _solving(four, "c/panda_hand"), "lone": _solving(panda, "panda_hand")}
    )
    yield Claim.of_ratio(
        "one of four Pandas, nv 36 / lone Panda", times["four"], times["lone"], 1.3
    )
    bounds = {"import impulsekit": 0.5, "from impulsekit import Robot, Scene": 1.15}
    imports = import_times(["import pinocchio", *bounds])
    for statement, bound in bounds.items():
        label = f"{statement} / import pinocchio"
        yield Claim.of_ratio(label, imports[statement], imports["import pinocchio"], bound)


def main() -> None:
    """Measure and write the rows."""
    for claim in claims():
        sys.stdout.write(claim.line())


if __name__ == "__main__":
    main()
