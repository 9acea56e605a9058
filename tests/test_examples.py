"""Every example runs: scene files through the command, scripts as scripts."""

import pathlib
import subprocess
import sys

import pytest
from click.testing import CliRunner

from impulsekit.cli import main

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_scene_files_solve(path):
    result = CliRunner().invoke(main, ["solve", str(path)])
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert "Velocity of points" in result.stdout


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda p: p.stem)
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
    for name in output:
        assert pathlib.Path(name).stat().st_size > 1000


def test_there_are_examples_of_both_kinds():
    assert len(list(EXAMPLES.glob("*.toml"))) >= 5
    assert {p.stem for p in EXAMPLES.glob("*.py")} >= {"strike_a_hand", "draw_struck_chain"}
