"""What is wrong with a URDF is said with the element's name, before Pinocchio sees it."""

from __future__ import annotations

import pathlib

import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import UrdfError
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


def test_a_mimic_joint_needs_its_leader_only_when_it_follows():
    text = urdf(A, B, joint(inside="<mimic joint='leader'/>"))
    read_urdf(text)
    with pytest.raises(UrdfError, match="leader"):
        read_urdf(text, mimic=True)


def test_masses_and_mass_centres_are_read():
    text = urdf(MASS.format("2.5", MOMENTS).replace("<mass", "<origin xyz='1 2 3'/><mass"))
    inertial = read_urdf(text).inertials["a"]
    assert (inertial.mass, inertial.com) == (2.5, (1.0, 2.0, 3.0))


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


INERTIAL = (
    "<link name='a'><inertial><mass value='{mass}'/><inertia ixx='{mass}' iyy='{mass}' "
    "izz='{mass}' ixy='{ixy}' ixz='0' iyz='0'/></inertial></link>"
)


def struck(mass="1", ixy="0"):
    robot = ik.Robot.from_urdf(urdf(INERTIAL.format(mass=mass, ixy=ixy)), root="freeflyer")
    scene = ik.Scene(robot, [ik.AppliedImpulse("a", linear=[0, 0, 1], at=[1, 1, 0])])
    return ik.solve(scene, robot.neutral(), robot.velocity())


def test_an_answer_that_is_no_number_is_not_valid():
    impact = struck(mass="1e-310")
    assert not impact.is_valid()
    assert impact.status is ik.Status.INACCURATE
