"""Contacts with friction: ``solve`` against bare Pinocchio.

Run with ``python -m impulsekit.bench.contacts``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import numpy as np
import pinocchio as pin

from ..impact import solve
from ..robot import Robot
from ..scene import Contact, Scene
from .claim import Claim
from .problems.feet import CORNERS, SOLES
from .timing import time_in_turn

__all__ = ["CORNERS", "SOLES", "bare_admm", "bare_impulse_dynamics", "claims", "main"]


def _state(robot: Robot, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q = robot.neutral()
    q[7:] += rng.uniform(-0.1, 0.1, robot.nq - 7)
    v = 0.2 * rng.normal(size=robot.nv)
    v[2] -= 1.0
    return q, v


def _solving(scene: Scene, q: np.ndarray, v: np.ndarray) -> Callable[[], np.ndarray]:
    return lambda: solve(scene, q, v).dv


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


def bare_admm(
    robot: Robot, q: np.ndarray, v: np.ndarray, friction: float, tolerance: float
) -> Callable[[], tuple[np.ndarray, int]]:
    """Eight corners by Pinocchio's own calls: CRBA, Cholesky, Delassus matrix, ADMM."""
    model = pin.Model(robot.model)
    ids = []
    for sole in SOLES:
        foot = model.frames[model.getFrameId(sole)]
        for i, corner in enumerate(CORNERS):
            placement = foot.placement * pin.SE3(np.eye(3), np.array(corner))
            point = pin.Frame(f"{sole} {i}", foot.parentJoint, 0, placement, pin.FrameType.OP_FRAME)
            ids.append(model.addFrame(point, False))
    data = model.createData()
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for _ in ids:
        models.append(
            pin.ConstraintModel(pin.PointContactConstraintModel(model, 1, pin.SE3.Identity()))
        )
    for i in range(len(ids)):
        models[i].extract().setFriction(friction)
        datas.append(models[i].createData())
    solver = pin.ADMMConstraintSolver(3 * len(ids))
    settings = pin.ADMMSolverSettings()
    settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = tolerance
    settings.max_iterations = 5000

    def velocity_after() -> tuple[np.ndarray, int]:
        jacobian = np.vstack(
            [
                pin.computeFrameJacobian(model, data, q, frame_id, pin.LOCAL_WORLD_ALIGNED)[:3]
                for frame_id in ids
            ]
        )
        pin.crba(model, data, q)
        pin.cholesky.decompose(model, data)
        moved = np.array([pin.cholesky.solve(model, data, row) for row in jacobian])
        delassus = moved @ jacobian.T
        size = delassus.diagonal().max()
        result = pin.ADMMSolverResult()
        operator = pin.DelassusOperatorDense(delassus / size)
        solver.solve(operator, jacobian @ v, models, datas, settings, result)
        impulse = result.retrieveConstraintImpulses() / size
        return v + impulse @ moved, int(result.iterations)

    return velocity_after


def claims() -> Iterator[Claim]:
    """One contact, and eight, under friction."""
    talos = Robot.from_example("talos", root="freeflyer")
    q, v = _state(talos)
    for friction, words in ((0.2, "slides"), (2.0, "sticks")):
        contact = Contact(SOLES[0], at=CORNERS[0], friction=friction)
        scene = Scene(talos, contacts=[contact])
        times = time_in_turn(
            {
                "ours": _solving(scene, q, v),
                "bare": bare_impulse_dynamics(talos, SOLES[0], CORNERS[0], q, v),
            }
        )
        label = f"Talos, one frictional contact that {words}"
        yield Claim.of_ratio(label, times["ours"], times["bare"], 3.0)
    eight = Scene(
        talos, contacts=[Contact(sole, at=at, friction=0.5) for sole in SOLES for at in CORNERS]
    )
    for seed in range(6):
        q, v = _state(talos, seed)
        impact = solve(eight, q, v)
        for tolerance in (1e-8, 1e-10):
            bare = bare_admm(talos, q, v, 0.5, tolerance)
            times = time_in_turn({"ours": _solving(eight, q, v), "bare": bare})
            difference = np.abs(bare()[0] - impact.v_after).max()
            yield Claim.of_ratio(
                f"Talos, eight foot points, state {seed}, ADMM to {tolerance:g}",
                times["ours"],
                times["bare"],
                1.3,
                note=f"ADMM {difference:.0e} m/s from ours; our residual "
                f"{impact.residuals.complementarity:.0e}, {impact.status.name}",
            )


def main() -> None:
    """Measure and write the rows."""
    for claim in claims():
        sys.stdout.write(claim.line())


if __name__ == "__main__":
    main()
