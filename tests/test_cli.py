"""The command: answers on stdout, diagnostics on stderr, and what the exit status says."""

import importlib.metadata
import json
import os
import pathlib
import re
import signal
import subprocess
import sys

import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import doctor, main
from impulsekit.cli.doctor import requirements
from impulsekit.impact import Status

ROOT = pathlib.Path(__file__).parents[1]
CHAIN = ROOT / "examples/whittaker_chain.toml"


def run(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments], prog_name="impulsekit")


@pytest.fixture
def solve(tmp_path):
    def solve_text(text, *arguments):
        path = tmp_path / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return run("solve", path, *arguments)

    return solve_text


def test_the_papers_table_in_its_own_rounding():
    result = run("solve", CHAIN)
    assert result.exit_code == 0 and result.stderr == ""
    rows = re.findall(r"^  (struck end|pin \d|far end) +(\S+) +(\S+) +(\S+)$", result.stdout, re.M)
    printed = "17.321 -4.641 1.244 -0.333 0.089 -0.024 0.006 -0.002 0.0005 -0.0001 0.00007"
    assert [row[2] for row in rows] == printed.split()
    assert {row[1] for row in rows} | {row[3] for row in rows} == {"0"}
    # P u_0 / 2 with u_0 = 5 * 262087 / 75658.
    after = re.search(r"^  after +(\S+)$", result.stdout, re.M)[1]
    assert float(after) == pytest.approx(5 * 5 * 262087 / 75658 / 2, abs=1e-4)
    assert round(float(after), 2) == 43.30


def test_json_holds_every_number_in_full(tmp_path):
    out = tmp_path / "impact.json"
    result = run("solve", CHAIN, "--json", out)
    assert result.exit_code == 0 and "Kinetic energy" in result.stdout
    data = json.loads(out.read_text())
    file = ik.load_scene(CHAIN)
    impact = ik.solve(file.scene, file.q, file.v)
    assert data["dv"] == impact.dv.tolist()
    assert data["valid"] is True and data["scene_file"] == str(CHAIN)
    assert [p["label"] for p in data["points"]][::10] == ["struck end", "far end"]
    assert data["points"][0]["after"] == impact.velocity_at("link_1").after.tolist()


def test_an_answer_that_is_not_valid_has_status_1(monkeypatch):
    monkeypatch.setattr(ik.Impact, "status", Status.INACCURATE)
    result = run("solve", CHAIN)
    assert result.exit_code == 1
    assert "not valid: " in result.stderr and "Kinetic energy" in result.stdout


def test_numbers_that_json_does_not_have_become_null(monkeypatch):
    monkeypatch.setattr(ik.Impact, "to_dict", lambda self: {"x": [float("nan"), 1.0]})
    assert json.loads(run("solve", CHAIN, "--json", "-").stdout)["x"] == [None, 1.0]


# Bad input: one clear error, status 2, no traceback


def test_in_a_process_of_its_own_nothing_else_is_said(tmp_path):
    # Pinocchio's readers in C++ write past Python's stderr.
    (tmp_path / "broken.urdf").write_text("<robot name='x'><link name='a'></robot>")
    (tmp_path / "scene.toml").write_text('[robot]\nurdf = "broken.urdf"\n')
    command = [sys.executable, "-m", "impulsekit", "solve"]
    done = subprocess.run(
        [*command, str(tmp_path / "scene.toml")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1


@pytest.mark.parametrize("closed", [1, 2])
@pytest.mark.parametrize(
    "words", [("solve", CHAIN), ("simulate", ROOT / "examples/dropped_ball.toml")]
)
def test_a_stream_that_the_caller_has_closed_is_not_written_to(words, closed):
    command = [sys.executable, "-m", "impulsekit", *map(str, words)]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, preexec_fn=lambda: os.close(closed)
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == "" and (done.stdout == "") == (closed == 1)


@pytest.mark.parametrize(
    ("function", "words"),
    [
        ("impulsekit.impact.solve", ("solve", CHAIN)),
        ("impulsekit.robot.Robot.from_example", ("inspect", "panda")),
        ("impulsekit.scenefile.load_scene", ("identify", CHAIN, CHAIN)),
        ("impulsekit.study.load_study", ("batch", CHAIN)),
    ],
)
def test_ctrl_c_is_said_and_has_its_own_status(monkeypatch, function, words):
    def struck(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(function, struck)
    result = run(*words)
    assert result.exit_code == 130 and result.stdout == ""
    assert result.stderr.splitlines()[-1] == "interrupted"
    assert run("--debug", *words).exit_code == 1


def test_a_motion_that_ctrl_c_has_ended_is_shown_with_that_status(monkeypatch):
    monkeypatch.setattr(
        "impulsekit.motion.followed.begin", lambda *_: signal.raise_signal(signal.SIGINT) or ()
    )
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        result = run("simulate", ROOT / "examples/dropped_ball.toml")
    finally:
        signal.signal(signal.SIGINT, before)
    assert result.exit_code == 130 and "stopped at " in result.stderr


def test_a_fault_of_our_own_is_one_line_unless_asked(monkeypatch):
    def broken(*_):
        raise KeyError("oops")

    monkeypatch.setattr("impulsekit.impact.solve", broken)
    result = run("solve", CHAIN)
    assert result.exit_code == 3
    assert re.fullmatch(r"bug: KeyError: 'oops' .*impulsekit --debug solve.*\n", result.stderr)
    assert isinstance(run("--debug", "solve", CHAIN).exception, KeyError)


def test_the_version():
    result = run("--version")
    assert result.stdout == f"impulsekit {ik.__version__}\n"
    assert importlib.metadata.version("impulsekit") == ik.__version__


# robots


def test_robots_are_listed_one_a_line():
    result = run("robots")
    assert result.exit_code == 0
    assert result.stdout.splitlines() == list(ik.models.example_names())
    for name in ("talos", "panda", "solo12", "ur5", "allegro_right_hand"):
        assert name in result.stdout.splitlines()


# doctor


def test_the_doctor_finds_a_sound_installation():
    result = run("doctor")
    assert result.exit_code == 0, result.output
    assert re.search(r"^  pin +4\.\S+ +core +ok$", result.stdout, re.M)
    assert re.search(r"^pinocchio 4\.\S+ .* is imported from /", result.stdout, re.M)


def test_the_doctor_says_where_nothing_is_installed(monkeypatch):
    def missing(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(doctor.importlib.metadata, "requires", missing)
    result = run("doctor")
    assert result.exit_code == 1
    assert "impulsekit is not installed, only found on the path" in result.stderr


def test_the_doctor_names_what_is_missing_and_the_line_for_it(monkeypatch):
    version = importlib.metadata.version

    def without(name):
        if name in ("pydantic", "matplotlib"):
            raise importlib.metadata.PackageNotFoundError(name)
        return "3.9.0" if name == "pin" else version(name)

    monkeypatch.setattr(doctor.importlib.metadata, "version", without)
    result = run("doctor")
    assert result.exit_code == 1
    assert 'pydantic: missing: pip install "pydantic>=2.7"' in result.stderr
    assert re.search(r'pin: expected \S+: pip install "pin\S+"', result.stderr)
    assert re.search(r'matplotlib +- +plot +missing: pip install "matplotlib\S+"', result.stdout)
    assert "matplotlib" not in result.stderr


def test_the_doctor_survives_a_pinocchio_that_crashes(tmp_path, monkeypatch):
    (tmp_path / "pinocchio.py").write_text("import os; os.abort()")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    result = run("doctor")
    assert result.exit_code == 1 and "pinocchio cannot be imported" in result.stderr


def test_the_doctor_knows_every_requirement():
    found = {(r.name, r.extra) for r in requirements()}
    assert {("pin", ""), ("pydantic", ""), ("matplotlib", "plot"), ("pytest", "test")} <= found
