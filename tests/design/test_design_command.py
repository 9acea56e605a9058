"""``impulsekit design`` and the points of a scene file behind it."""

import json
import runpy

import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main

DOOR = "examples/spared_hinges.toml"
# I/(m r) of a uniform leaf 0.9 m wide and 0.04 m thick about its hinges.
SWEET_SPOT = 2 / 3 * 0.9 + 0.04**2 / 12 / 0.45


def run(*arguments):
    return CliRunner().invoke(main, ["design", *arguments])


def test_where_a_stop_spares_the_hinges_of_a_door():
    answer = run(DOOR, "--json", "-")
    assert answer.exit_code == 0
    line, edge = json.loads(answer.stdout)["points"]
    assert line["spared"]["at"][0] == pytest.approx(SWEET_SPOT, abs=1e-12)
    assert line["spared"]["share"] < 1e-12
    assert edge["effective_mass"] == pytest.approx(20 * 0.45 * SWEET_SPOT / 0.9**2)
    assert edge["axes"][0]["effective_mass"] is None
    text = run(DOOR).stdout
    assert "least load by a blow at (0.600296, 0.02, 1) m" in text and "infinite" in text


def test_a_picture_is_written(tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "masses.png"
    assert run(DOOR, "--plot", str(path)).exit_code == 0
    assert path.stat().st_size > 1000


def test_points_are_read_and_written_alike(tmp_path):
    file = ik.load_scene(DOOR)
    path = tmp_path / "copy.toml"
    ik.save_scene(path, file.scene, file.q, file.v, design=file.design)
    assert ik.load_scene(path).design == file.design


def test_faults_are_told_with_their_place(tmp_path):
    text = '[robot]\nexample = "panda"\n[[design.points]]\nframe = "panda_hnd"\njoint = "wrist"\n'
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    answer = run(str(path))
    assert answer.exit_code == 2
    assert (
        "design.points[0].frame: unknown frame" in answer.stderr and '"panda_hand"' in answer.stderr
    )
    assert "design.points[0].joint" in answer.stderr
    path.write_text('[robot]\nexample = "panda"\n')
    assert "no [[design.points]]" in run(str(path)).stderr


def script(name):
    return runpy.run_path(f"examples/{name}.py")


def test_the_grip_that_makes_the_middle_of_the_strings_the_sweet_spot():
    racket = script("tennis_racket")
    mass, centre, swing = racket["MASS"], racket["CENTRE"], racket["SWING"]
    grip = centre - swing / (mass * (racket["MIDDLE"] - centre))
    assert racket["sweet_spot"](grip) == pytest.approx(racket["MIDDLE"], abs=1e-12)


def test_solo12_spares_its_knees_with_its_feet_a_little_out():
    landing = script("knee_sparing_landing")
    assert landing["landing"](0.0826).is_valid()
    knee = landing["knee_impulse"]
    assert knee(0.0826) < min(knee(0.06), knee(0.11)) < knee(0.0) < knee(-0.15)
