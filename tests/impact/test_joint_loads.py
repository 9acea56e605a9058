"""Reactions in joint axes, against statics, closed forms and the reactions in world axes."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, UnknownNameError
from tests.close import close

# A block of 2 kg whose centre is 0.5 m along x from a joint with a tilted axis.
TILTED = """<robot name="arm"><link name="base"/><link name="block"><inertial>
<origin xyz="0.5 0 0"/><mass value="2"/>
<inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="joint" type="{kind}"><parent link="base"/><child link="block"/>
<origin xyz="0 0 1" rpy="0.4 -0.2 0.9"/><axis xyz="0 0.6 0.8"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


def test_a_fixed_joint_gives_its_load_in_the_axes_of_its_child():
    robot = ik.Robot.from_urdf(TILTED.format(kind="fixed"), root="freeflyer")
    blow = ik.AppliedImpulse("block", linear=[1, -2, 3], at=[0.2, 0.3, 0])
    impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
    turn = robot.placement(robot.neutral(), "block").rotation
    close(turn @ impact.joint_loads["joint"].force, impact.reactions["joint"][:3], 1e-14)


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
def test_a_free_joint_carries_nothing_along_its_own_motion(kind):
    robot = ik.Robot.from_urdf(TILTED.format(kind=kind))
    blow = ik.AppliedImpulse("block", linear=[1, -2, 3], angular=[0.1, 0, 2], at=[0.2, 0.3, 0])
    q = robot.configuration(joint=0.7)
    impact = ik.solve(ik.Scene(robot, [blow]), q, robot.velocity())
    load = impact.joint_loads["joint"]
    close(load.axis, [0, 0.6, 0.8], 1e-15)
    own = load.axial if kind == "prismatic" else load.torque
    assert abs(own) < 1e-14
    # The parts make up the whole, whatever the axes.
    wrench = impact.reactions["joint"]
    assert np.hypot(load.axial, load.shear) == pytest.approx(np.linalg.norm(wrench[:3]), rel=1e-14)
    assert np.hypot(load.torque, load.bending) == pytest.approx(
        np.linalg.norm(wrench[3:]), rel=1e-14
    )
    turn = robot.placement(q, "block").rotation
    close(turn @ load.force, wrench[:3], 1e-14)
    close(turn @ load.moment, wrench[3:], 1e-14)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_kick_of_the_motor_is_the_part_along_its_axis(kind):
    robot = ik.Robot.from_urdf(TILTED.format(kind=kind))
    scene = ik.Scene(robot, [ik.JointImpulse("joint", 0.8)])
    load = ik.solve(scene, robot.configuration(joint=-0.4), robot.velocity()).joint_loads["joint"]
    assert (load.axial if kind == "prismatic" else load.torque) == pytest.approx(0.8, abs=1e-14)


def test_a_locked_hinge_carries_a_blow_as_a_cantilever_does():
    robot = ik.Robot.from_urdf(TILTED.format(kind="revolute"))
    q = robot.neutral()
    blow = ik.AppliedImpulse("block", linear=[0, 3, 4], at=[0.5, 0, 0], axes="local")
    scene = ik.Scene(robot, [blow], constraints=[ik.JointLock("joint")])
    load = ik.solve(scene, q, robot.velocity()).joint_loads["joint"]
    # The parent gives minus the blow; (0, 3, 4) is 5 times the axis, its moment lies across it.
    close([load.axial, load.shear, load.torque, load.bending], [-5, 0, 0, 2.5], 1e-14)


def test_joints_without_an_axis_say_so_and_give_their_own_axes():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    blow = ik.AppliedImpulse("FL_FOOT", linear=[0.3, 0.1, 1])
    q = pin.integrate(robot.model, robot.neutral(), np.linspace(-1, 1, robot.nv))
    impact = ik.solve(ik.Scene(robot, [blow]), q, robot.velocity())
    assert set(impact.joint_loads) == set(impact.reactions)
    for name in ("root_joint", "FL_ANKLE"):
        load = impact.joint_loads[name]
        assert load.axis is None
        with pytest.raises(InputError, match=f'"{name}" has no axis'):
            _ = load.bending
    ankle = impact.joint_loads["FL_ANKLE"]
    turn = robot.placement(q, "FL_FOOT").rotation
    close(turn @ ankle.force, impact.reactions["FL_ANKLE"][:3], 1e-14)
    with pytest.raises(UnknownNameError, match="FL_KFE"):
        impact.joint_loads["FL_KFEE"]


def test_a_planar_root_bends_about_its_plane():
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(links=2), root="planar")
    first = robot.links[0].name
    scene = ik.Scene(robot, [ik.AppliedImpulse(first, linear=[0, 1, 2])])
    load = ik.solve(scene, robot.neutral(), robot.velocity()).joint_loads["root_joint"]
    close(load.axis, [0, 0, 1], 0.0)
    # The plane takes the blow along its normal, and nothing within it.
    close([load.axial, load.shear, load.torque], [-2, 0, 0], 1e-14)
