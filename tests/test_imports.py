"""What an import costs: heavy libraries come at their point of use."""

import subprocess
import sys

import pytest

PANDA = """
from impulsekit import AppliedImpulse, Robot, Scene, solve
robot = Robot.from_example("panda")
scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
solve(scene, robot.neutral(), robot.velocity()).dv
"""
SCENE_FILES = {"pydantic", "tomli_w"}
LATER = {"scipy", "meshcat", "yourdfpy", "rich", "click", "matplotlib", "trimesh", "tqdm"}


def loaded_by(code):
    """The packages that are loaded after ``code`` has run in a Python of its own."""
    tail = "\nimport sys\nprint(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code + tail], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


@pytest.mark.parametrize(
    ("code", "absent"),
    [
        ("import impulsekit", {"numpy", "pinocchio"} | LATER | SCENE_FILES),
        ("import impulsekit; dir(impulsekit)", {"numpy", "pinocchio"} | LATER | SCENE_FILES),
        ("import impulsekit.errors", {"numpy", "pinocchio"}),
        ("import impulsekit; impulsekit.models.chain_urdf(3)", {"numpy", "pinocchio"} | LATER),
        ("from impulsekit import Robot, Scene", LATER | SCENE_FILES),
        (PANDA, LATER | SCENE_FILES),
        ("from impulsekit import report", LATER | SCENE_FILES),
        ("from impulsekit import measured, plots, replay", LATER | SCENE_FILES),
        ("from impulsekit import load_scene", LATER),
        ("import impulsekit.cli", {"numpy", "pinocchio"} | LATER - {"click"} | SCENE_FILES),
    ],
)
def test_nothing_is_loaded_before_its_time(code, absent):
    assert loaded_by(code) & absent == set()


def test_coal_comes_only_with_pinocchio():
    by_pinocchio = loaded_by("import pinocchio")
    assert ("coal" in loaded_by("from impulsekit import Robot, Scene")) <= ("coal" in by_pinocchio)


def test_every_public_name_resolves():
    import impulsekit

    assert {"Robot", "Scene", "solve", "load_scene", "report"} <= set(impulsekit.__all__)
    for name in impulsekit.__all__:
        assert getattr(impulsekit, name) is not None
