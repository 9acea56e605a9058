"""What is wrong with a URDF is said with the element's name, before Pinocchio sees it."""

from __future__ import annotations

import pathlib

import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import RangeError, SingularMassError, UrdfError
from impulsekit.robot.urdf import read_urdf

LINK = "<link name='{}'/>"
JOINT = (
    "<joint name='{name}' type='{type}'><parent link='{parent}'/><child link='{child}'/>"
    "{inside}</joint>"
)


def urdf(*elements: str) -> str:
    return "<robot name='r'>" + "".join(elements) + "</robot>"


def joint(name="j", type="continuous", parent="a", child="b", inside="") -> str:
    return JOINT.format(name=name, type=type, parent=parent, child=child, inside=inside)


A, B = LINK.format("a"), LINK.format("b")
MASS = "<link name='a'><inertial><mass value='{}'/><inertia {}/></inertial></link>"
MOMENTS = "ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot name='r'>", ["not well-formed XML"]),
        ("<model/>", ["<model>", "<robot>"]),
        (urdf(), ["no link"]),
        (urdf(A, A), ['link "a"', "2 links have this name"]),
        (urdf("<link/>"), ["no name"]),
        (urdf(A, B), ["2 links have no parent", '"a", "b"']),
        (urdf(A, B, joint(type="hinge")), ['joint "j"', '"hinge"', "revolute"]),
        (urdf(A, B, joint(child="c")), ['joint "j"', "<child>", 'unknown link "c"']),
        (urdf(A, B, joint(inside="<axis xyz='0 0 0'/>")), ['joint "j"', "no length"]),
        (urdf(A, B, joint(inside="<axis xyz='0 nan 1'/>")), ["<axis xyz>", "3 finite numbers"]),
        (urdf(A, B, joint(inside="<origin xyz='0 0'/>")), ["<origin xyz>", "0 0", "3 numbers"]),
        (urdf(A, B, joint(), joint(name="k")), ['link "b"', '"j" and "k" both lead to it']),
        (
            urdf(A, B, LINK.format("c"), joint(parent="b", child="c"), joint("k", parent="c")),
            ["parents run in a circle", '"b" < "c" < "b"'],
        ),
        (
            urdf(MASS.format("-1", MOMENTS)),
            ['link "a"', "<mass value> [kg] must be 0 or more, got -1"],
        ),
        (urdf(MASS.format("heavy", MOMENTS)), ["<mass value>", "heavy"]),
        (urdf(MASS.format("1", "ixx='1'")), ['link "a"', "ixy"]),
        (urdf(MASS.format("1", MOMENTS.replace("'1'", "'-1'", 1))), ["ixx", "-1 kg m²"]),
        ("<!DOCTYPE robot [<!ENTITY x 'y'>]><robot name='r'/>", ["document type"]),
    ],
)
def test_a_fault_is_named(text, words):
    with pytest.raises(UrdfError) as caught:
        read_urdf(text)
    for word in words:
        assert word in str(caught.value)


def test_a_missing_file_is_named():
    with pytest.raises(UrdfError, match=r"nowhere\.urdf: there is no such file"):
        read_urdf("nowhere.urdf")


def test_a_folder_is_not_a_urdf(tmp_path):
    with pytest.raises(UrdfError, match="folder"):
        read_urdf(tmp_path)


def test_a_mimic_joint_needs_its_leader_only_when_it_follows():
    text = urdf(A, B, joint(inside="<mimic joint='leader'/>"))
    read_urdf(text)
    with pytest.raises(UrdfError, match="leader"):
        read_urdf(text, mimic=True)


def test_masses_and_mass_centres_are_read():
    text = urdf(MASS.format("2.5", MOMENTS).replace("<mass", "<origin xyz='1 2 3'/><mass"))
    inertial = read_urdf(text).inertials["a"]
    assert (inertial.mass, inertial.com) == (2.5, (1.0, 2.0, 3.0))


LIMIT = "<limit lower='-1' upper='1' effort='1' velocity='1'/>"
THREE = urdf(A, B, LINK.format("c"), "{}", joint("k", "revolute", "b", "c", LIMIT))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (urdf("<link name='universe'/>"), ['link "universe"', "stands for the world"]),
        (urdf("<link name='a&#10;b'/>"), ["U+000A", "printable"]),
        (urdf("<link name='a\x9b31m'/>"), ["U+009B"]),
        (urdf(A, B, "<joint name='j'><parent link='a'/><child link='b'/></joint>"), ["no type"]),
        (urdf(A, B, joint(inside="<axis xyz='0 0 1_0'/>")), ["1_0", "3 numbers"]),
        (urdf(A, B, joint(inside="<origin xyz='0 0 1e999'/>")), ["1e999", "1e+100"]),
        (urdf(A, B, joint(inside="<origin xyz='0 0 ١'/>")), ["3 numbers"]),
        (urdf(A, B, joint(inside=LIMIT.replace("'-1'", "'-inf'"))), ["-inf", "finite number"]),
        (urdf(A, B, joint(inside="<dynamics damping='x'/>")), ["<dynamics damping>"]),
        (urdf(A, "<x>" * 5000 + "</x>" * 5000), ["200 deep"]),
    ],
)
def test_what_pinocchio_would_misread_is_named(text, words):
    with pytest.raises(UrdfError) as caught:
        read_urdf(text)
    for word in words:
        assert word in str(caught.value)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("leader", "words"),
    [
        (joint("j", "revolute", inside=LIMIT + "<mimic joint='j'/>"), "mimics itself"),
        (joint("j", "revolute", inside=LIMIT + "<mimic joint='k'/>"), "meets later"),
        (joint("j", "continuous", inside="<mimic joint='k'/>"), "a continuous joint cannot mimic"),
        (joint("j", "floating", inside="<mimic joint='k'/>"), "a floating joint cannot mimic"),
        (joint("j", "revolute", inside=LIMIT + "<mimic/>"), "<mimic> has no joint"),
        (
            joint("j", "revolute", inside=LIMIT + "<mimic joint='k' multiplier='nan'/>"),
            "<mimic multiplier>",
        ),
    ],
)
def test_a_leader_that_cannot_lead_is_told_before_pinocchio_is_asked(leader, words):
    with pytest.raises(UrdfError, match=words):
        read_urdf(THREE.format(leader), mimic=True)
    read_urdf(THREE.format(leader))


def test_mimic_joints_may_not_follow_each_other_in_a_circle():
    text = THREE.replace("</joint></robot>", "<mimic joint='j'/></joint></robot>")
    both = text.format(joint("j", "revolute", inside=LIMIT + "<mimic joint='k'/>"))
    with pytest.raises(UrdfError, match='"k", which itself mimics "j"'):
        read_urdf(both, mimic=True)


@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_a_chain_that_would_overflow_pinocchios_stack_is_refused(kind):
    def chain(n):
        links = [LINK.format(i) for i in range(n)]
        joints = [joint(f"j{i}", kind, str(i), str(i + 1)) for i in range(n - 1)]
        return urdf(*links, *joints)

    assert ik.Robot.from_urdf(chain(1001)).nv == (1000 if kind == "continuous" else 0)
    with pytest.raises(UrdfError, match="1001 joints follow each other"):
        ik.Robot.from_urdf(chain(1002))


def test_pinocchio_reads_the_same_robot_from_the_checked_text():
    text = pathlib.Path("models/four_bar.urdf").read_text(encoding="utf-8")
    assert ik.Robot.from_urdf(text).model == pin.buildModelFromXML(text)


def test_a_device_is_not_read():
    with pytest.raises(UrdfError, match="a device, not a file"):
        read_urdf("/dev/zero")


MESH = "<link name='a'><collision><geometry><mesh filename='{}'/></geometry></collision></link>"


@pytest.mark.parametrize(
    "filename",
    ["/etc/passwd", "../secret.stl", "file:///etc/passwd", "package://x/../../secret.stl",
     "meshes/../../secret.stl", "package://../secret.stl"],
)  # fmt: skip
def test_a_mesh_outside_the_named_folders_is_not_read(tmp_path, filename):
    (tmp_path / "secret.stl").write_text("solid x\nendsolid x\n")
    (tmp_path / "in" / "meshes").mkdir(parents=True)
    (tmp_path / "in" / "robot.urdf").write_text(urdf(MESH.format(filename)))
    robot = ik.Robot.from_urdf(tmp_path / "in" / "robot.urdf", package_dirs=[tmp_path / "in"])
    with pytest.raises(UrdfError, match="outside the named folders"):
        _ = robot.collision_model


def test_a_mesh_beside_its_urdf_is_read_and_one_in_a_named_folder(tmp_path):
    (tmp_path / "in").mkdir()
    points = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    body = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {points[i]}\n" for i in face)
        + "endloop\nendfacet\n"
        for face in faces
    )
    (tmp_path / "a.stl").write_text(f"solid a\n{body}endsolid a\n")
    beside = tmp_path / "robot.urdf"
    beside.write_text(urdf(MESH.format("a.stl")))
    assert len(ik.Robot.from_urdf(beside).collision_model.geometryObjects) == 1
    below = tmp_path / "in" / "robot.urdf"
    below.write_text(urdf(MESH.format("../a.stl")))
    robot = ik.Robot.from_urdf(below, package_dirs=[tmp_path])
    assert len(robot.collision_model.geometryObjects) == 1


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ("<box size='1 1'/>", "<box size>"),
        ("<box size='1 1 -1'/>", "-1 m"),
        ("<sphere radius='-1'/>", "-1 m"),
        ("<cylinder radius='1'/>", "<cylinder length>"),
        ("<mesh filename=''/>", "no filename"),
        ("<mesh filename='http://example.org/a.stl'/>", "no file"),
        ("<cone/>", "<cone>"),
        ("", "no <geometry>"),
    ],
)
def test_a_shape_that_is_wrong_is_named_when_geometry_is_asked(shape, words):
    text = urdf(f"<link name='a'><collision><geometry>{shape}</geometry></collision></link>")
    robot = ik.Robot.from_urdf(text)
    with pytest.raises(UrdfError, match=words):
        _ = robot.collision_model


INERTIAL = (
    "<link name='a'><inertial><mass value='{mass}'/><inertia ixx='{mass}' iyy='{mass}' "
    "izz='{mass}' ixy='{ixy}' ixz='0' iyz='0'/></inertial></link>"
)


def struck(mass="1", ixy="0"):
    robot = ik.Robot.from_urdf(urdf(INERTIAL.format(mass=mass, ixy=ixy)), root="freeflyer")
    scene = ik.Scene(robot, [ik.AppliedImpulse("a", linear=[0, 0, 1], at=[1, 1, 0])])
    return ik.solve(scene, robot.neutral(), robot.velocity())


def test_an_inertia_that_no_body_has_is_told_as_such():
    with pytest.raises(SingularMassError, match=r"principal moment of inertia of -4 kg m²"):
        struck(ixy="5")


def test_an_answer_that_is_no_number_is_not_valid():
    impact = struck(mass="1e-310")
    assert not impact.is_valid()
    assert impact.status is ik.Status.INACCURATE


def test_a_robot_whose_data_would_not_fit_into_memory_is_refused(monkeypatch):
    monkeypatch.setattr("impulsekit.robot.model_checks.free_memory", lambda: 1e8)
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(140))
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_140", linear=[0, 0, 1])])
    with pytest.raises(RangeError, match=r"139 degrees .* 0\.3 GB, and 0\.1 GB are free"):
        ik.solve(scene, robot.neutral(), robot.velocity())
