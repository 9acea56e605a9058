"""One call for any robot file, and the command that shows it."""

from __future__ import annotations

import sys
import types

import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit import errors
from impulsekit.cli import main

URDF = ik.models.chain_urdf(2)
MJCF = "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
SDF = """<sdf version="1.9"><model name="m"><link name="a"><inertial><mass>1</mass></inertial>
</link></model></sdf>"""
HEAD = "\ufeff<?xml version='1.0'?>\n<!-- a <robot> or <sdf> -->\n"


@pytest.mark.parametrize(("text", "speeds"), [(URDF, 7), (MJCF, 6), (SDF, 6)])
@pytest.mark.parametrize("suffix", [".urdf", ".xml", ".sdf"])
def test_the_outermost_element_tells_the_format(tmp_path, text, speeds, suffix):
    pytest.importorskip("mujoco")
    path = tmp_path / f"robot{suffix}"
    path.write_text(HEAD.removeprefix("\ufeff") + text.split("?>", 1)[-1].lstrip())
    assert ik.Robot.from_file(path, "freeflyer").nv == speeds


def test_what_is_no_robot_file_is_named(tmp_path):
    for content in (b"", b"\x89PNG\r\n", b"<html></html>"):
        (tmp_path / "thing.urdf").write_bytes(content)
        with pytest.raises(errors.UrdfError, match=r"thing\.urdf"):
            ik.Robot.from_file(tmp_path / "thing.urdf")
    with pytest.raises(errors.UrdfError, match="no such file"):
        ik.Robot.from_file(tmp_path / "nowhere.urdf")


def run(*arguments):
    return CliRunner().invoke(main, ["inspect", *map(str, arguments)])


def test_the_command_shows_what_a_file_holds(tmp_path):
    quirky = URDF.replace('effort="', 'effort="-')
    (tmp_path / "chain.urdf").write_text(quirky)
    result = run(tmp_path / "chain.urdf", "--root", "freeflyer")
    assert result.exit_code == 0
    for word in ("link_1", "joint_2", "FreeFlyer", "7 degrees of freedom", "Assumed"):
        assert word in result.output
    assert "Moves no mass" in run("models/door.urdf", "--root", "freeflyer").output
    assert "panda_joint1" in run("panda").output


def test_a_description_is_looked_up_by_name(tmp_path, monkeypatch):
    (tmp_path / "arm.urdf").write_text(URDF)
    package = types.ModuleType("robot_descriptions")
    package.DESCRIPTIONS = {"arm_description": None, "lost_description": None}
    arm = types.ModuleType("robot_descriptions.arm_description")
    arm.URDF_PATH, arm.PACKAGE_PATH = str(tmp_path / "arm.urdf"), str(tmp_path)
    monkeypatch.setitem(sys.modules, "robot_descriptions", package)
    monkeypatch.setitem(sys.modules, "robot_descriptions.arm_description", arm)
    assert ik.Robot.from_description("arm_description", "freeflyer").nv == 7
    with pytest.raises(errors.UnknownNameError, match="arm_description"):
        ik.Robot.from_description("arm_descripton")
    with pytest.raises(errors.InputError, match="cannot be fetched"):
        ik.Robot.from_description("lost_description")
    monkeypatch.setitem(sys.modules, "robot_descriptions", None)
    with pytest.raises(errors.MissingExtraError, match="descriptions"):
        ik.Robot.from_description("arm_description")
