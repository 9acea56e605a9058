"""Joints that mimic others, in kernels."""

import numpy as np
import pytest

import impulsekit as ik
from tests.batch.compare import random_states, worst_difference

pytest.importorskip("numba")


@pytest.mark.parametrize(
    ("name", "root"),
    [("panda", "fixed"), ("panda", "freeflyer"), ("tiago_pro", "fixed"), ("baxter", "fixed")],
)
def test_blows_and_contacts(name, root):
    robot = ik.Robot.from_example(name, root=root, mimic=True)
    frame = next(
        one.name
        for one in robot.links
        if one.joint_id == robot.model.mimicking_joints[0] and one.mass > 0
    )
    q, v = random_states(robot, 20, spread=0.3)
    blow = ik.AppliedImpulse(frame, [1, 2, 3], [0.1, 0.2, 0], at=[0.01, 0.02, 0])
    worst, _ = worst_difference(ik.Scene(robot, [blow]), q, v)
    assert worst < 1e-12
    contact = ik.Contact(frame, friction=0.3, restitution=0.4)
    worst, _batch = worst_difference(ik.Scene(robot, [blow], contacts=[contact]), q, v)
    assert worst < 1e-12


def test_constraints_keep_their_own_impulses():
    robot = ik.Robot.from_example("panda", mimic=True)
    anchor = ik.PointAnchor("panda_leftfinger", at=[0, 0, 0.05])
    q, v = random_states(robot, 20, spread=0.5)
    worst, batch = worst_difference(ik.Scene(robot, constraints=[anchor]), q, v)
    assert worst < 1e-12
    assert batch.constraint_impulses.shape == (20, 3)


def test_the_speed_of_a_follower_is_that_of_its_leader():
    tied = ik.Robot.from_example("panda", mimic=True)
    free = ik.Robot.from_example("panda")
    gear = ik.JointCoupling("panda_finger_joint2", "panda_finger_joint1", 1.0)
    blow = [ik.AppliedImpulse("panda_rightfinger", [0.2, 1, 0])]
    q, v = random_states(tied, 8)
    wide = [np.hstack([a, a[:, -1:]]) for a in (q, v)]
    few = ik.solve_batch(ik.Scene(tied, blow), q, v)
    many = ik.solve_batch(ik.Scene(free, blow, [gear]), *wide)
    assert few.v_after == pytest.approx(many.v_after[:, :-1], rel=1e-10)
