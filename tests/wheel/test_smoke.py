"""The installed package alone does each of its main jobs; run outside the checkout for a wheel.

Nothing of the checkout is read, and only what the package itself requires is imported.
"""

import importlib.metadata
import subprocess
import sys

import numpy as np
import pytest

import impulsekit as ik

BALL = """<robot name="ball"><link name="ball"><inertial><mass value="0.5"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.fixture
def ball():
    return ik.Robot.from_urdf(BALL, root="freeflyer")


def test_the_version_is_that_of_the_metadata():
    assert ik.__version__ == importlib.metadata.version("impulsekit")


def test_small_models_come_along():
    assert ik.Robot.from_file(ik.models.path("ball"), root="freeflyer").mass == 0.5


def test_a_bounce(ball):
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5)])
    impact = ik.solve(scene, ball.neutral(), ball.velocity(root_joint=[0, 0, -2, 0, 0, 0]))
    assert impact.status is ik.Status.SOLVED
    assert np.allclose(impact.v_after, [0, 0, 1, 0, 0, 0], atol=1e-14)


def test_a_blow_on_a_robot_of_the_example_package():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, impulses=[ik.AppliedImpulse("panda_hand", linear=[0, 0, -2])])
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    residual = impact.mass_matrix @ impact.dv - impact.generalized_impulse
    assert np.abs(residual).max() < 1e-12


def test_batches_run_on_every_instruction_set_of_this_processor(ball):
    from impulsekit._core import instruction_sets, use_instruction_set

    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5)])
    v = np.tile(ball.velocity(root_joint=[0, 0, -2, 0, 0, 0]), (20, 1))
    for name in instruction_sets():
        use_instruction_set(name)
        batch = ik.solve_batch(scene, ball.neutral(), v)
        assert batch.valid.all()
        assert np.allclose(batch.v_after[:, 2], 1.0, atol=1e-14)


def test_a_motion(ball):
    floor = ik.Contact("ball", restitution=0.5, name="floor")
    scene = ik.Scene(ball, contacts=[floor], gravity=[0, 0, -9.81])
    q = ball.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, ball.velocity(), duration=0.5)
    time, _ = motion.impacts[0]
    assert time == pytest.approx(np.sqrt(2 * 0.5 / 9.81), abs=1e-9)


def test_the_command():
    run = subprocess.run(
        [sys.executable, "-m", "impulsekit", "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert ik.__version__ in run.stdout
