"""Every example runs: scene files through the command, scripts as scripts.

What they show is tested in examples/.
"""

import pathlib
import subprocess
import sys

import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"
SCENES = sorted(EXAMPLES.glob("*.toml"))
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
# Scripts that integrate for long or write a page.
LONG = ("draw_figure_2", "draw_figure_3", "replay_thrown_ball", "struck_four_bar")

# Print a report, whose tables are wider than a line of a script's own.
REPORTS = ("car_crash", "dropped_phone", "which_law")
# Made for the motion that follows; at its start nothing strikes yet, and solve says so.
STARTS_APART = ("cube_tosses", "dropped_ball", "dropped_solo12")

# What is there to show an answer that is not one, and the status that says so.
NOT_VALID = {"rough_floor": ik.Status.ENERGY_GAIN}


def stem(path):
    return path.stem


@pytest.mark.slow
@pytest.mark.parametrize("path", SCENES, ids=stem)
def test_scene_files_solve(path):
    result = CliRunner().invoke(main, ["solve", str(path)])
    assert "Velocity of points" in result.stdout
    if path.stem in NOT_VALID:
        sentence = NOT_VALID[path.stem].value
        assert result.exit_code == 1
        assert result.stderr == f"not valid: {NOT_VALID[path.stem].name.lower()}\n"
        assert sentence in result.stdout
    else:
        assert result.exit_code == 0, result.output
        warned = "warning: nothing strikes: no impulse acts" in result.stderr
        assert warned if path.stem in STARTS_APART else result.stderr == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=pytest.mark.slow if p.stem in LONG else (), id=p.stem) for p in SCRIPTS],
)
def test_scripts_run(path, tmp_path):
    # Scripts that write a file take its name as their argument.
    output = [str(tmp_path / "output.svg")] if path.stem.startswith("draw_") else []
    done = subprocess.run(
        [sys.executable, str(path), *output],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    # What a fresh installation compiles is told in a line.
    told = [line for line in done.stderr.splitlines() if "compiling for this machine" not in line]
    assert not told
    for name in output:
        assert pathlib.Path(name).stat().st_size > 1000
    if not output and path.stem not in REPORTS:
        assert all(len(line) <= 80 for line in done.stdout.splitlines())


@pytest.mark.parametrize("path", [*SCENES, *SCRIPTS], ids=lambda path: path.name)
def test_they_begin_with_what_they_show(path):
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# " if path.suffix == ".toml" else '"""')
    assert len(first) > 40


def test_there_are_examples_of_both_kinds():
    assert len(SCENES) >= 15
    assert {path.stem for path in SCRIPTS} >= {"strike_a_hand", "draw_struck_chain"}
