"""Scene files: what is read, what is written, and what is said of a faulty one."""

import math
import pathlib
import re

import hypothesis.strategies as st
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings

import impulsekit as ik
from impulsekit.errors import SceneFileError
from impulsekit.scene import ReportPoint
from impulsekit.scene.contacts import Contact
from impulsekit.scenefile import SceneFile, dump_scene
from impulsekit.scenefile.vocabulary import SECTIONS

ROOT = pathlib.Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))

CHAIN = f"""
[robot]
urdf = "{(ROOT / "models/whittaker_chain_10.urdf").as_posix()}"
root = "planar"
"""
PANDA = '[robot]\nexample = "panda"\n'


@pytest.fixture
def load(tmp_path):
    def load_text(text):
        path = tmp_path / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return ik.load_scene(path)

    return load_text


@pytest.fixture
def faults_of(load):
    def faults(text):
        with pytest.raises(SceneFileError) as caught:
            load(text)
        assert str(caught.value).startswith(caught.value.path + ": ")
        for fault in caught.value.faults:
            assert fault in str(caught.value)
        return caught.value.faults

    return faults


def same_bits(one, other):
    """Whether two scene files hold the same, down to the sign of a zero."""
    return (
        one.q.tobytes() == other.q.tobytes()
        and one.v.tobytes() == other.v.tobytes()
        and repr(one.scene.impulses) == repr(other.scene.impulses)
        and repr(one.scene.gravity) == repr(other.scene.gravity)
        and repr(one.points) == repr(other.points)
        and one.scene.robot.parts == other.scene.robot.parts
        and one.scene.robot.model == other.scene.robot.model
    )


# Reading


def test_a_file_says_what_the_same_scene_in_python_says(load):
    file = load(
        "gravity = [0, 0, -1.62]\n"
        + CHAIN
        + """
        [state.q]
        root_joint = [1, 2, 0.5]
        joint_2 = 0.3
        [state.v]
        joint_2 = -1.0
        [[impulses]]
        frame = "link_10"
        linear = [0, 5, 0]
        angular = [0, 0, 1]
        at = [1, 0, 0]
        axes = "local"
        name = "blow"
        [[impulses]]
        joint = "joint_3"
        impulse = 0.4
        [[report.points]]
        frame = "link_10"
        at = [1, 0, 0]
        label = "struck end"
        [[report.points]]
        frame = "link_2"
        """
    )
    robot = ik.Robot.from_urdf(ROOT / "models/whittaker_chain_10.urdf", root="planar")
    assert file.scene.robot.model == robot.model
    assert file.scene.gravity == (0.0, 0.0, -1.62)
    assert file.scene.impulses == (
        ik.AppliedImpulse("link_10", [0, 5, 0], [0, 0, 1], [1, 0, 0], "local", "blow"),
        ik.JointImpulse("joint_3", 0.4),
    )
    np.testing.assert_array_equal(file.q, robot.configuration(root_joint=[1, 2, 0.5], joint_2=0.3))
    np.testing.assert_array_equal(file.v, robot.velocity(joint_2=-1.0))
    assert file.points == (
        ReportPoint("link_10", at=[1, 0, 0], label="struck end"),
        ReportPoint("link_2"),
    )
    assert not file.q.flags.writeable and not file.v.flags.writeable


def test_a_stiffness_ratio_is_read_and_written(load, tmp_path):
    file = load(
        PANDA
        + """
        [law]
        slip = "compliant"
        [[contacts]]
        kind = "contact"
        frame = "panda_hand"
        friction = 0.5
        stiffness_ratio = 0.3
        tangential_damping = 0.2
        [[contacts]]
        kind = "contact"
        frame = "panda_link7"
        friction = 0.5
        stiffness_ratio = inf
        """
    )
    assert file.scene.law == ik.Law(slip="compliant")
    assert [contact.stiffness_ratio for contact in file.scene.contacts] == [0.3, math.inf]
    assert [contact.tangential_damping for contact in file.scene.contacts] == [0.2, None]
    ik.save_scene(tmp_path / "copy.toml", file.scene, file.q, file.v)
    assert same_bits(file, ik.load_scene(tmp_path / "copy.toml"))


def test_a_ratio_that_is_not_positive_is_an_error(faults_of):
    text = PANDA + '[[contacts]]\nkind = "contact"\nframe = "panda_hand"\nstiffness_ratio = 0\n'
    assert any("stiffness_ratio" in fault for fault in faults_of(text))


def test_paths_are_relative_to_the_file_not_to_the_working_directory(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "rod.urdf").write_text(ik.models.chain_urdf(1))
    (tmp_path / "here/scene.toml").write_text('[robot]\nurdf = "../rod.urdf"\nroot = "planar"')
    monkeypatch.chdir(ROOT)
    assert ik.load_scene(tmp_path / "here/scene.toml").scene.robot.nv == 3


def test_several_robots_stand_where_they_are_placed(load):
    file = load(
        """
        [robots.left]
        example = "panda"
        [robots.right]
        example = "panda"
        placement = { xyz = [0, 1, 0.5], rpy = [0, 0, 0.7] }
        """
    )
    robot = file.scene.robot
    assert robot.nv == 18
    assert robot.joint_names[9] == "right/panda_joint1"
    placement = np.array(robot.parts[1].placement)
    assert placement[:3, 3].tolist() == [0, 1, 0.5]
    np.testing.assert_array_equal(placement[:3, :3], pin.rpy.rpyToMatrix(0, 0, 0.7))


@given(st.tuples(*[st.floats(-1e3, 1e3).filter(lambda x: abs(x) > 1e-3)] * 3))
def test_a_normal_keeps_its_bits_from_the_first_time_on(normal):
    once = Contact("a", normal=normal)
    assert Contact("a", normal=once.normal).normal == once.normal
    assert math.hypot(*once.normal) == pytest.approx(1.0, abs=1e-15)


# Writing


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_reads_back_the_same(path, tmp_path):
    file = ik.load_scene(path)
    copy = tmp_path / "copy.toml"
    ik.save_scene(copy, file.scene, file.q, file.v, points=file.points)
    again = ik.load_scene(copy)
    assert same_bits(file, again)
    text = copy.read_text()
    ik.save_scene(copy, again.scene, again.q, again.v, points=again.points)
    assert copy.read_text() == text


@pytest.mark.parametrize("name", ["talos", "talos_legs", "talos_full", "ur5", "solo8", "anymal"])
def test_example_robots_are_written_by_name(name, load):
    robot = ik.Robot.from_example(name, root="freeflyer")
    text = dump_scene(ik.Scene(robot))
    assert re.search(r'^example = "', text, re.M) and "urdf" not in text
    assert load(text).scene.robot.parts == robot.parts


finite = st.floats(-1e100, 1e100)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.lists(finite, min_size=30, max_size=30))
def test_floats_come_back_bit_for_bit(tmp_path_factory, x):
    # -0.0, subnormals and 17 digits among them.
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(3), root="planar")
    scene = ik.Scene(
        robot,
        [
            ik.AppliedImpulse("link_2", x[0:3], x[3:6], x[6:9], name='a "quoted" näme'),
            ik.JointImpulse("joint_2", x[9]),
            ik.JointImpulse("root_joint", x[10:13]),
        ],
        gravity=x[13:16],
    )
    q = robot.neutral()
    q[[0, 1, 4, 5]] = x[16:20]
    path = tmp_path_factory.mktemp("bits") / "scene.toml"
    points = [ReportPoint("link_3", x[25:28], "tip")]
    ik.save_scene(path, scene, q, x[20:25], points=points)
    file = ik.load_scene(path)
    again = SceneFile("", scene, q, np.array(x[20:25]), tuple(points))
    assert same_bits(file, again)


def test_placements_come_back_bit_for_bit(load):
    rotation = pin.rpy.rpyToMatrix(0.1, 0.2, 0.3)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, [1 / 3, 0, 0]
    arm, ball = (
        ik.Robot.from_example("panda"),
        ik.Robot.from_urdf(ROOT / "models/ball.urdf", "freeflyer"),
    )
    robot = ik.combine(arm=arm, ball=ball, placements={"ball": matrix, "arm": [0.1, 0.2, 0.3]})
    again = load(dump_scene(ik.Scene(robot))).scene.robot
    assert again.parts == robot.parts and again.model == robot.model


def test_mimic_joints_come_back(load):
    robot = ik.Robot.from_example("pr2", mimic=True)
    text = dump_scene(ik.Scene(robot), robot.neutral())
    assert "mimic = true" in text
    assert load(text).scene.robot.model == robot.model


def test_sections_are_fields_of_a_scene():
    fields = set(ik.Scene.__dataclass_fields__) - {"robot", "gravity"}
    assert {section.name for section in SECTIONS} <= fields


# Faults


def test_all_faults_of_a_file_are_told_at_once_in_its_order(faults_of):
    faults = faults_of(
        "gravty = 1\n"
        + PANDA
        + """
        rot = "planar"
        [state.q]
        panda_joint2x = 0.3
        panda_joint1 = nan
        [[impulses]]
        frame = "panda_hnd"
        liner = [0, 5, 0]
        at = [1, 0]
        [[impulses]]
        fraem = "panda_hand"
        linear = [0, inf, "x"]
        [[impulses]]
        joint = "panda_joint9"
        impulse = 1
        [[report.points]]
        frame = "panda_hnad"
        lable = "x"
        """
    )
    wanted = [
        r'gravty: no such key; did you mean "gravity"',
        r'robot\.rot: no such key; did you mean "root"',
        r'state\.q\.panda_joint2x: unknown joint .* "panda_joint2"',
        r"state\.q\.panda_joint1: .* nan",
        r"impulses\[0\]\.at must have 3 entries, got 2",
        r'impulses\[0\]\.liner: no such key; did you mean "linear"',
        r'impulses\[0\]\.frame: unknown frame "panda_hnd"; did you mean "panda_hand"',
        r"impulses\[1\]\.linear\[1\] must be a finite number, got inf",
        r'impulses\[1\]\.linear\[2\] must be a number, got "x"',
        r'impulses\[1\]\.fraem: no such key; did you mean "frame"',
        r'impulses\[2\]\.joint: unknown joint "panda_joint9"; did you mean',
        r'report\.points\[0\]\.lable: no such key; did you mean "label"',
        r'report\.points\[0\]\.frame: unknown frame .* "panda_hand"',
    ]
    assert len(faults) == len(wanted)
    for fault, pattern in zip(faults, wanted, strict=True):
        assert re.match(pattern, fault), fault
