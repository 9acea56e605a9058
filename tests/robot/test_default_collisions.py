"""Everything collides: robots and models as they come start in a lawful state and move on."""

import importlib.util
import pathlib
import warnings

import pytest

import impulsekit as ik

# Ends of a motion that are physics.
ENDS = {"FINISHED"}
EXAMPLES = [
    "allegro_right_hand", "anymal", "b1", "bolt", "double_pendulum",
    "finger_edu", "go2", "hyq", "iris", "kinova", "laikago", "panda", "solo12", "so101", "talos",
    "tiago", "ur5", "xarm7",
]  # fmt: skip


def shipped(package, folder):
    """The MJCF files that a package brings; none where it is not installed."""
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        return []
    files = sorted((pathlib.Path(spec.origin).parent / folder).glob("*.xml"))
    return [file for file in files if "<worldbody>" in file.read_text(encoding="utf-8")]


MODELS = [*shipped("gymnasium", "envs/mujoco/assets"), *shipped("dm_control", "suite")]


def moves_on(scene, q, v):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = ik.simulate(scene, q, v, duration=0.2)
    return motion.status.name in ENDS, f"{motion.status.name}: {motion.detail}"


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_robot_moves_on(name):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot = ik.Robot.from_example(name, root="freeflyer").with_ground()
        pose = next(
            (robot.poses[n] for n in ("standing", "half_sitting") if n in robot.poses), None
        )
        q = robot.stand(robot.neutral() if pose is None else pose)
        scene = ik.Scene(robot, collisions="all")
    good, words = moves_on(scene, q, robot.velocity())
    assert good, words


@pytest.mark.slow
@pytest.mark.parametrize("path", MODELS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_model_of_other_packages_moves_on(path):
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot = ik.Robot.from_mjcf(model)
        scene = ik.Scene.of_robot(robot)
    q, v = ik.mujoco_state(mujoco.MjData(model))
    if path.stem == "humanoidstandup":
        # It lies 36 mm deep in its floor.
        q = robot.stand(q)
    good, words = moves_on(scene, q, v)
    assert good, words
