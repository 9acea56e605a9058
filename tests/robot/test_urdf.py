"""What is wrong with a URDF is said with the element's name, before Pinocchio sees it."""

from __future__ import annotations

import pytest

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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot name='r'>", ["not well-formed XML"]),
        ("<model/>", ["<model>", "<robot>"]),
        (urdf(), ["no link"]),
        (urdf(A, A), ['link "a"', "2 times"]),
        (urdf("<link/>"), ["no name"]),
        (urdf(A, B), ["2 links have no parent", "a, b"]),
        (urdf(A, B, joint(type="hinge")), ['joint "j"', '"hinge"', "revolute"]),
        (urdf(A, B, joint(child="c")), ['joint "j"', 'child link "c"']),
        (urdf(A, B, joint(type="revolute")), ['joint "j"', "<limit>"]),
        (urdf(A, B, joint(inside="<axis xyz='0 0 0'/>")), ['joint "j"', "no length"]),
        (urdf(A, B, joint(inside="<axis xyz='0 nan 1'/>")), ["<axis xyz>", "3 finite numbers"]),
        (urdf(A, B, joint(inside="<origin xyz='0 0'/>")), ["<origin xyz>", "3 finite"]),
        (urdf(A, B, joint(), joint(name="k")), ['link "b"', "two parents"]),
        (
            urdf(A, B, LINK.format("c"), joint(parent="b", child="c"), joint("k", parent="c")),
            ["ancestor"],
        ),
        (urdf(MASS.format("-1", MOMENTS)), ['link "a"', "-1 kg"]),
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
