"""Collisions of many pairs of links at once."""

import warnings

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors

MOMENTS = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
INERTIAL = f'<inertial><mass value="1"/><inertia {MOMENTS}/></inertial>'


def tree(count, near=0):
    """A trunk with boxes in a row on hinges, ``near`` of them longer."""
    links, joints = [f'<link name="trunk">{INERTIAL}</link>'], []
    for i in range(count):
        x = 0.4 if i < near else 0.1
        links.append(
            f'<link name="box_{i}">{INERTIAL}<collision><origin xyz="{x / 2} 0 0"/><geometry>'
            f'<box size="{x} 0.05 0.05"/></geometry></collision></link>'
        )
        joints.append(
            f'<joint name="hinge_{i}" type="continuous"><parent link="trunk"/><child '
            f'link="box_{i}"/><origin xyz="0 0 {0.1 * i}"/><axis xyz="0 1 0"/></joint>'
        )
    return ik.Robot.from_urdf(f"<robot name='t'>{''.join(links + joints)}</robot>", "freeflyer")


def arm_with_weld():
    """base - arm - tip (welded) - bare hand; the base is welded to the world."""
    box = '<collision><geometry><box size=".1 .1 .1"/></geometry></collision>'
    links = "".join(
        f'<link name="{name}">{INERTIAL}{"" if name == "hand" else box}</link>'
        for name in ("base", "upper", "lower", "tip", "hand")
    )
    joint = (
        '<joint name="{1}_joint" type="{2}"><parent link="{0}"/><child link="{1}"/>'
        '<origin xyz="0 0 0.3"/></joint>'
    )
    joints = "".join(
        joint.format(*names)
        for names in (
            ("base", "upper", "continuous"),
            ("upper", "lower", "continuous"),
            ("lower", "tip", "fixed"),
            ("tip", "hand", "continuous"),
        )
    )
    return f'<robot name="arm">{links}{joints}</robot>'


def named(pairs):
    return {frozenset((pair.first, pair.other)) for pair in pairs}


def pairs_of(*pairs):
    return {frozenset(pair.split()) for pair in pairs}


def quiet(function, *args, **kwargs):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return function(*args, **kwargs)


def test_two_arms_collide_in_one_scene():
    arm = ik.Robot.from_example("ur5")
    robot = ik.combine(left=arm, right=arm, placements={"right": [0.9, 0, 0]})
    scene = ik.Scene(robot, contacts=ik.collisions(robot, "left/*", "right/*", friction=0.3))
    lifts = {"left/shoulder_lift_joint": -0.4, "right/shoulder_lift_joint": -1.57}
    q = robot.configuration({"left/shoulder_pan_joint": -0.11, **lifts})
    impact = ik.solve(scene, q, robot.velocity({"left/shoulder_pan_joint": -1.0}))
    assert impact.is_valid() and impact.doubts == ()
    struck = [contact.name for contact in impact.contacts if contact.impulse.any()]
    assert struck == ["left/wrist_3_link with right/upper_arm_link"]
    assert np.abs(impact.dv[6:]).max() > 1e-3
    assert ik.check(impact).agrees


def test_neighbours_and_one_rigid_body_are_left_out(tmp_path):
    robot = ik.Robot.from_urdf(arm_with_weld())
    with pytest.warns(ik.errors.SetupWarning, match='without collision geometry.*: "hand"'):
        found = ik.collisions(robot)
    assert named(found) == pairs_of("base lower", "base tip")
    srdf = tmp_path / "arm.srdf"
    srdf.write_text('<robot name="arm"><disable_collisions link1="tip" link2="base"/></robot>')
    robot = ik.Robot.from_urdf(arm_with_weld(), srdf=srdf)
    assert named(quiet(ik.collisions, robot)) == pairs_of("base lower")
    both = ik.combine(a=robot, b=robot, placements={"b": [1, 0, 0]})
    found = named(quiet(ik.collisions, both))
    assert frozenset(("a/tip", "b/base")) in found and len(found) == 2 * 1 + 4 * 4 - 1


def test_a_ground_meets_all_that_moves():
    robot = ik.Robot.from_urdf(arm_with_weld(), "freeflyer").with_ground()
    found = quiet(ik.collisions, robot, "*", "ground")
    assert [(pair.first, pair.other) for pair in found] == [
        (name, "ground") for name in ("base", "upper", "lower", "tip")
    ]
    scene = quiet(ik.Scene, robot, contacts=(), collisions="all")
    assert named(scene.contacts) == named(quiet(ik.collisions, robot)) >= named(found)
    assert quiet(ik.Scene, robot).contacts == ()


def test_talos_comes_down_on_its_feet_alone():
    talos = ik.Robot.from_example("talos", root="freeflyer").with_ground()
    scene = quiet(ik.Scene, talos, collisions="all")
    v = talos.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    impact = ik.solve(scene, talos.poses["half_sitting"], v)
    assert len(scene.contacts) > 900
    struck = {contact.name for contact in impact.contacts if contact.impulse.any()}
    assert struck == {"leg_left_6_link with ground", "leg_right_6_link with ground"}


def test_a_thousand_pairs_are_as_the_ten_that_are_near():
    robot = ik.combine(a=tree(32, near=10), b=tree(32), placements={"b": [0.4, 0, 0]})
    pairs = quiet(ik.collisions, robot, "a/*", "b/*", friction=0.3)
    near = [pair for pair in pairs if pair.first[-2:] == pair.other[-2:] and pair.first[-2] == "_"]
    assert len(pairs) == 1024 and len(near) == 10
    q, v = robot.neutral(), robot.velocity({"a/root_joint": [1, 0, 0, 0, 0, 0]})
    answers = [quiet(ik.solve, ik.Scene(robot, contacts=c), q, v).v_after for c in (pairs, near)]
    assert np.allclose(*answers, rtol=1e-10, atol=1e-12) and answers[0][0] < 1.0


@pytest.mark.parametrize("entry", ["Collision", "collisions"])
def test_a_missing_ground_names_with_ground(entry):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    with pytest.raises(ik.errors.UnknownNameError, match=r"robot\.with_ground\(\)"):
        if entry == "Collision":
            ik.Scene(ball, contacts=[ik.Collision("ball", "ground")])
        else:
            ik.collisions(ball, "ball", "ground")


def overlapping_arm(depth=0.004):
    """A base, a short link, and a link whose box reaches into the base's by a depth [m]."""
    box = (
        '<collision><origin xyz="0 0 {z}"/><geometry><box size=".1 .1 .1"/></geometry></collision>'
    )
    links = "".join(
        f'<link name="{name}">{INERTIAL}{box.format(z=z)}</link>'
        for name, z in (("base", 0.0), ("short", 0.5), ("far", 0.1 - depth))
    )
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent link="{a}"/><child link="{b}"/>'
        '<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        for name, a, b in (("shoulder", "base", "short"), ("elbow", "short", "far"))
    )
    return ik.Robot.from_urdf(f"<robot name='arm'>{links}{joints}</robot>", "freeflyer")


def test_pairs_that_overlap_in_the_neutral_pose_are_left_out_with_one_warning():
    robot = overlapping_arm().with_ground()
    with pytest.warns(errors.SetupWarning, match=r'"base" and "far" \(4 mm\)') as caught:
        scene = ik.Scene(robot, collisions="all")
    assert len(caught) == 1
    assert named(scene.contacts) == pairs_of("base ground", "short ground", "far ground")
    q = robot.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    assert ik.simulate(scene, q, robot.velocity(), duration=0.2).status.finished
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(ik.collisions(overlapping_arm(-0.004).with_ground())) == 4


def test_all_overlaps_of_a_start_are_told_with_what_to_do():
    robot = overlapping_arm().with_ground()
    pairs = [ik.Collision("base", "far"), *quiet(ik.collisions, robot)]
    with pytest.raises(errors.InputError) as caught:
        ik.simulate(ik.Scene(robot, contacts=pairs), robot.neutral(), robot.velocity(), duration=1)
    assert '"base" and "far" overlap by 4 mm at the start: exclude the pair or change q' in str(
        caught.value
    )
    assert '"base" and "ground" overlap by 50 mm at the start: change q' in str(caught.value)


def test_excluded_pairs_do_not_collide():
    robot = overlapping_arm(-0.004).with_ground()
    found = ik.collisions(robot, exclude=[("*", "ground")])
    assert named(found) == pairs_of("base far")
    for wrong in ("ground", [("base",)], [3]):
        with pytest.raises(errors.InputError, match="exclude takes pairs"):
            ik.collisions(robot, exclude=wrong)
    with pytest.raises(errors.UnknownNameError, match='did you mean "far"'):
        ik.collisions(robot, exclude=[("base", "fars")])
