"""What is wrong with a URDF is said with the element's name, before Pinocchio sees it."""

from __future__ import annotations

import pytest

import impulsekit as ik
from impulsekit.errors import UrdfError

LINK = "<link name='{}'/>"
JOINT = (
    "<joint name='{name}' type='{type}'><parent link='{parent}'/><child link='{child}'/>"
    "{inside}</joint>"
)


def urdf(*elements: str) -> str:
    return "<robot name='r'>" + "".join(elements) + "</robot>"


def joint(name="j", type="continuous", parent="a", child="b", inside="") -> str:
    return JOINT.format(name=name, type=type, parent=parent, child=child, inside=inside)


@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_a_chain_that_would_overflow_pinocchios_stack_is_refused(kind):
    def chain(n):
        links = [LINK.format(i) for i in range(n)]
        joints = [joint(f"j{i}", kind, str(i), str(i + 1)) for i in range(n - 1)]
        return urdf(*links, *joints)

    assert ik.Robot.from_urdf(chain(1001)).nv == (1000 if kind == "continuous" else 0)
    with pytest.raises(UrdfError, match="1001 joints follow each other"):
        ik.Robot.from_urdf(chain(1002))


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
