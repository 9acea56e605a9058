"""``impulsekit fit`` and the measured impacts behind it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main
from impulsekit.measured.measurement_files import load_measurements

BALL = "examples/bounced_ball.toml"
# The throws were made up of these.
RESTITUTION, FRICTION = 0.82, 0.27


def run(*arguments):
    return CliRunner().invoke(main, ["fit", *arguments])


def test_the_throws_of_a_ball_give_its_coefficients_with_honest_intervals():
    answer = run(BALL, "--json", "-")
    assert answer.exit_code == 0
    found = json.loads(answer.stdout)
    assert found["impacts"] == 12 and found["converged"] and not found["sigma_given"]
    for name, truth in (("floor: restitution", RESTITUTION), ("floor: friction", FRICTION)):
        low, high = found["parameters"][name]["interval"]
        assert low < truth < high and high - low < 0.01
    assert found["noise"] == pytest.approx(0.02, rel=0.2)


def test_the_text_tells_value_and_interval(tmp_path):
    to = tmp_path / "fit.json"
    answer = run(BALL, "--friction", "floor", "--level", "0.5", "--json", str(to))
    assert answer.exit_code == 0
    assert "50 % interval" in answer.stdout and "floor: friction" in answer.stdout
    assert "restitution" not in answer.stdout
    # With the wrong restitution of the file, µ takes what it can.
    assert list(json.loads(to.read_text())["parameters"]) == ["floor: friction"]


def test_tables_and_lists_say_the_same(tmp_path):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball")])
    table, other = tmp_path / "a.csv", tmp_path / "a.json"
    table.write_text(
        "before.root_joint[2], after.root_joint[0], after.root_joint[2], sigma\n"
        "-1.5, , 1.0, 0.1\n\n-2, 0.25, 1.5, 0.1\n"
    )
    other.write_text(
        json.dumps(
            [
                {
                    "before": {"root_joint": [0, 0, -1.5, 0, 0, 0]},
                    "after": {"root_joint": [None, None, 1.0, None, None, None]},
                    "sigma": 0.1,
                },
                {
                    "before": {"root_joint": [0, 0, -2, 0, 0, 0]},
                    "after": {"root_joint": [0.25, None, 1.5, None, None, None]},
                    "sigma": 0.1,
                },
            ]
        )
    )
    state = (ball.neutral(), ball.velocity())
    for one, two in zip(
        load_measurements(table, scene, *state),
        load_measurements(other, scene, *state),
        strict=True,
    ):
        assert np.array_equal(one.v_before, two.v_before)
        assert np.array_equal(one.v_after, two.v_after, equal_nan=True)
        assert one.sigma == two.sigma and np.array_equal(one.q, ball.neutral())


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no row below the names"),
        ("after.root_joint[0]\n", "no row below the names"),
        ("speed\n1\n", 'column "speed" is none of'),
        ("after.root_joint[0]\nfast\n", 'row 2: after.root_joint must be a number, got "fast"'),
        ("after.root_joint[0]\n1,2\n", "row 2 has 2 cells, the first has 1"),
        ("after.root_joint[9]\n1\n", "root_joint"),
        ("after.rot_joint\n1\n", "root_joint"),
        ("before.root_joint[0]\n1\n", "no speed after the impact"),
    ],
)
def test_a_table_that_cannot_be_used(tmp_path, text, reason):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    answer = run(BALL, "--measured", str(path))
    assert answer.exit_code == 2 and reason in answer.stderr


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "bad.json"),
        ("{}", "a list of impacts"),
        ("[3]", "impact 0"),
        ('[{"befor": {}}]', "before"),
        ('[{"after": 3}]', "values by joint"),
        ('[{"after": {"root_joint": [1]}}]', "root_joint"),
        ('[{"after": {"root_joint": [1, 2, 3, 4, 5, true]}}]', "must be a number"),
    ],
)
def test_a_list_that_cannot_be_used(tmp_path, text, reason):
    path = tmp_path / "bad.json"
    path.write_text(text)
    answer = run(BALL, "--measured", str(path))
    assert answer.exit_code == 2 and reason in answer.stderr


def test_what_else_cannot_be_used_is_said(tmp_path):
    assert "none.csv" in run(BALL, "--measured", "none.csv").stderr
    assert "neither" in run("examples/hammer.toml").stderr
    assert "JOINT:PARAMETERS" in run(BALL, "--inertia", "root_joint").stderr
    assert "between 0 and 1" in run(BALL, "--level", "2").stderr
    assert "ceiling" in run(BALL, "--restitution", "ceiling").stderr
