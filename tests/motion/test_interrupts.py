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


@pytest.fixture(scope="module")
def tumble():
    """A box on four corners that is thrown, its start, and the motion to its end."""
    box = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
    corners = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
    contacts = [
        ik.Contact("box", at=at, origin=[0, 0, 0], restitution=0.5, friction=0.3) for at in corners
    ]
    scene = ik.Scene(box, contacts=contacts, law=ik.Law("poisson"))
    q = box.configuration(root_joint=[0, 0, 0.4, 0.1, 0.2, 0.05, np.sqrt(1 - 0.0525)])
    v = box.velocity(root_joint=[1.0, 0, 0, 0, 3.0, 1.0])
    return scene, q, v, ik.simulate(scene, q, v, duration=0.8, max_impacts=40)


def is_beginning_of(part, whole):
    """Whether a motion is the first part of another, and in order by itself."""
    assert part.duration <= whole.duration
    assert part.t[-1] == part.duration
    count = len(part.impacts)
    expected = [t for t, _ in whole.impacts[:count]]
    assert [t for t, _ in part.impacts] == pytest.approx(expected, rel=1e-12)
    times = np.linspace(0.0, part.duration, 7)[:-1]
    for ours, theirs in zip(part.at(times), whole.at(times), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11)
    assert np.isfinite(part.energy().total).all()
    return True


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("seed", range(4))
def test_an_interrupt_at_any_moment_keeps_what_was_computed(tumble, seed):
    scene, q, v, whole = tumble
    begin = time.perf_counter()
    ik.simulate(scene, q, v, duration=0.8, max_impacts=40)
    wait = np.random.default_rng(seed).uniform(0.0, 0.8) * (time.perf_counter() - begin)
    # Only once the motion is under way: before, there is nothing to keep.
    started = threading.Event()

    def strike():
        started.wait()
        time.sleep(wait)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=strike)
    thread.start()
    try:
        motion = ik.simulate(
            scene, q, v, duration=0.8, max_impacts=40, progress=lambda t: started.set()
        )
        # Where it came too late for the motion it comes here.
        thread.join()
        time.sleep(0.01)
    except KeyboardInterrupt:
        thread.join()
        return
    # Python drops what comes in a finalizer; in the last step of all it may be of no matter.
    assert motion.status is INTERRUPTED or motion.duration == whole.duration
    assert is_beginning_of(motion, whole)


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
    for bad, error in (
        ([0.5, 2.0], errors.RangeError),
        ([0.5, np.nan], errors.RangeError),
        (["0.5"], errors.NotFiniteError),
        (True, errors.NotFiniteError),
        ("0.5", errors.NotFiniteError),
        (None, errors.NotFiniteError),
        ([[0.5]], errors.ShapeError),
    ):
        with pytest.raises(error, match="time"):
            motion.at(bad)


def test_progress_that_fails_is_told():
    with pytest.raises(errors.CallbackError, match="progress: its function raised TypeError"):
        ik.simulate(ik.Scene(sliders(1)), [0.0], [0.0], progress=lambda: None)


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
