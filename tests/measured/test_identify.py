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
from impulsekit.design.parameters import changed_scene, parameters_of
from impulsekit.errors import ImpulsekitError, InputError
from impulsekit.measured import Recording, fit_motion, identify
from impulsekit.measured.rollouts import Rollouts
from tests.measured.bodies import G, ball_scene, bouncing_ball, noisy

SIGMA = np.array([3e-4] * 3 + [3e-3] * 3)


def skidding_balls(e, mu, count, rng):
    """Balls that bounce once, skid or stick there and spin afterwards, in closed form."""
    scene = ball_scene(0.3, 0.4)
    radius, share = 0.05, 2.0 / 7.0
    inertia = scene.robot.model.inertias[1]
    share = 1.0 / (1.0 + inertia.mass * radius**2 / inertia.inertia[0, 0])
    found = []
    for k in range(count):
        t = np.arange(int(0.44 * 150)) / 150
        z, speed, at, x, slip, spin = 0.25 + 0.02 * k, 0.0, 0.0, 0.0, 3.0 + 0.15 * k, 0.0
        q, angle = np.zeros((len(t), 7)), 0.0
        for i, time in enumerate(t):
            while True:
                fall = (speed + np.sqrt(speed**2 + 2 * G * z)) / G
                if time - at <= fall:
                    break
                at, x, angle = at + fall, x + slip * fall, angle + spin * fall
                down = G * fall - speed
                # The contact point slips by v - R w; friction takes what its cone allows.
                rubbed = min(mu * (1 + e) * down, share * (slip - radius * spin))
                slip -= rubbed
                spin += rubbed * inertia.mass * radius / inertia.inertia[0, 0]
                z, speed = 0.0, e * down
            late = time - at
            turned = angle + spin * late
            q[i] = [x + slip * late, 0, radius + z + speed * late - 0.5 * G * late**2,
                    0, np.sin(turned / 2), 0, np.cos(turned / 2)]  # fmt: skip
        q = noisy(scene.robot.model, q, SIGMA, rng)
        found.append(Recording(scene.robot, t, q, name=f"ball {k}"))
    return scene, found


@pytest.fixture(scope="module")
def balls():
    return skidding_balls(0.62, 0.11, 12, np.random.default_rng(0))


@pytest.mark.slow
def test_whole_motions_give_a_coefficient_back(balls):
    scene, recordings = balls
    scene = ik.Scene(
        scene.robot, contacts=[replace(scene.contacts[0], restitution=0.62)], gravity=scene.gravity
    )
    short = [each.part(0.0, 0.4) for each in recordings]
    found = identify(short, scene, restitution=[], friction=["floor"], calibration=False, threads=1)
    fit = found.by_motion
    assert fit["floor: friction"] == pytest.approx(0.11, abs=0.01)
    assert len(fit.held_out) == 3 and fit.held_out[:, 0].max() < 0.01
    text = found.report()
    assert "Fitted to whole motions" in text and "held out (3)" in text


def balls_with_e_by_speed(count):
    """Balls up to their second bounce, e from 0.6 at 1 m/s to 0.4 at 3 m/s, and their scene."""
    scene, rng = ball_scene(mu=0.0), np.random.default_rng(1)
    table = ik.RestitutionTable([1.0, 3.0], [0.3, 0.3])
    floor = replace(scene.contacts[0], restitution=table)
    scene = ik.Scene(scene.robot, contacts=[floor], gravity=scene.gravity)

    def e(speed):
        return 0.6 - 0.1 * (np.clip(speed, 1.0, 3.0) - 1.0)

    seen = [
        bouncing_ball(scene, h, e, 200, 2.0 * np.sqrt(2 * h / G), 0.1 * SIGMA, rng)[0]
        for h in np.linspace(0.06, 0.5, count)
    ]
    return scene, seen


def test_motions_follow_e_by_speed():
    scene, seen = balls_with_e_by_speed(3)
    parameters = parameters_of(scene, ["floor"], [], {})
    assert [each.speeds[each.index] for each in parameters] == [1.0, 3.0]
    rollouts = Rollouts(seen, scene, threads=1)

    def off(*values):
        changed = changed_scene(scene, parameters, np.array(values))
        return rollouts.errors(changed)[:, 0].mean()

    truth = off(0.6, 0.4)
    assert truth < 1e-3
    assert min(off(0.5, 0.4), off(0.6, 0.5), off(0.4, 0.6)) > 5.0 * truth


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


BOUNCE = ("examples/one_bounce.csv", "examples/dropped_ball.toml")


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


@pytest.mark.parametrize(("option", "value"), [("--held-out", "2"), ("--threads", "0")])
def test_errors_of_the_command_name_its_options(option, value):
    result = run("identify", *BOUNCE, option, value)
    assert result.exit_code == 2 and result.stderr.startswith(f"error: {option} must be ")
