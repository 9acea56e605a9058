"""From recordings to coefficients: whole motions, the command, and what is said of bad ones."""

import json
import re
from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main
from impulsekit.errors import ImpulsekitError, InputError
from impulsekit.measured import fit_motion, identify
from tests.measured.bodies import ball_scene, bouncing_ball

BOUNCE = ("examples/one_bounce.csv", "examples/dropped_ball.toml")
SIGMA = np.array([3e-4] * 3 + [3e-3] * 3)


@pytest.fixture(scope="module")
def balls():
    """The scene, with other coefficients, of balls that are dropped, and their recordings."""
    scene, rng = ball_scene(0.3, 0.0), np.random.default_rng(0)
    heights = 0.2 + 0.03 * np.arange(10)
    return scene, [bouncing_ball(scene, h, 0.62, 150, 0.6, SIGMA, rng)[0] for h in heights]


def test_whole_motions_give_a_coefficient_back(balls):
    scene, recordings = balls
    found = identify(recordings, scene, friction=[], calibration=False, held_out=0.2, threads=1)
    fit = found.by_motion
    assert fit["floor: restitution"] == pytest.approx(0.62, abs=0.01)
    assert len(fit.held_out) == 2 and fit.held_out[:, 0].max() < 0.01
    text = found.report()
    assert "Fitted to whole motions" in text and "held out (2)" in text


def run(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments], prog_name="impulsekit")


@pytest.mark.slow
def test_the_command_on_recorded_tosses(tmp_path):
    pytest.importorskip("matplotlib")
    out, picture = tmp_path / "a.json", tmp_path / "a.png"
    done = run("identify", "examples/cube_tosses.npz", "examples/cube_tosses.toml", "--no-motions",
               "--json", out, "--plot", picture)  # fmt: skip
    data = json.loads(out.read_text())
    # The mass centre of the real cube is some 6 mm off its centre: all 120 tosses say 6.0 +- 0.4.
    assert data["calibration"]["mass_centre"]["value"][2] == pytest.approx(0.006, abs=0.002)
    assert data["calibration"]["length_scale"]["value"] == pytest.approx(0.98, abs=0.004)
    assert data["calibration"]["velocity_lag"]["value"] == pytest.approx(0.0034, abs=3e-4)
    assert "12 recordings" in done.stdout and picture.stat().st_size > 10_000


@pytest.mark.parametrize(
    ("option", "value"),
    [("held-out", "2"), ("held-out", "nan"), ("threads", "0"), ("seed", "-1")],
)
def test_a_choice_that_cannot_be_is_refused_before_any_work(option, value):
    start = process_time()
    done = run("identify", "examples/cube_tosses.npz", "examples/cube_tosses.toml",
               f"--{option}", value)  # fmt: skip
    assert done.exit_code == 2 and f"error: --{option} must be" in done.stderr
    assert process_time() - start < 5.0


@pytest.mark.parametrize(
    ("header", "rest", "message"),
    [
        ("quaternion", "0", "give --quaternion xyzw or --quaternion wxyz"),
        ("quaternion_xyzw", "nan", "--repair gaps leaves them out"),
        ("quaternion_xyzw [mm]", "0", "state --length mm"),
    ],
)
def test_errors_of_the_command_name_its_options(tmp_path, header, rest, message):
    name, _, unit = header.partition(" ")
    names = [
        "t",
        *(f"position.{c} {unit}".strip() for c in "xyz"),
        *(f"{name}.{c}" for c in "xyzw"),
    ]
    rows = [",".join(names), "0,0,0,1,0,0,0,1", f"0.1,{rest},0,0.9,0,0,0,1"]
    (tmp_path / "a.csv").write_text("\n".join(rows))
    done = run("identify", tmp_path / "a.csv", BOUNCE[1])
    assert done.exit_code == 2 and message in done.stderr
    assert not re.search(r"RecordingFormat|repair=|quaternion=|length=", done.stderr)


def test_an_unknown_contact_is_no_matter_of_a_function():
    done = run("identify", *BOUNCE, "--restitution", "nope")
    assert done.stderr.startswith('error: unknown contact "nope"; choose "floor"')


def test_contacts_that_share_a_coefficient(balls):
    scene, _ = balls
    pair = ik.Scene(
        scene.robot,
        contacts=[
            ik.Contact("ball", at=[s, 0, -0.05], restitution=0.4, friction=0.2, name=f"foot_{i}")
            for i, s in enumerate((-0.02, 0.02))
        ],
    )
    truth = ik.Scene(
        scene.robot,
        contacts=[
            ik.Contact("ball", at=each.at, restitution=0.7, friction=0.1, name=each.name)
            for each in pair.contacts
        ],
    )
    rng, seen = np.random.default_rng(1), []
    for k in range(8):
        one = ik.Scene(scene.robot, contacts=[pair.contacts[k % 2]])
        true = ik.Scene(scene.robot, contacts=[truth.contacts[k % 2]])
        v = np.r_[rng.uniform(2, 4, 2), -rng.uniform(1, 2), rng.normal(size=3)]
        after = ik.solve(true, scene.robot.neutral(), v).v_after
        seen.append(ik.measured.Measurement(one, scene.robot.neutral(), v, after, 1e-3))
    fit = ik.measured.fit_impacts(seen, restitution=["foot_*"], friction=[("foot_0", "foot_1")])
    assert fit.names == ("foot_*: restitution", "foot_0, foot_1: friction")
    assert fit.values == pytest.approx([0.7, 0.1], abs=1e-6)
    with pytest.raises(InputError, match="name it once"):
        ik.measured.fit_impacts(seen, friction=["foot_*", "foot_0"])


def test_what_identify_cannot_take_is_said(balls):
    scene, recordings = balls
    with pytest.raises(InputError, match="takes a Scene, not an int"):
        identify(recordings, 3)
    for bad in (None, [3], recordings[0].q):
        with pytest.raises(InputError, match="takes Recordings, not"):
            identify(bad, scene)
    for share in (2.0, float("nan"), "a"):
        with pytest.raises(ImpulsekitError, match="held_out"):
            identify(recordings, scene, held_out=share)
    with pytest.raises(
        InputError, match=r'takes a list of contacts, got "floor"; give \["floor"\]'
    ):
        fit_motion(recordings, scene, friction="floor")


def test_one_bounce_of_one_recording_gives_a_restitution():
    result = run("identify", *BOUNCE, "--json", "-")
    assert result.exit_code == 0
    fitted = json.loads(result.stdout)["by_impact"]["parameters"]["floor: restitution"]
    low, high = fitted["interval"]
    assert low < 0.82 < high and high - low < 0.01


def test_what_is_not_determined_is_a_dash_and_stays_as_it_was():
    file = ik.load_scene(BOUNCE[1])
    ball = [replace(file.scene.contacts[0], restitution=0.5, friction=0.1)]
    scene = file.scene.replace(contacts=ball)
    found = identify(ik.measured.load_recordings(BOUNCE[0], scene.robot), scene)
    assert re.search(r"floor: friction +- +not determined", found.report())
    parameters = found.to_dict()["by_impact"]["parameters"]
    assert parameters["floor: friction"]["value"] is None
    assert found.scene.contacts[0].friction == 0.1
    assert found.scene.contacts[0].restitution == pytest.approx(0.82, abs=5e-3)
