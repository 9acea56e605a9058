"""SDF: links and joints are those of the file, loops are closed by constraints."""

from __future__ import annotations

import warnings

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import AssumptionWarning, MjcfError
from impulsekit.robot.examples import data_folder

LINK = """<link name="{name}"><pose{frame}>{pose}</pose><inertial>
<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose><mass>2</mass>
<inertia><ixx>0.3</ixx><iyy>0.4</iyy><izz>0.5</izz><ixy>0.01</ixy><ixz>0.02</ixz>
<iyz>0.03</iyz></inertia></inertial></link>"""
JOINT = """<joint name="{name}" type="{type}"><pose>{pose}</pose><parent>{parent}</parent>
<child>{child}</child>{inside}</joint>"""
AXIS = "<axis><xyz{frame}>{xyz}</xyz><limit><lower>{lower}</lower><upper>1</upper></limit></axis>"


def link(name, pose="0 0 0 0 0 0", frame=""):
    return LINK.format(name=name, pose=pose, frame=frame and f' relative_to="{frame}"')


def axis(xyz="0 1 0", frame="", lower="-1"):
    return AXIS.format(xyz=xyz, frame=frame and f' expressed_in="{frame}"', lower=lower)


def joint(name, parent, child, kind="revolute", pose="0 0 0 0 0 0", inside=None):
    inside = axis() if inside is None else inside
    return JOINT.format(name=name, type=kind, parent=parent, child=child, pose=pose, inside=inside)


def sdf(*parts):
    return f"<sdf version='1.9'><model name='m'>{''.join(parts)}</model></sdf>"


A, B = link("a"), link("b", "0.3 0 1 0.5 0.2 0.1")


def placement(robot, name, q):
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.frame_id(name)]


def pose(numbers):
    x = np.array([float(word) for word in numbers.split()])
    return pin.SE3(pin.rpy.rpyToMatrix(*x[3:]), x[:3])


def test_links_stand_where_the_file_puts_them():
    text = sdf(
        A, B, link("c", "0.1 0.2 0.3 0.4 0 0", frame="b"),
        joint("j", "a", "b", pose="0.1 0 0.2 0.3 0 0"), joint("k", "b", "c"),
    )  # fmt: skip
    robot = ik.Robot.from_sdf(text)
    assert robot.joint_names == ("j", "k")
    b = pose("0.3 0 1 0.5 0.2 0.1")
    q = robot.neutral()
    assert placement(robot, "b", q).isApprox(b, 1e-14)
    assert placement(robot, "c", q).isApprox(b * pose("0.1 0.2 0.3 0.4 0 0"), 1e-14)


@pytest.mark.parametrize(
    ("frame", "turn"),
    [
        ("", "0.5 0.2 0.1 0.3 0 0"),  # the joint's own
        ("__model__", None),
        ("a", "a"),
        ("b", "b"),
    ],
)
def test_an_axis_lies_in_the_frame_that_it_names(frame, turn):
    a, b = "1 0 0 0.7 0.1 0", "0.3 0 1 0.5 0.2 0.1"
    at = "0.1 0.2 0 0.3 0 0"
    text = sdf(link("a", a), link("b", b),
               joint("j", "a", "b", pose=at, inside=axis("1 2 3", frame)))  # fmt: skip
    robot = ik.Robot.from_sdf(text)
    rotation = {
        "": (pose(b) * pose(at)).rotation,
        "__model__": np.eye(3),
        "a": pose(a).rotation,
        "b": pose(b).rotation,
    }[frame]
    along = rotation @ np.array([1, 2, 3]) / 14**0.5
    # The model stands on its first link; b turns about the axis through the joint.
    stand = pose(a).inverse()
    turned = pin.SE3(pin.exp3(0.4 * along), np.zeros(3))
    through = pin.SE3(np.eye(3), (pose(b) * pose(at)).translation)
    expected = stand * through * turned * through.inverse() * pose(b)
    found = placement(robot, "a", robot.neutral()).inverse() * placement(
        robot, "b", robot.configuration(j=0.4)
    )
    assert found.isApprox(expected, 1e-13), turn


def test_inertias_turn_with_their_pose():
    robot = ik.Robot.from_sdf(sdf(A), root="freeflyer")
    (a,) = robot.links
    turn = pin.rpy.rpyToMatrix(0.4, 0.5, 0.6)
    own = np.array([[0.3, 0.01, 0.02], [0.01, 0.4, 0.03], [0.02, 0.03, 0.5]])
    np.testing.assert_allclose(a.inertia_in_joint_axes, turn @ own @ turn.T, atol=1e-15)
    np.testing.assert_allclose(a.com_in_joint, [0.1, 0.2, 0.3])


def solved(robot, link_name, **options):
    scene = ik.Scene.of_robot(
        robot,
        impulses=[ik.AppliedImpulse(link_name, linear=[1, 2, 3], at=[0.1, 0.2, 0])],
        **options,
    )
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    assert impact.is_valid()
    assert ik.check(impact).agrees, ik.check(impact).report()
    return impact


def test_a_ball_joint_turns_every_way_and_carries_no_moment():
    with pytest.warns(AssumptionWarning, match="three hinges"):
        robot = ik.Robot.from_sdf(sdf(A, B, joint("j", "a", "b", "ball", inside="")), "freeflyer")
    assert robot.nv == 9
    impact = solved(robot, "b")
    np.testing.assert_allclose(impact.reactions["j"][3:], 0, atol=1e-12)


CLOSING = {
    "ball": 3,
    "revolute": 5,
    "prismatic": 5,
    "fixed": 6,
}


@pytest.mark.parametrize("kind", CLOSING)
def test_a_joint_that_closes_a_loop_is_a_constraint(kind):
    """The same mechanism cut open elsewhere, at another joint of the loop, moves alike."""
    c = link("c", "1 0.2 0.3 0.2 0 0.1")
    d = link("d", "0.5 1 0.3 0 0.3 0.1")
    hinges = [
        joint("ab", "a", "b", inside=axis("0 1 0.2")),
        joint("bc", "b", "c", inside=axis("1 0 0.4")),
        joint("ad", "a", "d", inside=axis("0.3 0 1")),
    ]
    closing = joint("dc", "d", "c", kind, inside="" if kind in ("ball", "fixed") else axis("1 1 0"))
    robot = ik.Robot.from_sdf(sdf(A, B, c, d, *hinges, closing), "freeflyer")
    assert robot.nv == 9
    impact = solved(robot, "b")
    assert len(impact.scene.constraints) == 1
    assert len(impact.constraints[0].impulse) == CLOSING[kind]
    # The relative motion across the cut: what the joint leaves free, no more.
    c_at, d_at = (impact.velocity_at(f"dc__{end}").after for end in ("child", "parent"))
    if kind != "prismatic":
        np.testing.assert_allclose(c_at, d_at, atol=1e-12)


def test_a_gearbox_couples_two_joints_against_their_reference():
    gear = joint(
        "gear", "b", "c", "gearbox",
        inside="<gearbox_ratio>0.04</gearbox_ratio>"
        "<gearbox_reference_body>a</gearbox_reference_body>" + axis(),
    )  # fmt: skip
    parts = (A, B, link("c", "1 0 0 0 0 0"), joint("in", "a", "b"), joint("out", "a", "c"), gear)
    robot = ik.Robot.from_sdf(sdf(*parts))
    impact = solved(robot, "c")
    speeds = dict(zip(robot.joint_names, impact.v_after, strict=True))
    assert abs(speeds["in"]) > 0.01
    assert speeds["out"] == pytest.approx(-0.04 * speeds["in"], rel=1e-10)


@pytest.mark.parametrize(
    ("file", "root"),
    [
        ("cassie", "freeflyer"),
        ("cassie_v2", "freeflyer"),
        ("cassie_v2", "fixed"),
        ("cassie_reduced", "fixed"),
        ("cassie_simple", "fixed"),
    ],
)
def test_cassie_with_its_rods_and_springs(file, root):
    """Closing rows hold, and M Δv is the blow and the bearing alone."""
    path = data_folder() / "robots" / "cassie_description" / "robots" / f"{file}.sdf"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AssumptionWarning)
        robot = ik.Robot.from_sdf(path, root)
    assert len(robot.loops) >= 4
    scene = ik.Scene.of_robot(robot, impulses=[ik.AppliedImpulse("left-foot", linear=[0, 0, 5])])
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    assert impact.is_valid()
    assert impact.residuals.constraint < 1e-9
    free = ik.solve(ik.Scene(robot, scene.impulses), robot.neutral(), robot.velocity())
    assert 0 < impact.energy.after < free.energy.after


MISTAKES = [
    (sdf(), "no link"),
    ("<sdf><world/></sdf>", "<model>"),
    (sdf(A, B), 'SDF text: 2 links have no parent ("a", "b"); a robot has one root'),
    (sdf(A, B, joint("j", "a", "x")), '"x" is no link'),
    (sdf(A, B, joint("j", "a", "b", "screw")), '"screw", expected one of'),
    (sdf(A, B, joint("j", "a", "b", inside="")), "no <axis>"),
    (sdf(A, B, joint("j", "a", "b", inside=axis("0 0 0"))), "no length"),
    (sdf(A, B, joint("j", "a", "b", inside=axis("1 0 0", "z"))), 'expressed_in "z"'),
    (sdf(link("a", "0 0 0 0 0")), "6 numbers"),
    (sdf(link("a", "0 0 0 0 0 nan")), "6 finite numbers"),
    (sdf(link("a", frame="b"), link("b", frame="a")), "relative to itself"),
    (sdf(A, "<include><uri>model://arm</uri></include>"), "includes other models"),
    ("<sdf><model name='a'/><model name='b'/></sdf>", "2 models"),
    (sdf(A.replace("<inertial>", "<inertial auto='true'>")), "give its <mass>"),
    ("<robot name='r'/>", "an SDF has <sdf>"),
    ("<sdf><model>", "not well-formed"),
    ("nowhere.sdf", "no such file"),
    (3, "an int"),
]


@pytest.mark.parametrize(("text", "words"), MISTAKES)
def test_a_mistake_is_named(text, words):
    with pytest.raises(MjcfError) as caught:
        ik.Robot.from_sdf(text)
    assert words in str(caught.value)


def test_what_of_a_link_or_axis_has_no_place_is_told():
    wet = A.replace("<inertial>", "<inertial><fluid_added_mass><xx>1</xx></fluid_added_mass>")
    follows = axis().replace("<axis>", "<axis><mimic joint='i'><multiplier>2</multiplier></mimic>")
    with pytest.warns(AssumptionWarning):
        robot = ik.Robot.from_sdf(sdf(wet, B, joint("j", "a", "b", inside=follows)))
    assert 'link "a": its <fluid_added_mass> is left out' in robot.assumptions
    assert 'joint "j": its <mimic> is left out, it moves on its own' in robot.assumptions
