"""What joints bear: balance of every body, exact pins, the freed joint, loops."""

from __future__ import annotations

import sys

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.truths.maximal import impact_of_free_bodies
from impulsekit.impact.forces import body_impulses
from impulsekit.reference import KaneSystem, Load
from impulsekit.reference.whittaker import struck_chain

from ..close import close
from ..reference.models import FOUR_BAR, four_bar_pose
from ..robots import random_blow, random_state


@pytest.mark.parametrize("name", ["icub", "icub_reduced"])
def test_moments_of_inertia_may_round_below_zero(name):
    robot = ik.Robot.from_example(name, root="freeflyer")
    q, v = random_state(robot, 0)
    blow = random_blow(robot.links[-1].name, 0)
    impact = ik.solve(ik.Scene(robot, [blow]), q, v)
    assert min(np.linalg.eigvalsh(one.inertia_in_joint_axes)[0] for one in robot.links) < 0.0
    assert ik.check(impact).agrees
    assert "reactions" in impact.to_dict()


def test_links_behind_fixed_joints_bear_their_own_momentum():
    """A mast with a lamp on top: the weld gives the lamp its momentum and no more."""
    urdf = """<robot name="mast">
      <link name="world_link"/>
      <link name="mast"><inertial><origin xyz="0 0 .5"/><mass value="3"/>
        <inertia ixx=".25" iyy=".25" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="lamp"><inertial><mass value="2"/>
        <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="foot" type="continuous"><parent link="world_link"/><child link="mast"/>
        <axis xyz="0 1 0"/></joint>
      <joint name="weld" type="fixed"><parent link="mast"/><child link="lamp"/>
        <origin xyz="0 0 1"/></joint></robot>"""
    robot = ik.Robot.from_urdf(urdf)
    blow = ik.AppliedImpulse("mast", linear=(6, 0, 0), at=(0, 0, 1))
    impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
    # Inertia about the foot: 3/3 + 2; the lamp moves at 6/3 m/s.
    np.testing.assert_allclose(impact.dv, [2.0], rtol=1e-14)
    close(impact.reactions["weld"], [4, 0, 0, 0, 0, 0], 1e-14)
    close(impact.reactions["foot"][0], 3 * 1 + 2 * 2 - 6, 1e-14)


@pytest.mark.parametrize(
    ("name", "root"), [("panda", "fixed"), ("solo12", "freeflyer"), ("talos", "freeflyer")]
)
def test_reactions_are_those_of_pinocchio(name, root):
    robot = ik.Robot.from_example(name, root=root)
    q, v = random_state(robot, 1)
    frames = [robot.links[-1].name, robot.links[len(robot.links) // 2].name]
    contacts = [ik.Contact(frames[0], friction=0.5, rolling=0.01, torsion=0.02)]
    anchors = [ik.DistanceAnchor(frames[1], other_at=[0.3, 0.2, 2.0])]
    scene = ik.Scene(robot, [random_blow(frames[1], 1)], anchors, contacts)
    impact = ik.solve(scene, q, v)
    model = pin.Model(robot.model)
    model.gravity.setZero()
    outside = [pin.Force.Zero() for _ in model.names]
    for item in body_impulses(impact):
        outside[item.joint_id] += item.wrench_in_joint
    data = model.createData()
    pin.rnea(model, data, q, 0.0 * v, np.array(impact.dv), pin.StdVec_Force(outside))
    size = max(np.abs(force.vector).max() for force in outside)
    for joint in range(1, model.njoints):
        turn = np.kron(np.eye(2), impact.mechanics.joint_rotations[joint])
        close(impact.reactions[model.names[joint]], turn @ data.f[joint].vector, 1e-12 * size)


def test_the_first_reactions_of_a_robot_are_one_pass():
    robot = ik.Robot.from_example("talos", root="freeflyer")
    blow = ik.AppliedImpulse("left_sole_link", linear=[0, 1, 0])
    impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
    calls = []
    sys.setprofile(lambda frame, event, _: calls.append(frame) if event == "call" else None)
    try:
        assert len(impact.reactions) > 50
    finally:
        sys.setprofile(None)
    assert len(calls) <= 600


@pytest.mark.parametrize("n", [2, 5, 10, 30])
def test_pins_of_the_free_chain_carry_whittakers_impulses(n):
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(n), root="planar")
    blow = ik.AppliedImpulse(f"link_{n}", linear=(0, 5, 0), at=(1, 0, 0))
    impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
    carried = struck_chain(n, 1, 1, 5).pin_impulses
    for k in range(1, n):
        # S_k is what link k, counted from the struck end, gives the next: the child its parent.
        wanted = [0, -float(carried[k]), 0, 0, 0, 0]
        close(impact.reactions[f"joint_{n + 1 - k}"], wanted, 5e-14)
    close(impact.reactions["root_joint"], 0, 5e-14 * n)


def test_the_pivot_feels_nothing_of_a_blow_on_the_centre_of_percussion():
    length = 0.9
    robot = ik.Robot.from_urdf(ik.models.pendulum_urdf(1, 1.3, length))
    for depth, share in ((2 / 3, 0.0), (1.0, 0.5), (1 / 3, -0.5), (0.0, -1.0)):
        blow = ik.AppliedImpulse("link_1", linear=(3, 0, 0), at=(0, 0, -depth * length))
        impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
        # P (3 d/2 - 1) with d the depth over the length.
        close(impact.reactions["joint_1"], [3 * share, *[0] * 5], 2e-15)


@pytest.mark.parametrize("seed", range(5))
def test_a_loop_s_joints_carry_what_maximal_coordinates_find(seed):
    rng = np.random.default_rng(seed)
    robot = ik.Robot.from_urdf(FOUR_BAR)
    system = KaneSystem.from_urdf(FOUR_BAR)
    q, v = four_bar_pose(rng.uniform(0.3, 2.2)), rng.normal(size=3)
    linear, angular = rng.normal(size=3), rng.normal(size=3)
    # Two rows: across the plane the loop would be held twice and its joints not be unique.
    pin = ik.FrameAnchor("coupler", "rocker", (0.8, 0, 0), (0.5, 0, 0), directions=("x", "y"))
    blow = ik.AppliedImpulse("coupler", linear, angular, at=(0.5, 0.1, 0))
    impact = ik.solve(ik.Scene(robot, [blow], [pin]), q, v)
    rows = system.rows_at_point(
        q, "coupler", "rocker", (0.8, 0, 0), (0.5, 0, 0), directions=np.eye(3)[:2]
    )
    load = Load("coupler", linear, angular, (0.5, 0.1, 0))
    maximal = impact_of_free_bodies(system, q, v, [load], rows=rows)
    size = max(np.abs(wrench).max() for wrench in impact.reactions.values())
    for joint, wrench in impact.reactions.items():
        assert np.abs(maximal.joint_reactions[joint] - wrench).max() < 1e-10 * size, joint
