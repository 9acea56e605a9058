"""Ctrl-C keeps what was computed; limits say which setting they are."""

import os
import pickle
import signal
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit import errors
from impulsekit.cli import main
from impulsekit.scene import MotionSettings

from .models import MODELS, sliders

INTERRUPTED = ik.MotionStatus.INTERRUPTED


@pytest.fixture(autouse=True)
def ctrl_c_interrupts():
    """A process that a shell starts in the background ignores Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_in_a_function_keeps_what_was_computed():
    def torque(t, q, v):
        if t > 0.3:
            raise KeyboardInterrupt
        return 1.0

    scene = ik.Scene(sliders(1), forces=[ik.Actuator("z00", torque)], gravity=[0, 0, 0])
    motion = ik.simulate(scene, [0.0], [0.0], duration=1.0, max_step=0.05)
    assert motion.status is INTERRUPTED
    assert 0.2 < motion.duration <= 0.3
    assert motion.v[-1, 0] == pytest.approx(motion.duration, rel=1e-12)


def test_an_interrupt_before_the_first_step_leaves_the_start():
    def torque(t, q, v):
        raise KeyboardInterrupt

    blow = ik.AppliedImpulse("b00", linear=[0, 0, 1])
    scene = ik.Scene(sliders(1), [blow], forces=[ik.Actuator("z00", torque)])
    motion = ik.simulate(scene, [0.2], [0.1], duration=1.0)
    assert motion.status is INTERRUPTED
    assert motion.t.tolist() == [0.0]
    assert motion.q.tolist() == [[0.2]]
    assert motion.v.tolist() == [[0.1]]
    assert motion.impacts == ()


@pytest.mark.slow
def test_the_command_writes_what_was_computed_and_fails(tmp_path):
    ball = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", origin=[0, 0, -1], restitution=1.0)])
    path, output = tmp_path / "scene.toml", tmp_path / "motion.npz"
    settings = MotionSettings(duration=1e4, max_step=1e-3, max_steps=10**7, max_impacts=10**7)
    ik.save_scene(path, scene, ball.neutral(), ball.velocity(), motion=settings)

    def strike():
        # What comes before the motion heeds it would end the command at once, or be lost.
        while signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            time.sleep(0.01)
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

    striking = threading.Thread(target=strike)
    striking.start()
    result = CliRunner().invoke(main, ["simulate", str(path), "-o", str(output)])
    striking.join()
    assert result.exit_code == 130
    assert INTERRUPTED.value in result.stderr
    motion = ik.Trajectory.load(output)
    assert motion.status is INTERRUPTED
    assert motion.duration > 0.0


def test_many_times_at_once():
    motion = ik.simulate(ik.Scene(sliders(2)), [0.0, 1.0], [1.0, 0.0], duration=1.0)
    times = [0.0, 0.25, 1.0]
    q, v = motion.at(times)
    assert q.shape == v.shape == (3, 2)
    for row, t in enumerate(times):
        np.testing.assert_array_equal(q[row], motion.at(t)[0])
        np.testing.assert_array_equal(v[row], motion.at(t)[1])
    assert motion.at(np.array([]))[0].shape == (0, 2)
    for bad, error in (([0.5, 2.0], errors.RangeError), ("0.5", errors.InputError)):
        with pytest.raises(error, match="time"):
            motion.at(bad)


def test_progress_that_fails_is_told():
    with pytest.raises(TypeError, match="positional argument") as caught:
        ik.simulate(ik.Scene(sliders(1)), [0.0], [0.0], progress=lambda: None)
    assert "raised in progress" in caught.value.__notes__[0]


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_that_is_dropped_is_heeded_at_the_next_step():
    class Dropping:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.01)

    def progress(t):
        if t > 0.5:
            Dropping()

    scene = ik.Scene(sliders(1))
    motion = ik.simulate(
        scene, [0.0], [0.0], duration=1.0, method="rk4", step=0.1, progress=progress
    )
    assert motion.status is INTERRUPTED
    assert motion.duration == pytest.approx(0.6)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_motion_that_ends_in_an_impact_ends_with_the_velocity_after_it():
    def progress(t):
        if t > 0.49:
            signal.raise_signal(signal.SIGINT)

    scene = ik.Scene(sliders(1), contacts=[ik.JointStop("z00", lower=0.0, restitution=0.5)])
    start = {"q": [1.0], "v": [-2.0], "duration": 2.0}
    motion = ik.simulate(replace(scene, gravity=(0.0, 0.0, 0.0)), **start, progress=progress)
    assert motion.status is INTERRUPTED
    ((t, impact),) = motion.impacts
    assert motion.t[-1] == t == pytest.approx(0.5)
    for told in (motion, pickle.loads(pickle.dumps(motion))):
        assert told.v[-1] == told.at(t)[1] == impact.v_after == pytest.approx(1.0)
        assert np.abs(told.balance().residual).max() < 1e-12
