"""What one asks of a motion besides its course: its error, a recording beside it, its progress."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors

from .models import MODELS, sliders

BALL = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")


def bouncing(**settings):
    scene = ik.Scene(BALL, contacts=[ik.Contact("ball", restitution=0.7, name="floor")])
    q = BALL.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    return ik.simulate(scene, q, BALL.velocity(), duration=1.2, samples=25, **settings)


@pytest.mark.parametrize("rtol", [1e-4, 1e-7])
def test_the_estimated_error_is_that_against_a_far_closer_run(rtol):
    swing = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    q = swing.configuration(joint_1=2.0, joint_2=-1.0)
    given = {"duration": 3.0, "samples": 31, "atol": 1e-3 * rtol}
    motion = ik.simulate(ik.Scene(swing), q, swing.velocity(), rtol=rtol, **given)
    truth = ik.simulate(ik.Scene(swing), q, swing.velocity(), rtol=1e-13, **given | {"atol": 1e-14})
    error = np.abs(motion.q - truth.q).max()
    found = ik.check(motion)
    assert found.comparable.all() and found.same_impacts
    assert 0.3 * error < found.position_error < 3.0 * error
    assert found.second.settings.rtol == pytest.approx(0.1 * rtol)
    # And it falls with the tolerance.
    assert found.position_error < 1e3 * rtol


def test_a_check_starts_before_the_impulses_and_tells_of_impacts():
    scene = ik.Scene(
        BALL,
        [ik.AppliedImpulse("ball", linear=[0.1, 0, 0])],
        contacts=[ik.Contact("ball", restitution=0.7)],
    )
    q = BALL.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, BALL.velocity(), duration=0.9, samples=10, rtol=1e-6)
    found = ik.check(motion)
    assert found.impacts == (len(motion.impacts),) * 2
    assert found.position_error < 1e-9 and found.impact_times.max() < 1e-9
    assert found.position.shape == found.velocity.shape == found.t.shape == (10,)
    with pytest.raises(ValueError):
        found.position[0] = 0.0


def test_a_fixed_step_is_halved():
    robot = sliders(1)
    spring = ik.JointSpring("z00", stiffness=30.0)
    scene = ik.Scene(robot, forces=[spring], gravity=[0, 0, 0])
    motion = ik.simulate(scene, [0.3], [0.0], duration=2.0, method="rk4", step=0.02)
    truth = 0.3 * np.cos(np.sqrt(30.0) * motion.t)
    found = ik.check(motion)
    assert found.second.settings.step == 0.01
    error = np.abs(motion.q[:, 0] - truth).max()
    assert found.position_error == pytest.approx(error * 15 / 16, rel=0.1)


def test_what_cannot_be_checked_is_told():
    with pytest.raises(errors.InputError, match="EVENT_STORM"):
        ik.check(bouncing(max_impacts=1))
    with pytest.raises(errors.InputError, match="1e-13"):
        ik.check(bouncing(rtol=1e-13))


def test_settings_come_back_from_a_file(tmp_path):
    motion = bouncing(rtol=1e-8, stop_times=[0.3])
    motion.save(tmp_path / "m.npz")
    assert ik.Trajectory.load(tmp_path / "m.npz").settings == motion.settings


def test_a_recording_is_compared_in_place_and_turn():
    spin = 2.0
    v = BALL.velocity(root_joint=[1.0, 0, 0, 0, 0, spin])
    motion = ik.simulate(
        ik.Scene(BALL, gravity=[0, 0, 0]), BALL.neutral(), v, duration=1.0, samples=11
    )
    # A camera that sees the ball stand still where it was.
    times = np.linspace(-0.5, 1.5, 21)
    still = ik.measured.Recording(BALL, times, np.tile(BALL.neutral(), (21, 1)))
    found = motion.compare(still)
    assert found.t[0] == 0.0 and found.t[-1] == 1.0 and found.frame == "ball"
    np.testing.assert_allclose(found.rotation, spin * found.t, atol=1e-9)
    np.testing.assert_allclose(found.position, 1.0 * found.t, atol=1e-9)
    assert found.rms_rotation == pytest.approx(np.sqrt(np.mean((spin * found.t) ** 2)))
    again = motion.compare(motion)
    assert again.position.max() == 0.0 and again.rotation.max() < 1e-15


def test_progress_is_a_bar_on_stderr(capsys):
    motion = bouncing(progress=True)
    told = capsys.readouterr()
    assert motion.status.finished and told.out == ""
    assert "1.2 of 1.2 s" in told.err
    bouncing(progress=False)
    assert capsys.readouterr().err == ""
    with pytest.raises(errors.InputError, match="progress"):
        bouncing(progress=3)
