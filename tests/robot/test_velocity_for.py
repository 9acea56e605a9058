"""Jacobians of frames, and the velocity that moves a frame as asked."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors

TALOS = ik.Robot.from_example("talos", root="freeflyer")


def test_a_jacobian_is_the_slope_of_the_placement():
    """Against differences of the point's place and of the frame's rotation."""
    rng = np.random.default_rng(3)
    q = pin.integrate(TALOS.model, TALOS.poses["half_sitting"], 0.2 * rng.normal(size=TALOS.nv))
    v, at, step = rng.normal(size=TALOS.nv), [0.1, -0.2, 0.3], 1e-6
    places = [
        TALOS.placement(pin.integrate(TALOS.model, q, s * step * v), "gripper_left_base_link")
        for s in (1, -1)
    ]
    found = TALOS.jacobian(q, "gripper_left_base_link", at) @ v
    moved = (places[0].point(at) - places[1].point(at)) / (2 * step)
    turned = pin.log3(places[0].se3.rotation @ places[1].se3.rotation.T) / (2 * step)
    np.testing.assert_allclose(found, [*moved, *turned], atol=1e-8)
    same = TALOS.velocity_of(q, v, "gripper_left_base_link", at)
    np.testing.assert_allclose(found, [*same.linear, *same.angular], atol=1e-13)


@pytest.mark.parametrize(
    "given",
    [
        {"linear": [0.5, 0, 0]},
        {"angular": [0, 1, 0]},
        {"linear": [0.1, 0.2, 0.3], "angular": [0, 0, 0]},
    ],
)
def test_the_velocity_is_the_least_that_moves_the_frame_so(given):
    q = TALOS.poses["half_sitting"]
    v = TALOS.velocity_for("left_sole_link", q=q, at=[0, 0, 0.1], **given)
    got = TALOS.velocity_of(q, v, "left_sole_link", [0, 0, 0.1])
    for name, asked in given.items():
        np.testing.assert_allclose(getattr(got, name), asked, atol=1e-12)
    # Any other has a part in the null space, which is orthogonal to this one.
    J = TALOS.jacobian(q, "left_sole_link", [0, 0, 0.1])
    rows = np.concatenate([J[{"linear": slice(3), "angular": slice(3, 6)}[k]] for k in given])
    null = np.linalg.svd(rows)[2][len(rows) :]
    np.testing.assert_allclose(null @ v, 0.0, atol=1e-12)


def test_joints_that_may_not_move_stay():
    arm = ik.Robot.from_example("ur5")
    q = arm.configuration(shoulder_lift_joint=-1.0, elbow_joint=1.2, wrist_1_joint=0.4)
    joints = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint")
    v = arm.velocity_for("tool0", linear=[0.1, 0.2, -0.1], q=q, joints=joints)
    assert not v[3:].any() and v[:3].all()


def test_what_cannot_be_is_refused():
    arm = ik.Robot.from_example("ur5")
    q = arm.configuration(shoulder_lift_joint=-1.0)
    with pytest.raises(errors.InputError, match="cannot move"):
        arm.velocity_for("tool0", linear=[1, 1, 1], q=q, joints=["elbow_joint"])
    with pytest.raises(errors.InputError, match="linear=, angular="):
        arm.velocity_for("tool0", q=q)
    with pytest.raises(errors.UnknownNameError, match='"tool0"'):
        arm.velocity_for("tool", linear=[1, 0, 0], q=q)
    with pytest.raises(errors.ShapeError):
        arm.jacobian([0.0], "tool0")
