"""Faults in URDFs."""

# One fault a line, however long; wrong types are what it is about.
# ruff: noqa: E501
# mypy: disable-error-code="arg-type, list-item"

from __future__ import annotations

import pathlib

from impulsekit.robot import Robot

from .fault import Fault
from .things import ARM, arm_text, joint, link

A, B, C = link("base"), link("upper_arm"), link("fore_arm")
SHOULDER = joint("shoulder", parent="base", child="upper_arm")
ELBOW = joint()
LIMIT = '<limit lower="-2" upper="2" effort="10" velocity="5"/>'


def _urdf(what: str, *parts: str, root: str = "fixed", mimic: bool = False) -> Fault:
    return Fault(what, lambda: Robot.from_urdf(arm_text(*parts), root, mimic=mimic))


def _text(what: str, text: str) -> Fault:
    return Fault(what, lambda: Robot.from_urdf(text))


def _file(what: str, content: bytes | None, name: str = "robot.urdf") -> Fault:
    def act() -> None:
        if content is not None:
            pathlib.Path(name).write_bytes(content)
        Robot.from_urdf(name)

    return Fault(what, act)


def _folder() -> None:
    pathlib.Path("robot_description").mkdir()
    Robot.from_urdf("robot_description")


def _shape(what: str, shape: str) -> Fault:
    inside = f"<collision><geometry>{shape}</geometry></collision>"
    return Fault(
        what, lambda: Robot.from_urdf(arm_text(link("base", inside=inside))).collision_model
    )


def _mesh(what: str, filename: str) -> Fault:
    def act() -> None:
        inside = f'<collision><geometry><mesh filename="{filename}"/></geometry></collision>'
        pathlib.Path("meshed.urdf").write_text(arm_text(link("base", inside=inside)))
        pathlib.Path("empty.stl").write_text("")
        _ = Robot.from_urdf("meshed.urdf").collision_model

    return Fault(what, act)


def _chain(count: int) -> str:
    links = "".join(f'<link name="l{i}"/>' for i in range(count))
    joints = "".join(
        joint(f"j{i}", "continuous", f"l{i}", f"l{i + 1}", limit="") for i in range(count - 1)
    )
    return f'<robot name="chain">{links}{joints}</robot>'


def _star(count: int) -> str:
    links = "".join(f'<link name="l{i}"/>' for i in range(count))
    joints = "".join(
        joint(f"j{i}", "fixed", "l0", f"l{i}", inside="", limit="") for i in range(1, count)
    )
    return f'<robot name="star">{links}{joints}</robot>'


FAULTS = (
    _file("loads a URDF that does not exist", None, "no_robot.urdf"),
    Fault("loads a folder as a URDF", _folder),
    _file("loads a picture as a URDF", b"\x89PNG\r\n\x1a\n\0\0", "photo.png"),
    _file("loads a URDF in UTF-16", ARM.encode("utf-16"), "wide.urdf"),
    _file("loads an empty file", b"", "empty.urdf"),
    _file("loads a JSON file as a URDF", b'{"robot": "arm"}', "robot.json"),
    Fault("loads a device as a URDF", lambda: Robot.from_urdf("/dev/zero")),
    Fault("gives a list as a URDF", lambda: Robot.from_urdf([ARM])),
    Fault("gives bytes as a URDF", lambda: Robot.from_urdf(ARM.encode())),
    _file("gives a path with a NUL in it", None, "robot\0.urdf"),
    _text("forgets to close the <robot>", ARM.removesuffix("</robot>")),
    _text("leaves an & in the XML", ARM.replace("base", "base & plate")),
    _text("closes another element than was opened", ARM.replace("</link>", "</lnk>", 1)),
    _text("gives one attribute twice", ARM.replace("<link ", '<link name="x" ', 1)),
    _text("gives an SDF", '<sdf version="1.7"><model name="arm"/></sdf>'),
    _text("gives a URDF with an entity", f'<!DOCTYPE r [<!ENTITY m "1">]>{ARM}'),
    _text("nests elements ten thousand deep", arm_text(A, "<x>" * 10_000 + "</x>" * 10_000)),
    _text("gives a robot without a link", '<robot name="arm"/>'),
    _urdf("leaves a link without name", A, '<link name=""/>'),
    _urdf("leaves a joint without name", A, B, joint("", parent="base", child="upper_arm")),
    _urdf("names two links alike", A, A),
    _urdf("names two joints alike", A, B, C, SHOULDER, joint("shoulder")),
    _urdf("puts a line end into a name", link("upper&#10;arm")),
    _urdf("names a link like Pinocchio's world", link("universe")),
    _urdf("forgets a joint, so that there are two roots", A, B),
    _urdf("gives a link two parents", A, B, C, SHOULDER, joint("second", parent="base", child="fore_arm"), ELBOW),
    _urdf("closes a loop", A, B, C, SHOULDER, ELBOW, joint("back", parent="fore_arm", child="base")),
    _urdf("makes a link its own parent", A, B, joint("self", parent="upper_arm", child="upper_arm")),
    _urdf("misspells the parent of a joint", A, B, joint(parent="bas", child="upper_arm")),
    _urdf("misspells the child of a joint", A, B, joint(parent="base", child="uper_arm")),
    _urdf("leaves out <parent>", A, B, '<joint name="elbow" type="fixed"><child link="upper_arm"/></joint>'),
    _urdf("leaves out <child>", A, B, '<joint name="elbow" type="fixed"><parent link="base"/></joint>'),
    _urdf("leaves out the type of a joint", A, B, joint("shoulder", None, "base", "upper_arm")),
    _urdf("invents a joint type", A, B, joint("shoulder", "hinge", "base", "upper_arm")),
    _urdf("writes a joint type with a capital", A, B, joint("shoulder", "Revolute", "base", "upper_arm")),
    _urdf("gives an axis without length", A, B, joint("shoulder", "revolute", "base", "upper_arm", '<axis xyz="0 0 0"/>')),
    _urdf("gives an axis two numbers", A, B, joint("shoulder", "revolute", "base", "upper_arm", '<axis xyz="0 1"/>')),
    _urdf("gives an axis with a NaN", A, B, joint("shoulder", "revolute", "base", "upper_arm", '<axis xyz="0 nan 1"/>')),
    _urdf("separates numbers by commas", A, B, joint("shoulder", "revolute", "base", "upper_arm", '<axis xyz="0,1,0"/>')),
    _urdf("places a joint 1e999 m away", A, B, joint("shoulder", parent="base", child="upper_arm").replace("0 0 1", "0 0 1e999")),
    _urdf("gives a limit of -inf", A, B, joint("shoulder", parent="base", child="upper_arm", limit=LIMIT.replace('"-2"', '"-inf"'))),
    _urdf("gives a negative damping", A, B, joint("shoulder", parent="base", child="upper_arm", inside='<dynamics damping="-1"/>')),
    _urdf("gives a negative mass", link("base", "-1")),
    _urdf("gives a mass of NaN", link("base", "nan")),
    _urdf("gives a mass with its unit", link("base", "2 kg")),
    _urdf("gives a mass of 1e300 kg", link("base", "1e300")),
    _urdf("leaves out <mass>", A.replace('<mass value="1"/>', "")),
    _urdf("gives a negative moment of inertia", link("base", ixx="-0.1")),
    _urdf("gives a moment of inertia in words", link("base", izz="small")),
    _urdf("places a mass centre by two numbers", A.replace("<mass", '<origin xyz="0 0"/><mass')),
    _text("chains 1500 links", _chain(1500)),
    _text("hangs 10 001 links on one", _star(10_001)),
    _urdf("mimics a joint that does not exist", A, B, joint("shoulder", parent="base", child="upper_arm", inside='<mimic joint="elbw"/>'), mimic=True),
    _urdf("lets a joint mimic itself", A, B, joint("shoulder", parent="base", child="upper_arm", inside='<mimic joint="shoulder"/>'), mimic=True),
    _urdf("lets joints mimic each other", A, B, C, joint("shoulder", parent="base", child="upper_arm", inside='<mimic joint="elbow"/>'), joint(inside='<mimic joint="shoulder"/>'), mimic=True),
    _urdf("lets a joint mimic one further out", A, B, C, joint("shoulder", parent="base", child="upper_arm", inside='<mimic joint="elbow"/>'), ELBOW, mimic=True),
    _urdf("lets a joint mimic a fixed one", A, B, C, joint("weld", "fixed", "base", "upper_arm"), joint(inside='<mimic joint="weld"/>'), mimic=True),
    _urdf("leaves out the leader of <mimic>", A, B, joint("shoulder", parent="base", child="upper_arm", inside="<mimic/>"), mimic=True),
    _urdf("gives a mimic multiplier in words", A, B, C, SHOULDER, joint(inside='<mimic joint="shoulder" multiplier="half"/>'), mimic=True),
    _mesh("asks for geometry whose package is not there", "package://arm_description/hand.stl"),
    _mesh("asks for geometry whose mesh is not there", "meshes/hand.stl"),
    _mesh("names a mesh outside the robot's folders", "../../etc/passwd"),
    _mesh("names a mesh on the network", "https://example.org/hand.stl"),
    _mesh("names no mesh", ""),
    _mesh("asks for geometry whose mesh is an empty file", "empty.stl"),
    _shape("gives a box two sizes", '<box size="1 1"/>'),
    _shape("gives a sphere a negative radius", '<sphere radius="-0.1"/>'),
    _shape("forgets the length of a cylinder", '<cylinder radius="0.1"/>'),
    _shape("invents a shape", '<torus radius="1"/>'),
    _shape("leaves <geometry> empty", ""),
    _shape("scales a mesh by zero", '<mesh filename="a.stl" scale="1 0 1"/>'),
)  # fmt: skip
