"""The text of a report."""

import re

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.scene import ReportPoint


@pytest.fixture(scope="module")
def chain():
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(3), root="planar")
    scene = ik.Scene(
        robot,
        [
            ik.AppliedImpulse("link_1", [0, 5, 0], [0, 0, 0.1], [0.5, 0, 0], name="blow"),
            ik.JointImpulse("joint_3", 0.4),
            ik.JointImpulse("root_joint", [1, 0, 0]),
        ],
    )
    return ik.solve(scene, robot.configuration(joint_2=0.3), robot.velocity(joint_2=2.0))


def test_numbers_are_those_of_the_impact(chain):
    text = ik.report(chain)
    for i, joint in enumerate(["root_joint vx", "root_joint vy", "root_joint wz", "joint_2"]):
        row = re.search(rf"^  {joint} +(\S+) +(\S+) +(\S+) +(\S+)$", text, re.M)
        numbers = [float(x) for x in row.groups()[:3]]
        wanted = [chain.v_before[i], chain.v_after[i], chain.dv[i]]
        assert numbers == pytest.approx(wanted, rel=1e-5)
        assert row[4] == ("m/s" if "v" in joint.split()[-1] else "rad/s")
    for name, work in chain.energy.work.items():
        row = re.search(rf"^  work of {re.escape(name)} +(\S+)$", text, re.M)
        assert float(row[1]) == pytest.approx(work, rel=1e-5)
    assert chain.status.value in text
    assert "solved: Residuals are at machine precision." in text


def test_constraints_are_shown_with_what_they_carried():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(
        robot,
        [ik.AppliedImpulse("panda_hand", [0, 0, -2])],
        constraints=[
            ik.JointLock("panda_joint2", name="brake"),
            ik.JointCoupling("panda_finger_joint1", "panda_finger_joint2"),
            ik.FrameAnchor("panda_link4", directions=("x", "rz"), axes="local", name="wall"),
        ],
    )
    impact = ik.solve(scene, robot.configuration(panda_joint2=0.5), robot.velocity())
    text = ik.report(impact)
    assert text.startswith("panda: 1 impulse, 3 constraints, 9 degrees of freedom")
    shown = re.findall(r"^  (brake|constraints\[1\]|wall) +(\w+) +(\S+) .*  (N.*)$", text, re.M)
    assert [(name, row) for name, row, *_ in shown] == [
        ("brake", "lock"),
        ("constraints[1]", "coupling"),
        ("wall", "x"),
        ("wall", "rz"),
    ]
    impulses = np.concatenate([result.impulse for result in impact.constraints])
    np.testing.assert_allclose([float(row[2]) for row in shown], impulses, rtol=1e-5, atol=1e-12)
    units = ["N m s, rad/s", "N s, m/s", "N s, m/s", "N m s, rad/s"]
    assert [row[3] for row in shown] == units


def test_a_locked_root_has_the_units_of_each_of_its_speeds():
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(2), root="planar")
    scene = ik.Scene(robot, constraints=[ik.JointLock("root_joint", name="weld")])
    text = ik.report(ik.solve(scene, robot.neutral(), robot.velocity(root_joint=[1, 2, 3])))
    rows = re.findall(r"^  weld +(\w+) .*  (N.*)$", text, re.M)
    linear, angular = "N s, m/s", "N m s, rad/s"
    assert rows == [("lock0", linear), ("lock1", linear), ("lock2", angular)]


def test_redundant_rows_are_named_and_zeros_are_zeros():
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(3), root="planar")
    scene = ik.Scene(
        robot,
        [ik.AppliedImpulse("link_2", [0.3, 1, 0], at=[0.7, 0, 0])],
        constraints=[ik.PointAnchor("link_1", name="pin")],
    )
    text = ik.report(ik.solve(scene, robot.configuration(joint_2=0.3), robot.velocity()))
    assert re.findall(r"^  pin +[xy] +-?\d\S+ +0 +0 +N s, m/s$", text, re.M)
    assert "  pin: only the resultant of z is determined\n" in text


def test_contacts_are_shown_with_impulse_mode_and_speeds():
    robot = ik.combine(
        rod=ik.Robot.from_urdf(ik.models.chain_urdf(1), root="planar"),
        arm=ik.Robot.from_urdf(ik.models.pendulum_urdf(1)),
    )
    scene = ik.Scene(
        robot,
        contacts=[
            ik.Contact("rod/link_1", normal=[0, 1, 0], restitution=0.5, friction=0.1, name="end"),
            ik.JointStop("arm/joint_1", upper=0.0, restitution=0.5, name="catch"),
            ik.JointStop("arm/joint_1", upper=2.0, name="far stop"),
        ],
    )
    v = robot.velocity({"rod/root_joint": [1, -2, 0], "arm/joint_1": 1})
    impact = ik.solve(scene, robot.neutral(), v)
    text = ik.report(impact)
    end, stop = (
        re.search(rf"^  {name} +(.*)$", text, re.M)[1].split() for name in ("end", "catch")
    )
    # A rod that falls flat: a quarter of its mass is at the end.
    assert end[0] == "sliding"
    wanted = [*impact.contacts[0].impulse, -2, 1, 1, 0.925]
    assert [float(x) for x in end[1:]] == pytest.approx(wanted, rel=1e-5)
    assert stop[0] == "arm/joint_1"
    assert [float(x) for x in stop[1:4]] == pytest.approx([-0.5, 1, -0.5], rel=1e-5)
    assert stop[4:] == ["N", "m", "s,", "rad/s"]
    assert "  1 other does not touch; gaps [m, rad]: far stop 2\n" in text


def test_points_are_shown_before_and_after(chain):
    point = ReportPoint("link_3", at=[1, 0, 0], label="tip")
    text = ik.report(chain, [point])
    row = re.search(r"^  tip +(.*)$", text, re.M)[1].split()
    velocity = chain.velocity_at("link_3", [1, 0, 0])
    wanted = [*velocity.before, *velocity.after]
    assert [float(x) for x in row] == pytest.approx(wanted, abs=6e-4)


def test_the_largest_joint_loads_come_first_and_unknown_rotors_are_named():
    arm = ik.Robot.from_example("panda")
    scene = ik.Scene(arm, [ik.AppliedImpulse("panda_hand", linear=[0, 3, -2])])
    impact = ik.solve(scene, arm.neutral(), arm.velocity())
    text = ik.report(impact)
    loads = [impact.joint_loads[name] for name in arm.joint_names]
    loads.sort(key=lambda each: -each.bending)
    rows = re.search(r"Largest joint loads.*?---\n(.*?)\n  no rotor", text, re.S)[1].splitlines()
    assert [row.split()[0] for row in rows] == [load.joint for load in loads[:3]]
    assert float(rows[0].split()[3]) == pytest.approx(loads[0].bending, rel=1e-5)
    geared = arm.with_armature(ik.models.rotor_inertias("panda"))
    assert "no rotor" not in ik.report(
        ik.solve(scene.replace(robot=geared), impact.q, arm.velocity())
    )


def test_joint_loads_are_sorted_by_what_is_above_rounding():
    """A blow along the last axis bends nothing there: what rounding leaves is 0, and comes last."""
    impact = ik.solve(
        ik.Scene(
            ik.Robot.from_urdf(ik.models.chain_urdf(4), root="planar"),
            [ik.AppliedImpulse("link_4", linear=[0, 5, 0], at=[1, 0, 0])],
        ),
        ik.Robot.from_urdf(ik.models.chain_urdf(4), root="planar").neutral(),
        [0.0] * 6,
    )
    table = re.search(r"Largest joint loads.*?---\n(.*?)\n  no rotor", ik.report(impact), re.S)[1]
    cells = np.array([[float(x) for x in row.split()[1:]] for row in table.splitlines()])
    assert (np.diff(cells[:, 1]) <= 0.0).all(), "by shear, where nothing bends"
    assert not cells[:, 0].any() and not cells[:, 2:].any()


def test_what_does_not_touch_is_counted():
    """Of many contacts the report lists those that carry and the three that are nearest."""
    talos = ik.Robot.from_example("talos", root="freeflyer").with_ground()
    q = talos.stand(talos.poses["half_sitting"])
    with pytest.warns(ik.errors.SetupWarning):
        scene = ik.Scene(talos, contacts=ik.collisions(talos, friction=0.6))
        impact = ik.solve(scene, q, talos.velocity(root_joint=[0, 0, -0.5, 0, 0, 0]))
    text = ik.report(impact)
    assert len(scene.contacts) > 900 and len(text.splitlines()) <= 60
    count = sum(not result.touching for result in impact.contacts)
    nearest = re.search(
        rf"  {count} others do not touch; nearest, gaps \[m\]: (.*)\n\nK", text, re.S
    )
    shown = re.findall(r"(\S+ with\s+\S+) (\S+)", nearest[1])
    everyone = ik.touching(scene, q).contacts
    gaps = sorted(
        item.gap for item, one in zip(everyone, impact.contacts, strict=True) if not one.touching
    )
    assert [float(gap.rstrip(",")) for _, gap in shown] == pytest.approx(gaps[:3], rel=1e-5)
    found = impact.to_dict()
    assert len(found["contacts"]) + len(found["not_touching"]) == len(scene.contacts)
    assert len(ik.report(impact, form="json").splitlines()) < 400
    assert len(impact._repr_html_()) < 20_000
