"""The README is true: what it shows is run, and what it points to is there."""

import doctest
import pathlib
import re
import shlex
import subprocess
import sys

import pytest

from tests.reference.models import mass_matrix

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


def test_it_is_short():
    assert len(README.splitlines()) <= 150


@pytest.mark.parametrize(("script", "shown"), SCRIPTS, ids=["blow", "motion", "batch"])
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


def test_setting_up_takes_one_command_each():
    first, tests, docs = blocks("bash")
    for command in (first, tests, docs):
        assert command.count("\n") == 1
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install -q ")
    # The main job is the one whose output is shown.
    shown = blocks("console")[0].splitlines()[0].removeprefix("$ ")
    assert first.rstrip().endswith(f"&& .venv/bin/{shown}")
    # Warnings of the documentation are errors.
    assert "sphinx-build" in docs and " -W " in docs


def test_the_gate_runs_the_readmes_test_command():
    lines = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert blocks("bash")[1].rstrip("\n") in lines


def test_links_lead_somewhere():
    links = re.findall(r"\]\(([^)]+)\)", README)
    assert len(links) > 10
    for link in links:
        assert link.startswith("https://") or (ROOT / link).exists(), link


def test_its_extras_are_those_of_the_package():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = set(project["optional-dependencies"])
    named = re.search(r"Extras of pip: (.*?), as in", README, re.S)[1]
    assert set(re.findall(r"`(\w+)`", named)) == extras - {"test", "docs", "all"}
    for line in re.findall(r'pip install -?q? ?"\.\[([\w,]+)\]"', README):
        assert set(line.split(",")) <= extras


def test_what_rotors_add_to_a_wall_hit_by_a_ur5():
    """P = m_eff u, the effective mass from M⁻¹ with and without rotors on its diagonal."""
    import numpy as np
    import pinocchio as pin

    import impulsekit as ik

    arm = ik.Robot.from_example("ur5")
    q = arm.configuration(shoulder_lift_joint=-1.05, elbow_joint=1.57, wrist_1_joint=-0.52)
    data = arm.model.createData()
    masses = mass_matrix(arm.model, q)
    frame = arm.frame_id("tool0")
    row = pin.computeFrameJacobian(arm.model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)[0]
    rotors = 101**2 * np.array([9e-5] * 3 + [2e-5] * 3)
    bare, geared = (
        f"{0.5 / (row @ np.linalg.solve(masses + np.diag(extra), row)):.2f}"
        for extra in (0 * rotors, rotors)
    )
    page = (ROOT / "docs/howto/payloads_and_rotors.md").read_text(encoding="utf-8")
    assert f"{bare} N s without them, {geared} N s with them" in README
    assert f"from {bare} to {geared} N s" in page
    names: dict = {}
    for cell in re.findall(r"```{code-cell} python3\n(.*?)```", page, re.S)[:3]:
        exec(compile(cell, "page", "exec"), names)
    assert f"{names['impulses']['all joints free']:.2f}" == bare
    assert f"{names['impulses']['with rotors']:.2f}" == geared
