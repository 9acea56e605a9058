"""URDFs as exporters write them are read where their meaning is clear, and say what was assumed."""

from __future__ import annotations

import time
import warnings

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import AssumptionWarning, UrdfError

BODY = (
    "<link name='{}'><inertial><mass value='2'/><origin xyz='0.1 0 0.3'/><inertia ixx='.3' "
    "iyy='.4' izz='.5' ixy='0' ixz='0' iyz='0'/></inertial></link>"
)
LIMIT = "<limit lower='-1' upper='1' effort='5' velocity='6'/>"
HINGE = (
    "<joint name='{name}' type='{type}'><parent link='{parent}'/><child link='{child}'/>"
    "<origin xyz='0 0 .5'/><axis xyz='0 1 0'/>{inside}</joint>"
)


def hinge(name="hinge", type="revolute", parent="base", child="arm", inside=LIMIT):
    return HINGE.format(name=name, type=type, parent=parent, child=child, inside=inside)


def robot_text(*elements, attributes=""):
    return f"<robot name='r'{attributes}>" + "".join(elements) + "</robot>"


BASE, ARM = BODY.format("base"), BODY.format("arm")
CLEAN = robot_text(BASE, ARM, hinge())


def read_with_warning(text, **options):
    with pytest.warns(AssumptionWarning) as caught:
        robot = ik.Robot.from_urdf(text, **options)
    assert len(caught) == 1, "one warning a file"
    assert caught[0].filename == __file__, "it points at the line that reads the file"
    assert robot.assumptions == caught[0].message.assumptions
    return robot, "; ".join(robot.assumptions)


def same_dynamics(first, second):
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = pin.integrate(first.model, first.neutral(), rng.normal(size=first.nv))
        masses = [np.triu(pin.crba(m.model, m.model.createData(), q)) for m in (first, second)]
        np.testing.assert_array_equal(*masses)
    return True


def solves_and_checks(robot):
    frame = robot.links[-1].name
    scene = ik.Scene(robot, [ik.AppliedImpulse(frame, linear=[1, 2, 3], at=[0.1, 0.2, 0.3])])
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    return impact.is_valid() and ik.check(impact).agrees


QUIRKS = {
    "limit without effort and velocity": (
        robot_text(BASE, ARM, hinge(inside="<limit lower='-1' upper='1'/>")),
        '"hinge"',
    ),
    "negative effort": (CLEAN.replace("effort='5'", "effort='-1'"), "unlimited"),
    "commas between numbers": (CLEAN.replace("xyz='0 0 .5'", "xyz='0, 0, .5'"), "commas"),
    "a point behind a number": (CLEAN.replace("upper='1'", "upper='1.0.'"), "point"),
    "a visual without a shape": (
        CLEAN.replace("</link>", "<visual/><visual><geometry/></visual></link>", 1),
        "without a shape",
    ),
    "lower above upper": (CLEAN.replace("lower='-1' upper='1'", "lower='1' upper='0'"), "no limit"),
    "revolute without limit": (robot_text(BASE, ARM, hinge(inside="")), "no limit"),
    "default namespace": (
        CLEAN.replace("<robot ", "<robot xmlns='http://drake.mit.edu' "),
        "http://drake.mit.edu",
    ),
    "undeclared prefix": (
        CLEAN.replace("</robot>", "<sensor:camera sensor:rate='3'/></robot>"),
        '"sensor"',
    ),
    "NUL after the end": (CLEAN + "\0\0\n\0", "NUL"),
    "comment before the declaration": (
        "<!-- exported\n by hand -->\n<?xml version='1.0'?>\n" + CLEAN,
        "comment",
    ),
    "products of inertia left out": (
        CLEAN.replace("ixy='0' ixz='0' iyz='0'", ""),
        "products of inertia",
    ),
}


@pytest.mark.parametrize("quirk", QUIRKS)
def test_a_quirk_is_read_as_the_clean_file_and_said(quirk):
    text, words = QUIRKS[quirk]
    robot, assumed = read_with_warning(text)
    assert words in assumed
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        clean = ik.Robot.from_urdf(CLEAN)
    assert same_dynamics(robot, clean)
    assert solves_and_checks(robot)


@pytest.mark.parametrize("quirk", QUIRKS)
def test_a_quirk_is_read_under_a_free_root_and_in_company(quirk):
    text, _ = QUIRKS[quirk]
    robot, _ = read_with_warning(text, root="freeflyer")
    assert solves_and_checks(robot)
    both = ik.combine(left=robot, right=robot)
    assert both.assumptions == 2 * robot.assumptions
    assert solves_and_checks(both)


def test_a_joint_without_limit_may_turn_as_far_as_it_likes():
    robot, _ = read_with_warning(QUIRKS["revolute without limit"][0])
    assert robot.nq == 1
    assert robot.model.upperPositionLimit[0] > 1e300
    assert robot.model.lowerPositionLimit[0] < -1e300


def test_many_comments_at_the_head_take_no_time():
    """Read in a fraction of a second: each comment once, whatever stands behind them."""
    head = "".join(f"<!-- line {i} -->\n" for i in range(60))
    started = time.process_time()
    robot = ik.Robot.from_urdf(head + CLEAN)
    repaired, assumed = read_with_warning(head + "<?xml version='1.0'?>" + CLEAN)
    assert time.process_time() - started < 2.0
    assert same_dynamics(robot, repaired)
    assert "comment" in assumed


def test_a_continuous_joint_with_a_negative_effort_has_none():
    limit = "<limit lower='0' upper='0' effort='-1' velocity='-1'/>"
    robot, assumed = read_with_warning(
        robot_text(BASE, ARM, hinge(type="continuous", inside=limit))
    )
    assert "unlimited" in assumed
    assert robot.model.upperEffortLimit[0] > 1e300
    assert solves_and_checks(robot)


def test_the_world_as_a_parent_that_is_not_written_down():
    text = robot_text(BASE, ARM, hinge(), hinge("weld", "fixed", "world", "base", ""))
    robot, assumed = read_with_warning(text)
    assert '"world"' in assumed
    assert robot.nv == 1
    assert solves_and_checks(robot)
    with pytest.raises(UrdfError, match='unknown link "wrold"'):
        ik.Robot.from_urdf(text.replace("'world'", "'wrold'"))


def test_a_second_missing_link_is_a_fault_all_the_same():
    text = robot_text(BASE, ARM, hinge("weld", "fixed", "world", "base", ""), hinge(child="amr"))
    with pytest.raises(UrdfError, match="unknown link"):
        ik.Robot.from_urdf(text)


def test_a_joint_called_root_joint():
    text = CLEAN.replace("'hinge'", "'root_joint'")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fixed = ik.Robot.from_urdf(text)
    assert fixed.joint_names == ("root_joint",)
    free, assumed = read_with_warning(text, root="freeflyer")
    assert "world_root_joint" in assumed
    assert free.joint_names == ("world_root_joint", "root_joint")
    for robot in (fixed, free):
        assert solves_and_checks(robot)
    q = free.configuration(world_root_joint=[0, 0, 1, 0, 0, 0, 1], root_joint=0.3)
    assert (q[2], q[7]) == (1.0, 0.3)


def test_mimic_on_a_fixed_joint_is_ignored():
    text = robot_text(
        BASE, ARM, BODY.format("tip"), hinge(),
        hinge("weld", "fixed", "arm", "tip", "<mimic joint='hinge'/>"),
    )  # fmt: skip
    robot, assumed = read_with_warning(text, mimic=True)
    assert robot.nv == 1
    assert '"weld"' in assumed
    assert solves_and_checks(robot)


def test_a_follower_of_a_follower_moves_with_the_product_of_both():
    parts = [BODY.format(name) for name in ("base", "a", "b", "c")]
    follow = LIMIT + "<mimic joint='{}' multiplier='{}' offset='{}'/>"
    chain = robot_text(
        *parts,
        hinge("j1", parent="base", child="a"),
        hinge("j2", parent="a", child="b", inside=follow.format("j1", 2, 0.25)),
        hinge("j3", parent="b", child="c", inside=follow.format("j2", -3, 0.5)),
    )
    robot, assumed = read_with_warning(chain, mimic=True)
    assert '"j3"' in assumed
    # q3 = -3 (2 q1 + 0.25) + 0.5
    direct = chain.replace(follow.format("j2", -3, 0.5), follow.format("j1", -6, -0.25))
    assert same_dynamics(robot, ik.Robot.from_urdf(direct, mimic=True))


@pytest.mark.parametrize("prefix", ["xacro", "x", "macro"])
def test_a_xacro_file_is_not_taken_for_a_robot_without_joints(prefix, monkeypatch):
    text = robot_text(
        BASE,
        f"<{prefix}:arm name='left'/>",
        attributes=f" xmlns:{prefix}='http://www.ros.org/wiki/xacro'",
    )
    monkeypatch.setitem(__import__("sys").modules, "xacro", None)
    with pytest.raises(UrdfError, match=r"xacro FILE > robot\.urdf"):
        ik.Robot.from_urdf(text)


def test_an_expanded_file_that_still_declares_xacro_is_a_urdf():
    text = CLEAN.replace("<robot ", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro' ")
    text = text.replace("</robot>", "<!-- ${size} <xacro:arm/> --></robot>")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ik.Robot.from_urdf(text).nv == 1


def test_xacro_is_expanded_where_it_is_installed(tmp_path):
    pytest.importorskip("xacro")
    text = CLEAN.replace("value='2'", "value='${1 + 1}'").replace(
        "<robot ", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro' "
    )
    (tmp_path / "arm.xacro").write_text(text)
    robot, assumed = read_with_warning(tmp_path / "arm.xacro")
    assert "xacro" in assumed
    assert same_dynamics(robot, ik.Robot.from_urdf(CLEAN))
    with pytest.raises(UrdfError, match=r"xacro cannot expand it.*size"):
        ik.Robot.from_urdf(text.replace("${1 + 1}", "${size}"))


def test_other_formats_are_told_with_their_reader():
    with pytest.raises(UrdfError, match="from_mjcf"):
        ik.Robot.from_urdf("<mujoco/>")
    with pytest.raises(UrdfError, match="from_sdf"):
        ik.Robot.from_urdf("<sdf version='1.6'/>")
