"""Forces and [motion] in scene files, and the command that follows them."""

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main
from impulsekit.scene import MotionSettings

from .models import MODELS

FILE = f"""
[robot]
urdf = "{MODELS / "ball.urdf"}"
root = "freeflyer"

[state.q]
root_joint = [0, 0, 1, 0, 0, 0, 1]

[[contacts]]
name = "floor"
kind = "contact"
frame = "ball"
restitution = 0.9

[[forces]]
kind = "actuator"
joint = "root_joint"
torque = [0, 0, 0.25, 0, 0, 0]

[[forces]]
kind = "applied_force"
frame = "ball"
linear = [0, 0, -0.25]

[motion]
duration = 2.0
samples = 11
rtol = 1e-9
"""
SPRINGS = f"""
[robot]
urdf = "{MODELS / "four_bar.urdf"}"

[[forces]]
kind = "joint_spring"
joint = "crank_pin"
stiffness = 2
damping = 0.1
rest = 0.5

[[forces]]
kind = "spring"
frame = "coupler"
other_at = [0, 0, 1]
stiffness = 3

[[forces]]
kind = "actuator"
joint = "rocker_pin"
torque = {{ stiffness = 4, target = 0.3, limit = 2 }}
"""


def written(tmp_path, text):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    return path


def test_forces_and_motion_are_read(tmp_path):
    file = ik.load_scene(written(tmp_path, FILE))
    actuator, force = file.scene.forces
    assert actuator == ik.Actuator("root_joint", [0, 0, 0.25, 0, 0, 0])
    assert force == ik.AppliedForce("ball", linear=[0, 0, -0.25])
    assert file.motion == MotionSettings(duration=2.0, samples=11, rtol=1e-9)
    springs = ik.load_scene(written(tmp_path, SPRINGS))
    assert springs.motion is None
    assert springs.scene.forces == (
        ik.JointSpring("crank_pin", 2, 0.1, 0.5),
        ik.Spring("coupler", other_at=[0, 0, 1], stiffness=3),
        ik.Actuator("rocker_pin", ik.PD(4, target=0.3, limit=2)),
    )


@pytest.mark.parametrize("text", [FILE, SPRINGS], ids=["file", "springs"])
def test_they_come_back_the_same(tmp_path, text):
    file = ik.load_scene(written(tmp_path, text))
    again = tmp_path / "again.toml"
    ik.save_scene(again, file.scene, file.q, file.v, motion=file.motion)
    read = ik.load_scene(again)
    assert read.scene.forces == file.scene.forces
    assert read.motion == file.motion


def test_all_faults_are_told_with_their_places(tmp_path):
    text = SPRINGS.replace("stiffness = 3", "stifness = 3").replace("rest = 0.5", "rest = true")
    text += '[motion]\nduration = -1\nmethod = "eule"\nsample = 3\n'
    with pytest.raises(ik.errors.SceneFileError) as caught:
        ik.load_scene(written(tmp_path, text))
    faults = "\n".join(caught.value.faults)
    for words in (
        "forces[0].rest",
        'forces[1].stifness: no such key; did you mean "stiffness"?',
        "motion.duration",
        'motion.sample: no such key; did you mean "samples"?',
    ):
        assert words in faults


def test_the_command_follows_and_writes(tmp_path):
    output = tmp_path / "out.npz"
    arguments = ["simulate", str(written(tmp_path, FILE)), "-o", str(output)]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert "0.451523641" in result.stdout
    motion = ik.Trajectory.load(output)
    assert motion.t.tolist() == np.linspace(0, 2, 11).tolist()
    result = CliRunner().invoke(main, [*arguments[:2], "-t", "0.5", "-n", "3"])
    assert "0.5 s, 3 states" in result.stdout


def test_the_command_says_why_it_stopped(tmp_path):
    path = written(tmp_path, FILE + "max_impacts = 1\n")
    result = CliRunner().invoke(main, ["simulate", str(path)])
    assert result.exit_code == 1
    assert "largest number of impacts" in result.stderr
    assert "stopped at 1.26427 s" in result.stderr
    result = CliRunner().invoke(main, ["simulate", str(path), "-t", "-1"])
    assert result.exit_code == 2
    assert "duration" in result.stderr
