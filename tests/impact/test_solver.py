"""What solve takes, refuses and keeps."""

from __future__ import annotations

import gc
import math
import threading
import weakref

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors
from tests.reference.models import joint, link, robot
from tests.robots import STRUCK, random_blow, random_state


@pytest.fixture(scope="module")
def talos() -> ik.Scene:
    robot = ik.Robot.from_example("talos", root="freeflyer")
    return ik.Scene(robot, [random_blow(STRUCK["talos"], 0)])


def test_the_answer_is_read_only_and_apart_from_what_was_given(talos):
    q, v = random_state(talos.robot, 0)
    impact = ik.solve(talos, q, v)
    before = impact.q.copy()
    q[:] = 0.0
    np.testing.assert_array_equal(impact.q, before)
    for array in (impact.q, impact.v_before, impact.dv, impact.v_after, impact.momentum_after):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_a_joint_that_moves_no_inertia_is_named():
    text = robot(
        '<link name="base"/>',
        link("arm"),
        '<link name="tip"/>',
        joint("shoulder", "base", "arm", "continuous"),
        joint("wrist", "arm", "tip", "continuous"),
    )
    bare = ik.Robot.from_urdf(text)
    scene = ik.Scene(bare, [ik.AppliedImpulse("arm", angular=[0, 0, 1])])
    with pytest.raises(
        errors.SingularMassError, match='joint "wrist" moves no mass: give link "tip"'
    ) as caught:
        ik.solve(scene, bare.neutral(), bare.velocity())
    assert caught.value.joints == ("wrist",)


def test_a_massless_gimbal_is_singular_only_where_its_axes_meet():
    """Three hinges with massless links between stand for a ball joint, but not everywhere."""
    model = pin.Model()
    joint = 0
    for name, kind in (("z", pin.JointModelRZ), ("y", pin.JointModelRY), ("x", pin.JointModelRX)):
        joint = model.addJoint(joint, kind(), pin.SE3.Identity(), name)
    model.appendBodyToJoint(joint, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    model.addFrame(pin.Frame("body", joint, 0, pin.SE3.Identity(), pin.FrameType.BODY))
    robot = ik.Robot.from_model(model)
    scene = ik.Scene(robot, [ik.AppliedImpulse("body", angular=[1, 2, 3])])
    away = ik.solve(scene, robot.configuration(y=0.3), robot.velocity())
    np.testing.assert_allclose(away.bodies["body"].domega, [1, 2, 3], rtol=1e-13)
    with pytest.raises(errors.SingularMassError):
        ik.solve(scene, robot.configuration(y=math.pi / 2), robot.velocity())


def test_threads_do_not_meet(talos):
    robot = talos.robot
    states = [random_state(robot, seed) for seed in range(8)]
    expected = [ik.solve(talos, *state).dv for state in states]
    wrong = []

    def work(i: int) -> None:
        for _ in range(50):
            impact = ik.solve(talos, *states[i])
            if not np.array_equal(impact.dv, expected[i]):
                wrong.append(i)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_a_scene_is_freed_with_all_that_was_made_of_it():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5)], gap_bound=1)
    q = ball.configuration(root_joint=[0, 0, 0.01, 0, 0, 0, 1])
    v = ball.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    motion = ik.simulate(scene, q, v, 0.05)
    gone = [weakref.ref(scene), weakref.ref(motion.impacts[0][1].scene)]
    ik.solve(scene, motion.impacts[0][1].q, v)
    ik.solve_batch(scene, q[None], v[None])
    del scene, motion
    gc.collect()
    assert [ref() for ref in gone] == [None, None]
