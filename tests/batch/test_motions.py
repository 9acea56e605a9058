"""Many motions at once are those of ``simulate``, whatever becomes of rows."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit import errors
from impulsekit.cli import main

MODELS = pathlib.Path(__file__).parents[2] / "models"
BALL = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
FLOOR = ik.Contact("ball", restitution=0.6, friction=0.3, at=[0, 0, -0.05], name="floor")
SCENE = ik.Scene(BALL, contacts=[FLOOR])


def drops(count, seed=0):
    """(count, nq), (count, nv) of balls above the floor."""
    rng = np.random.default_rng(seed)
    q = np.tile(BALL.neutral(), (count, 1))
    q[:, 2] = rng.uniform(0.1, 0.4, count)
    return q, rng.normal(size=(count, BALL.nv))


def test_rows_are_the_motions_of_simulate_bit_for_bit():
    q, v = drops(6)
    restitution = np.linspace(0.1, 0.7, 6)[:, None]
    batch = ik.simulate_batch(
        SCENE, q, v, restitution=restitution, masses={"ball": 2.0}, duration=0.5, samples=9,
        threads=2,
    )  # fmt: skip
    assert batch.finished.all() and len(batch) == 6
    at = 0
    for row in range(6):
        motion = batch.motion(row)
        (contact,) = motion.scene.contacts
        assert contact.restitution == restitution[row, 0]
        assert motion.scene.robot.mass == pytest.approx(2.0 * BALL.mass)
        np.testing.assert_array_equal(motion.t, batch.t)
        np.testing.assert_array_equal(motion.q, batch.q[row])
        np.testing.assert_array_equal(motion.v, batch.v[row])
        np.testing.assert_array_equal(motion.at(0.5)[0], batch.q_end[row])
        hits = batch.impacts
        for time_hit, impact in motion.impacts:
            assert (hits.row[at], hits.time[at]) == (row, time_hit)
            np.testing.assert_array_equal(hits.v_after[at], impact.v_after)
            np.testing.assert_array_equal(hits.impulse[at, 0], impact.contacts[0].impulse)
            at += 1
    assert at == len(batch.impacts) > 6
    # In this process they are the same.
    here = ik.simulate_batch(
        SCENE, q, v, restitution=restitution, masses={"ball": 2.0}, duration=0.5, samples=9,
        threads=1,
    )  # fmt: skip
    np.testing.assert_array_equal(here.q, batch.q)
    np.testing.assert_array_equal(here.impacts.impulse, batch.impacts.impulse)
    with pytest.raises(ValueError):
        batch.q[0] = 0.0


@pytest.mark.parametrize("threads", [1, 2])
def test_rows_that_are_wrong_are_told_and_stop_nothing(threads):
    q, v = drops(5)
    q[0, 6] = 3.0
    v[1, 0] = np.nan
    q[2, 2] = -1.0
    friction = np.array([[0.3], [0.3], [0.3], [-1.0], [0.3]])
    batch = ik.simulate_batch(
        SCENE, q, v, friction=friction, duration=0.3, samples=3, threads=threads
    )
    assert batch.count() == {ik.MotionStatus.FINISHED: 1, ik.MotionStatus.REFUSED: 4}
    for row, word in enumerate(("quaternion", "nan", "penetration", "range")):
        assert word in batch.detail[row].lower()
        assert np.isnan(batch.q[row]).all() and np.isnan(batch.end[row])
    np.testing.assert_array_equal(batch.q[4], batch.motion(4).q)
    with pytest.raises(errors.StateError):
        batch.motion(0)
    with pytest.raises(errors.RangeError, match="0 to 4"):
        batch.motion(5)


def test_a_motion_that_is_stopped_keeps_what_there_was():
    q, v = drops(2)
    batch = ik.simulate_batch(
        SCENE, q, 0.0 * v, duration=3.0, samples=31, restitution=[[0.0], [0.9]], max_impacts=3,
        threads=1,
    )  # fmt: skip
    assert [status.name for status in batch.count()] == ["FINISHED", "EVENT_STORM"]
    assert batch.end[0] == 3.0 and 0.0 < batch.end[1] < 3.0
    np.testing.assert_array_equal(np.isfinite(batch.q[1, :, 0]), batch.t <= batch.end[1])
    assert np.isfinite(batch.q_end).all()


def test_scenes_with_functions_are_followed_and_told_of():
    push = ik.AppliedForce("ball", linear=lambda t: (t, 0, 0))
    scene = ik.Scene(BALL, contacts=[FLOOR], forces=[push])
    q, v = drops(2)
    batch = ik.simulate_batch(scene, q, v, duration=0.2, samples=2)
    assert batch.finished.all()

    def fails(t):
        raise ValueError("no force today")

    scene = ik.Scene(BALL, forces=[ik.AppliedForce("ball", linear=fails)])
    with pytest.raises(errors.CallbackError, match="no force today"):
        ik.simulate_batch(scene, q, v, duration=0.2)


SCRIPT = """
import numpy as np, impulsekit as ik
swing = ik.Scene(ik.Robot.from_urdf(ik.models.pendulum_urdf(2)))
start = np.tile(swing.robot.configuration(joint_1=1.0), (4, 1))
print("go", flush=True)
batch = ik.simulate_batch(swing, start, duration=1e6, samples=3, threads=2, max_steps=10**9)
print([s.name for s in batch.count()], np.isfinite(batch.q_end[:, 0]).sum(),
      batch.end[:2].min() > 0, flush=True)
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_keeps_what_was_computed(tmp_path):
    script = tmp_path / "run.py"
    script.write_text(SCRIPT)
    run = subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        text=True,
        # Jobs in the background ignore Ctrl-C, and so would this.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        assert run.stdout.readline() == "go\n"
        time.sleep(1.0)
        run.send_signal(signal.SIGINT)
        told = run.stdout.read()
        assert run.wait(30) == 0
    finally:
        run.kill()
    assert told.startswith("['INTERRUPTED'] 2 True")


STUDY = f"""
[robot]
urdf = "{MODELS / "ball.urdf"}"
root = "freeflyer"

[state.q]
root_joint = [0, 0, 0.3, 0, 0, 0, 1]

[[contacts]]
kind = "contact"
name = "floor"
frame = "ball"

[motion]
duration = 0.5
samples = 3

[batch]
motion = true
samples = 5
chunk = 8
outputs = ["end", "q_end", "impact_count", "contact_impulses", "q_samples"]

[[batch.vary]]
what = "restitution"
low = 0.1
high = 0.8
"""


@pytest.mark.slow
def test_a_study_of_motions_goes_to_a_store(tmp_path):
    file = tmp_path / "drops.toml"
    file.write_text(STUDY)
    done = CliRunner().invoke(main, ["batch", str(file), "-q", "--threads", "1"])
    assert done.exit_code == 0 and "5  FINISHED" in done.output
    rows = ik.study.open_study(tmp_path / "drops_rows")
    study = ik.study.load_study(file)
    batch = ik.simulate_batch(study.scene, **study.drawn(0), settings=study.motion, threads=1)
    np.testing.assert_array_equal(rows["q_end"], batch.q_end)
    np.testing.assert_array_equal(rows["q_samples"], batch.q)
    # Momentum: what the floor gave in impacts stops what fell, but for the rest on it.
    for row in range(5):
        own = batch.impacts.row == row
        np.testing.assert_allclose(
            rows["contact_impulses"][row, 0], batch.impacts.impulse[own, 0].sum(axis=0)
        )
        assert rows["impact_count"][row] == own.sum()
    # The same command again has nothing to do; another duration is another study.
    assert CliRunner().invoke(main, ["batch", str(file), "-q"]).exit_code == 0
    file.write_text(STUDY.replace("duration = 0.5", "duration = 0.6"))
    other = CliRunner().invoke(main, ["batch", str(file), "-q"])
    assert other.exit_code != 0 and "another study: motion" in other.stderr
    file.write_text(STUDY.replace('"end", ', '"ends", '))
    wrong = CliRunner().invoke(main, ["batch", str(file), "-q"])
    assert wrong.exit_code != 0 and '"ends"' in wrong.stderr
