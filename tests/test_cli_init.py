"""``impulsekit init``, the grouped help and the search for robots."""

import re
import shlex

import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli.main import SECTIONS, main


def run(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.mark.parametrize(
    ("robot", "root"), [("panda", "fixed"), ("solo12", "freeflyer"), ("ur5", "sagittal")]
)
def test_the_first_scene_solves(robot, root, tmp_path):
    path = tmp_path / "first.toml"
    assert run("init", path, "--robot", robot, "--root", root).exit_code == 0
    assert run("solve", path).exit_code == 0
    file = ik.load_scene(path)
    assert file.scene.robot.nv == ik.Robot.from_example(robot, root).nv
    # M dv = Jᵀp: the work of the blow is half of p times the velocity that it makes.
    impact = ik.solve(file.scene, file.q, file.v)
    after = impact.velocity_at(file.scene.impulses[0].frame).after
    assert impact.energy.change == pytest.approx(0.5 * after @ [0, 0, -2], rel=1e-12)


def test_what_is_commented_out_is_valid_too(tmp_path):
    path = tmp_path / "first.toml"
    run("init", path)
    lines = path.read_text("utf-8").splitlines()
    entries = [
        line.removeprefix("# ") if re.match(r"# (\[\[|\w+ = )", line) else line for line in lines
    ]
    path.write_text("\n".join(entries), "utf-8")
    scene = ik.load_scene(path).scene
    assert len(scene.constraints) == len(scene.contacts) == 1


def test_the_command_that_solves_it_can_be_pasted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    told = run("init", "b ü.toml").stdout.strip()
    command = told.partition("solve it: ")[2]
    assert shlex.split(command) == ["impulsekit", "solve", "b ü.toml"]
    assert "impulsekit solve 'b ü.toml' --html" in (tmp_path / "b ü.toml").read_text("utf-8")


def test_inspect_knows_the_roots_that_robots_have():
    told = run("inspect", "ur5", "--root", "sagittal")
    assert told.exit_code == 0 and "9 degrees of freedom" in told.stdout


def test_a_file_that_exists_is_kept(tmp_path):
    path = tmp_path / "first.toml"
    path.write_text("mine")
    assert run("init", path).exit_code == 2
    assert path.read_text() == "mine"
    assert run("init", path, "--force").exit_code == 0


def test_robots_are_found_by_a_part_of_their_name():
    assert "solo12" in run("robots", "olo1").stdout.split()
    assert all(name.startswith("ur5") for name in run("robots", "UR5*").stdout.split())
    missing = run("robots", "nothing_like_it")
    assert missing.exit_code == 2
    assert "nothing_like_it" in missing.stderr


def test_the_help_lists_every_command_once():
    listed = [command.name for commands in SECTIONS.values() for command in commands]
    assert sorted(listed) == sorted(main.commands)
    shown = run("--help").stdout
    assert all(f"\n  {name} " in shown for name in listed)
