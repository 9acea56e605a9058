"""A robot is a Pinocchio model with its names."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors
from tests.reference.models import mass_matrix


def test_roots_add_their_degrees_of_freedom():
    text = ik.models.chain_urdf(3)
    sizes = {
        root: (ik.Robot.from_urdf(text, root=root).nq, ik.Robot.from_urdf(text, root=root).nv)
        for root in ("fixed", "planar", "freeflyer")
    }
    assert sizes == {"fixed": (2, 2), "planar": (6, 5), "freeflyer": (9, 8)}
    assert ik.Robot.from_urdf(text, root=pin.JointModelPZ()).nv == 3


def test_a_given_model_is_copied_and_never_changed():
    model = pin.buildSampleModelHumanoid()
    before = pin.Model(model)
    robot = ik.Robot.from_model(model)
    q = robot.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    ik.solve(
        ik.Scene(robot, [ik.AppliedImpulse("lleg_elbow_joint", [0, 0, 1])]), q, np.zeros(robot.nv)
    )
    assert model == before
    robot.model.names[1] = "other"
    assert model == before


def test_a_robot_travels_by_pickle():
    robot = ik.combine(arm=ik.Robot.from_example("panda"), ball=_ball())
    twin = pickle.loads(pickle.dumps(robot))
    assert twin.model == robot.model
    assert [link.name for link in twin.links] == [link.name for link in robot.links]
    assert twin.parts == robot.parts


def test_links_behind_fixed_joints_keep_their_own_mass_and_mass_centre():
    robot = ik.Robot.from_example("panda")
    own = {link.name: link for link in robot.links}
    flange, hand = own["panda_link7"], own["panda_hand"]
    assert flange.joint_id == hand.joint_id
    whole = robot.model.inertias[hand.joint_id]
    on_joint = [link for link in robot.links if link.joint_id == hand.joint_id]
    assert sum(link.mass for link in on_joint) == pytest.approx(whole.mass, rel=1e-14)
    com = sum(link.mass * link.com_in_joint for link in on_joint) / whole.mass
    np.testing.assert_allclose(com, whole.lever, atol=1e-15)
    assert not np.allclose(flange.com_in_joint, hand.com_in_joint)


def test_geometry_is_read_only_when_somebody_looks():
    robot = ik.Robot.from_example("panda", root="freeflyer")
    assert "collision_model" not in vars(robot)
    boxes = robot.collision_model.geometryObjects
    hand = robot.model.frames[robot.frame_id("panda_hand")]
    assert {item.parentJoint for item in boxes} <= set(range(robot.model.njoints))
    assert any(item.parentJoint == hand.parentJoint for item in boxes)


def _ball() -> ik.Robot:
    return ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


def test_a_model_whose_joints_are_not_numbered_depth_first_is_refused():
    model = pin.Model()
    for k, parent in enumerate((0, 1, 1, 2)):
        place = pin.SE3(pin.exp3(np.array([0.1, 0.5, -0.3 * k])), np.array([0.2, 0.3, 0.1 * k]))
        joint_id = model.addJoint(parent, pin.JointModelRX(), place, f"joint_{k}")
        model.appendBodyToJoint(joint_id, pin.Inertia.FromBox(1.0, 0.1, 0.2, 0.3), place)
    # Pinocchio's mass matrix of it would not give the kinetic energy.
    data, q, v = model.createData(), np.ones(4), np.ones(4)
    masses = mass_matrix(model, q)
    assert abs(pin.computeKineticEnergy(model, data, q, v) - 0.5 * v @ masses @ v) > 1e-3
    with pytest.raises(errors.InputError, match=r'"joint_3" is a child of "joint_1".*depth first'):
        ik.Robot.from_model(model)


def test_numbers_of_a_given_model_are_looked_at():
    model = pin.Model(ik.Robot.from_example("panda", mimic=True).model)
    assert ik.Robot.from_model(model).nv == 8
    placed = pin.Model(model)
    placed.jointPlacements[3] = pin.SE3(np.eye(3), np.array([0.0, np.nan, 0.0]))
    with pytest.raises(ik.errors.InputError, match='"panda_joint3": its placement'):
        ik.Robot.from_model(placed)
    heavy = pin.Model(model)
    heavy.inertias[2] = pin.Inertia(np.inf, np.zeros(3), np.eye(3))
    with pytest.raises(ik.errors.InputError, match='"panda_joint2": the inertia'):
        ik.Robot.from_model(heavy)
