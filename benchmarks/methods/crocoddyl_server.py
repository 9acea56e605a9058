"""Runs in Crocoddyl's own environment: builds its impulse action, answers, and times it there.

One JSON object a line, in and out. It imports nothing of impulsekit, which is not installed there.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import crocoddyl
import numpy as np
import pinocchio as pin

SINGLE = {
    ("turn", 0): pin.JointModelRX,
    ("turn", 1): pin.JointModelRY,
    ("turn", 2): pin.JointModelRZ,
    ("slide", 0): pin.JointModelPX,
    ("slide", 1): pin.JointModelPY,
    ("slide", 2): pin.JointModelPZ,
}
GENERAL = {"turn": pin.JointModelRevoluteUnaligned, "slide": pin.JointModelPrismaticUnaligned}
SEVERAL = {
    "free": pin.JointModelFreeFlyer,
    "planar": pin.JointModelPlanar,
    "ball": pin.JointModelSpherical,
    "translation": pin.JointModelTranslation,
}
# Crocoddyl's own advice where rows depend on each other.
DAMPING = 1e-12


def built(request: dict[str, Any]) -> Callable[[], np.ndarray]:
    """The call that answers a request, which describes a mechanism, its blows and holds."""
    model = pin.Model()
    coordinates = {}
    for body in request["bodies"]:
        placement = pin.SE3(np.array(body["rotation"]), np.array(body["offset"]))
        joint = model.addJoint(body["parent"] + 1, joint_of(body), placement, body["name"])
        inertia = pin.Inertia(body["mass"], np.array(body["centre"]), np.array(body["inertia"]))
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        if body["kind"] in GENERAL:
            coordinates[joint] = body["coordinate"]
    q = pin.neutral(model)
    for joint, coordinate in coordinates.items():
        q[model.joints[joint].idx_q] = coordinate
    rows = []
    for i, hold in enumerate(request["holds"]):
        placement = pin.SE3(np.array(hold["rotation"]), np.array(hold["at"]))
        joint = hold["body"] + 1
        frame = model.addFrame(pin.Frame(f"hold {i}", joint, 0, placement, pin.FrameType.OP_FRAME))
        rows.append((frame, hold["rows"]))
    # The state has to know the frames.
    state = crocoddyl.StateMultibody(model)
    impulses = crocoddyl.ImpulseModelMultiple(state)
    for frame, count in rows:
        kind = crocoddyl.ImpulseModel3D if count == 3 else crocoddyl.ImpulseModel6D
        impulses.addImpulse(
            model.frames[frame].name, kind(state, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        )
    data = model.createData()
    jacobian = np.vstack(
        [
            pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[:count]
            for frame, count in rows
        ]
    )
    damping = 0.0 if np.linalg.matrix_rank(jacobian) == len(jacobian) else DAMPING
    costs = crocoddyl.CostModelSum(state, 0)
    action = crocoddyl.ActionModelImpulseFwdDynamics(state, impulses, costs, 0.0, damping, False)
    own = action.createData()
    return call(model, action, own, q, np.array(request["v"]), request)


def joint_of(body: dict[str, Any]) -> Any:
    """The joint of Pinocchio."""
    if body["kind"] in SEVERAL:
        return SEVERAL[body["kind"]]()
    axis = np.array(body["axes"][0])
    for i in range(3):
        if (axis == np.eye(3)[i]).all():
            return SINGLE[body["kind"], i]()
    return GENERAL[body["kind"]](axis)


def call(
    model: pin.Model, action: Any, own: Any, q: np.ndarray, v: np.ndarray, request: dict[str, Any]
) -> Callable[[], np.ndarray]:
    """The call that gives the velocities after: what is known first, then the action's impulse."""
    data = model.createData()
    model.gravity.setZero()
    still, within = np.zeros(model.nv), np.array(request["joint_impulse"])
    loads = pin.StdVec_Force()
    pin.forwardKinematics(model, data, q)
    for _ in range(model.njoints):
        loads.append(pin.Force.Zero())
    for blow in request["blows"]:
        linear, place = np.array(blow["linear"]), np.array(blow["place"])
        world = pin.Force(linear, np.array(blow["angular"]) + np.cross(place, linear))
        joint = blow["body"] + 1
        loads[joint] = loads[joint] + data.oMi[joint].actInv(world)
    struck = bool(request["blows"]) or within.any()
    x = np.concatenate([q, v])

    def velocity_after() -> np.ndarray:
        if struck:
            x[model.nq :] = v + pin.aba(model, data, q, still, within, loads)
        action.calc(own, x)
        return own.xnext[model.nq :]

    return velocity_after


def seconds(answer: Callable[[], np.ndarray], repeats: int) -> float:
    """Of one call, the mean of so many; one goes before, as the process has just slept."""
    answer()
    start = time.perf_counter()
    for _ in range(repeats):
        answer()
    return (time.perf_counter() - start) / repeats


def reply_to(request: dict[str, Any], calls: list[Callable[[], np.ndarray]]) -> Any:
    """What goes back; ``calls`` are those built so far."""
    if request["do"] == "build":
        calls.append(built(request))
        return len(calls) - 1
    answer = calls[request["call"]]
    if request["do"] == "answer":
        return [float(x) for x in answer()]
    return seconds(answer, request["repeats"])


def main() -> None:
    """Answer requests until there are no more."""
    calls: list[Callable[[], np.ndarray]] = []
    for line in sys.stdin:
        sys.stdout.write(json.dumps(reply_to(json.loads(line), calls)) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
