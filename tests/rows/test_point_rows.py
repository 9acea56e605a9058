"""Rows, rates and gaps of tables of points are those of the same pairs of frames."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.geometry.point_table import table_of
from impulsekit.motion.gaps.rated import PlaneGap, RopeGap
from impulsekit.motion.tree.memory import Memory
from impulsekit.motion.tree.pressed import rows_and_bias
from impulsekit.rows.point_rows import gaps_and_rates
from impulsekit.rows.reach import reached_model

ENTRIES = {
    "plane": ik.Contact("arm", at=(0.3, 0.1, 0.2), normal=(0.6, 0, 0.8), origin=(0, 0.1, 0)),
    "moving plane": ik.Contact(
        "arm", at=(0.3, 0, 0.2), normal=(0.6, 0, 0.8), origin=(0, 0.1, 0), against="body"
    ),
    "rope": ik.Rope("arm", "body", length=2.0, at=(0.3, 0.1, 0.2), other_at=(-0.1, 0.2, 0)),
}


def robot_of_three():
    model, body = pin.Model(), pin.Inertia.Random()
    for name, parent, joint in (
        ("body", 0, pin.JointModelFreeFlyer()),
        ("link", 1, pin.JointModelRY()),
        ("arm", 2, pin.JointModelSpherical()),
    ):
        own = model.addJoint(parent, joint, pin.SE3.Random(), f"{name} joint")
        model.appendBodyToJoint(own, body, pin.SE3.Identity())
        model.addFrame(pin.Frame(name, own, 0, pin.SE3.Random(), pin.FrameType.BODY), False)
    return ik.Robot.from_model(model)


@pytest.mark.parametrize("name", ENTRIES)
def test_a_row_of_a_table_is_a_pair_of_frames(name):
    pin.seed(5)
    robot, rng = robot_of_three(), np.random.default_rng(5)
    model, entry = robot.model, ENTRIES[name]
    reached = reached_model(model, range(1, model.njoints), keep_places=True)
    item = (RopeGap if name == "rope" else PlaneGap)(robot, reached, entry, 0)
    memory, table = Memory(reached.model), table_of(item.in_table())
    data = memory.data
    for _ in range(5):
        q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
        v = rng.normal(size=model.nv)
        pin.forwardKinematics(reached.model, data, q, v, np.zeros(model.nv))
        pin.computeJointJacobians(reached.model, data, q)
        rows, bias = rows_and_bias(table, memory.kinematics)
        found = memory.kinematics
        ((gap,), (rate,)) = gaps_and_rates(table, found.places, found.speeds, q, v)
        wanted = item.bias(data, q, v, rows)
        assert np.abs(rows - item.rows(data, q)).max() < 1e-14 * max(1.0, np.abs(rows).max())
        assert np.abs(bias - wanted).max() < 1e-14 * max(1.0, np.abs(wanted).max())
        assert abs(rate - rows[2].dot(v)) < 1e-13
        ahead = pin.integrate(model, q, 1e-6 * v)
        pin.forwardKinematics(reached.model, data, ahead, v)
        moved = memory.kinematics
        later = gaps_and_rates(table, moved.places, moved.speeds, ahead, v)[0, 0]
        assert abs((later - gap) / 1e-6 - rate) < 1e-4 * (1.0 + abs(rate))
