"""The README is true: what it shows is run, and what it points to is there."""

import doctest
import pathlib
import re
import shlex
import subprocess
import sys

import pytest

import impulsekit as ik

ROOT = pathlib.Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", README, re.M | re.S)


def blocks(language):
    return [text for name, text in BLOCKS if name == language]


def output_of(command):
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


SCRIPTS = [(BLOCKS[i], BLOCKS[i + 1]) for i, (name, _) in enumerate(BLOCKS) if name == "python"]


@pytest.mark.parametrize(
    ("script", "shown"), SCRIPTS, ids=["blow", "constraints", "contacts", "batch", "design"]
)
def test_the_python_prints_what_is_shown(script, shown):
    assert shown[0] == "text"
    assert output_of([sys.executable, "-c", script[1]]) == shown[1]


@pytest.mark.parametrize("block", blocks("console"))
def test_the_command_prints_what_is_shown(block):
    command, _, shown = block.partition("\n")
    assert command.startswith("$ impulsekit ")
    main = [sys.executable, "-c", "from impulsekit.cli import main; main()"]
    printed = output_of([*main, *shlex.split(command)[2:]])
    # As in a doctest, "..." stands for what is left out.
    assert doctest.OutputChecker().check_output(shown, printed, doctest.ELLIPSIS), printed


@pytest.mark.parametrize("block", blocks("toml"))
def test_scene_files_are_read(block, tmp_path):
    (tmp_path / "models").symlink_to(ROOT / "models")
    (tmp_path / "scenes").mkdir()
    path = tmp_path / "scenes/scene.toml"
    path.write_text(block, encoding="utf-8")
    file = ik.load_scene(path)
    assert ik.solve(file.scene, file.q, file.v).is_valid()


def test_setting_up_takes_one_command_each():
    first, tests = blocks("bash")
    for command in (first, tests):
        assert command.count("\n") == 1
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install -q ")
    # The main job is the one whose output is shown.
    shown = blocks("console")[0].splitlines()[0].removeprefix("$ ")
    assert first.rstrip().endswith(f"&& .venv/bin/{shown}")


def test_the_gate_runs_the_readmes_test_command():
    lines = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert blocks("bash")[1].rstrip("\n") in lines


def test_links_lead_somewhere():
    links = re.findall(r"\]\(([^)]+)\)", README)
    assert len(links) > 10
    for link in links:
        assert link.startswith("https://") or (ROOT / link).exists(), link


def test_every_command_is_told():
    from impulsekit.cli import main

    for name in main.commands:
        assert f"`impulsekit {name}" in README


def test_every_example_is_told():
    for path in (ROOT / "examples").iterdir():
        if path.suffix in (".toml", ".py"):
            assert f"](examples/{path.name})" in README, path.name


def test_every_status_is_told():
    for status in ik.Status:
        row = next(line for line in README.splitlines() if f"`{status.name}`" in line)
        assert row.split("|")[2].strip() == ("yes" if status.valid else "no")
