"""The core's trees: places, columns, mass matrix, bias and responses are Pinocchio's."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact.flat.model import flat_model
from impulsekit.robot.examples import example_names

from ..robots import random_state
from ..robots_with_armature import KINDS, random_configuration, random_robot

EXACT = 1e-13
# Robots with a finger or gripper that has no mass, so that M is singular.
MASSLESS = ("romeo", "romeo_laas_small")
GRAVITY = np.array([0.3, -0.2, -9.81])


def off(found, truth, size=None):
    """The largest difference, over the largest entry or a size."""
    largest = np.abs(truth).max(initial=0.0) if size is None else size
    return np.abs(found - truth).max(initial=0.0) / max(largest, 1e-300)


def continuous_about(axis):
    """A joint without ends about any axis, which only URDF can say."""
    moments = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
    body = f'<inertial><mass value="1"/><inertia {moments}/></inertial>'
    model = pin.buildModelFromXML(
        f'<robot name="r"><link name="a"/><link name="b">{body}</link>'
        f'<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        f'<axis xyz="{axis}"/></joint></robot>'
    )
    return model.joints[1]


def hold_up(model, q, v, rng, responds=True):
    """Everything that the tree gives, beside Pinocchio."""
    model = pin.Model(model)
    model.gravity.linear = GRAVITY
    flat, data, nv = flat_model(model), model.createData(), model.nv
    pin.computeJointJacobians(model, data, q)
    found = flat.core.placements(q).reshape(-1, 12)[list(flat.bodies)]
    truth = np.array([[*m.rotation.ravel(), *m.translation] for m in data.oMi])
    assert off(found, truth) < EXACT
    columns, extended = np.zeros((6, nv)), data.J.reshape(6, -1)
    for joint in list(model.joints)[1:]:
        # A joint that follows another has columns of its own in Pinocchio's, and no speeds.
        for k in range(joint.nvExtended):
            columns[:, joint.idx_v + k] += extended[:, joint.idx_vExtended + k]
    assert off(flat.core.jacobian(q).reshape(6, nv), columns) < EXACT

    masses = np.triu(pin.crba(model, data, q))
    masses += np.triu(masses, 1).T
    assert off(flat.core.mass_matrix(q).reshape(nv, nv), masses) < EXACT
    bias = pin.rnea(model, data, q, v, np.zeros(nv))
    assert off(flat.core.bias(q, v, GRAVITY), bias) < EXACT
    if flat.core.has_followers or flat.core.has_ellipsoids or not responds:
        return
    # What M says of a blow on every body is what it was made from.
    impulse, wrenches = rng.normal(size=nv), rng.normal(size=(model.njoints - 1, 6))
    total, ids = impulse.copy(), range(1, model.njoints)
    for joint_id in ids:
        jacobian = pin.computeJointJacobian(model, data, q, joint_id).reshape(6, nv)
        total += jacobian.T @ wrenches[joint_id - 1]
    bodies = np.array(flat.bodies[1:], dtype=np.intc)
    found = flat.core.apply_impulses(q, v, impulse, bodies, wrenches.ravel())
    dv = found.dv
    size = np.abs(total).max() + (np.abs(masses) @ np.abs(dv)).max()
    assert off(masses @ dv, total, size) < EXACT
    twists, reactions = (x.reshape(-1, 6)[bodies - 1] for x in (found.twists, found.reactions))
    pin.forwardKinematics(model, data, q, v + dv)
    truth = [in_world(data.oMi[j], data.v[j]) for j in ids]
    assert off(twists, np.array(truth)) < 1e-12
    # Newton and Euler, with the wrenches from outside.
    forces = pin.StdVec_Force()
    forces.extend([pin.Force.Zero(), *map(pin.Force, wrenches)])
    model.gravity.setZero()
    pin.rnea(model, data, q, np.zeros(nv), dv, forces)
    truth = [in_world(data.oMi[j], data.f[j]) for j in ids]
    assert off(reactions, np.array(truth), size + np.abs(truth).max()) < 1e-12


def in_world(placement, vector):
    """(6,) a spatial vector of a joint in world axes, about the joint's origin."""
    turn = placement.rotation
    return np.concatenate([turn @ vector.linear, turn @ vector.angular])


@pytest.mark.parametrize("kind", list(KINDS))
def test_every_kind_of_joint(kind):
    rng = np.random.default_rng(list(KINDS).index(kind))
    for others in (["revolute", kind, "continuous", kind], [kind, "planar", kind, "prismatic"]):
        robot = random_robot(rng, others)
        q, v = random_configuration(robot, rng), rng.normal(size=robot.nv)
        hold_up(robot.model, q, v, rng)


def test_a_joint_without_ends_about_any_axis():
    rng, model, parent = np.random.default_rng(3), pin.Model(), 0
    for k, axis in enumerate(("0.6 0 0.8", "0.1 0.2 -0.3", "0 1 0")):
        parent = model.addJoint(parent, continuous_about(axis), pin.SE3.Random(), f"joint {k}")
        model.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Random())
    q = pin.integrate(model, pin.neutral(model), rng.uniform(-2, 2, model.nv))
    hold_up(model, q, rng.normal(size=model.nv), rng)


def test_a_body_without_mass_between_others():
    rng, model = np.random.default_rng(4), pin.Model()
    first = model.addJoint(0, pin.JointModelRX(), pin.SE3.Random(), "first")
    empty = model.addJoint(first, pin.JointModelRY(), pin.SE3.Random(), "empty")
    for k in range(2):
        last = model.addJoint(empty, pin.JointModelSpherical(), pin.SE3.Random(), f"last {k}")
        model.appendBodyToJoint(last, pin.Inertia.Random(), pin.SE3.Random())
    q = pin.integrate(model, pin.neutral(model), rng.uniform(-2, 2, model.nv))
    hold_up(model, q, rng.normal(size=model.nv), rng)


@pytest.mark.parametrize("name", ["panda", "tiago_pro"])
def test_joints_that_follow_others(name):
    robot = ik.Robot.from_example(name, mimic=True)
    assert flat_model(robot.model).core.has_followers
    hold_up(robot.model, *random_state(robot, 5), np.random.default_rng(5))


@pytest.mark.filterwarnings("ignore::impulsekit.errors.AssumptionWarning")
@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
def test_every_example_robot(root):
    for seed, name in enumerate(example_names()):
        robot = ik.Robot.from_example(name, root=root)
        if robot.nv:
            state, rng = random_state(robot, seed), np.random.default_rng(seed)
            hold_up(robot.model, *state, rng, name not in MASSLESS)


def test_far_away_and_far_turned():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    q, v = random_state(robot, 6)
    flat = flat_model(robot.model)
    near = flat.core.mass_matrix(q)
    far = q.copy()
    far[:3] += 1e6
    assert off(flat.core.mass_matrix(far), near) < EXACT
    # Beyond the reach of the polynomial's reduction, and just below it.
    arm = ik.Robot.from_example("panda")
    q, v = random_state(arm, 7)
    q[:4] = 99999.7, -1e5, 3e7, 1e12
    hold_up(arm.model, q, v, np.random.default_rng(7))


def test_what_does_not_fit_is_told():
    flat = flat_model(ik.Robot.from_example("panda").model)
    with pytest.raises(ValueError, match="q: expected 9 numbers"):
        flat.core.mass_matrix(np.zeros(3))
