"""Building on a robot: the same as if the URDF had been written so."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors
from impulsekit.scenefile import dump_scene
from impulsekit.scenefile.read import read_scene
from tests.reference.models import mass_matrix


def random_states(robot, count=5):
    rng = np.random.default_rng(4)
    for _ in range(count):
        q = pin.integrate(robot.model, robot.neutral(), rng.normal(size=robot.nv))
        yield q, rng.normal(size=robot.nv)


def blow_on(robot, link):
    blow = ik.AppliedImpulse(link, linear=[1, 2, 3], angular=[0.1, 0, 0.2], at=[0.1, 0.2, 0])
    return ik.Scene(robot, [blow])


UR5 = ik.Robot.from_example("ur5").parts[0].urdf
PAYLOAD = """<link name="load"><inertial><origin xyz="0.01 0.02 0.1"/><mass value="2"/>
<inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.02" iyz="0" izz="0.015"/></inertial></link>
<joint name="load_weld" type="fixed"><parent link="tool0"/><child link="load"/></joint></robot>"""
INERTIA = [[0.01, 0.001, 0], [0.001, 0.02, 0], [0, 0, 0.015]]


def with_load(robot, frame="tool0"):
    return robot.with_body(frame, mass=2, com=[0.01, 0.02, 0.1], inertia=INERTIA, name="load")


@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
def test_a_payload_is_the_same_as_a_link_in_the_urdf(root):
    welded = with_load(ik.Robot.from_urdf(UR5, root=root))
    written = ik.Robot.from_urdf(UR5.replace("</robot>", PAYLOAD), root=root)
    assert welded.joint_names == written.joint_names
    for q, v in random_states(welded):
        np.testing.assert_allclose(
            mass_matrix(welded.model, q), mass_matrix(written.model, q), rtol=0, atol=1e-15 * 50
        )
        ours = ik.solve(blow_on(welded, "load"), q, v)
        theirs = ik.solve(blow_on(written, "load"), q, v)
        np.testing.assert_allclose(ours.dv, theirs.dv, atol=1e-13 * abs(theirs.dv).max())
        for name in ours.reactions:
            np.testing.assert_allclose(ours.reactions[name], theirs.reactions[name], atol=1e-11)
        assert ik.check(ours).agrees
        assert ours.bodies["load"].dv_com == pytest.approx(theirs.bodies["load"].dv_com)


def test_the_robot_itself_is_unchanged():
    robot = ik.Robot.from_example("ur5")
    model, mass = pin.Model(robot.model), robot.mass
    changed = with_load(robot).with_lock("elbow_joint").with_armature({"wrist_1_joint": 1})
    assert robot.model == model and robot.mass == mass
    assert changed.nv == robot.nv - 1
    assert changed.mass == pytest.approx(mass + 2)


@pytest.mark.slow
@pytest.mark.parametrize("value", [0.0, 0.7, np.pi / 2, -2.5])
@pytest.mark.parametrize("joint", ["shoulder_pan_joint", "elbow_joint", "wrist_3_joint"])
def test_a_locked_joint_is_the_same_joint_held_at_its_value(joint, value):
    robot = ik.Robot.from_example("ur5")
    locked = robot.with_lock({joint: value})
    row = robot.model.joints[robot.joint_id(joint)].idx_v
    for q, v in random_states(robot):
        q[row], v[row] = value, 0.0
        short_q, short_v = np.delete(q, row), np.delete(v, row)
        held = ik.Scene(robot, blow_on(robot, "tool0").impulses, constraints=[ik.JointLock(joint)])
        ours = ik.solve(blow_on(locked, "tool0"), short_q, short_v)
        theirs = ik.solve(held, q, v)
        np.testing.assert_allclose(ours.dv, np.delete(theirs.dv, row), rtol=1e-10, atol=1e-11)
        assert ik.check(ours).agrees, ik.check(ours).report()
        assert ours.reactions[joint].shape == (6,)
        np.testing.assert_allclose(
            ours.reactions[joint], theirs.reactions[joint], rtol=1e-9, atol=1e-9
        )


def test_several_robots_in_one_world_are_built_on_too():
    arm = ik.Robot.from_example("ur5")
    both = ik.combine(left=arm, right=arm, placements={"right": [0, 1, 0]})
    built = (
        with_load(both, "right/tool0")
        .with_lock({"left/elbow_joint": 0.4})
        .with_armature({"right/elbow_joint": 0.5})
    )
    assert built.nv == 11
    alone = with_load(arm).with_armature({"elbow_joint": 0.5})
    for q, v in random_states(built):
        ours = ik.solve(blow_on(built, "right/load"), q, v)
        theirs = ik.solve(blow_on(alone, "load"), q[5:], v[5:])
        np.testing.assert_allclose(ours.dv[5:], theirs.dv, atol=1e-12 * abs(theirs.dv).max())
        assert ik.check(ours).agrees


def test_what_was_built_comes_back_from_a_scene_file(tmp_path):
    arm = ik.Robot.from_example("ur5")
    built = (
        with_load(arm)
        .with_lock({"elbow_joint": 0.4})
        .with_armature({"wrist_1_joint": 0.3})
        .with_ground(-1.0)
    )
    for robot in (built, ik.combine(a=built, b=arm)):
        link = robot.links[-1].name
        path = tmp_path / "scene.toml"
        ik.save_scene(path, blow_on(robot, link))
        again = ik.load_scene(path).scene.robot
        assert again.model == robot.model
        assert again.parts == robot.parts


MISTAKES = [
    (lambda r: r.with_body("tool", mass=1), errors.UnknownNameError, "tool0"),
    (lambda r: r.with_body("world", mass=1), errors.InputError, "is no link"),
    (lambda r: r.with_body("elbow_joint", mass=1), errors.InputError, "is no link"),
    (lambda r: r.with_body("tool0", mass=-1), errors.RangeError, "mass"),
    (lambda r: r.with_body("tool0", mass="2 kg"), errors.InputError, "must be a number"),
    (lambda r: r.with_body("tool0", mass=float("nan")), errors.NotFiniteError, "mass"),
    (lambda r: r.with_body("tool0", mass=1, com=[0, 0]), errors.ShapeError, "com"),
    (lambda r: r.with_body("tool0", mass=1, inertia=[1, 1, 3]), errors.InputError, "principal"),
    (lambda r: r.with_body("tool0", mass=1, inertia=[[1, 2], [3, 4]]), errors.ShapeError, "(3, 3)"),
    (lambda r: r.with_body("tool0", mass=1, name="base_link"), errors.InputError, "already"),
    (lambda r: r.with_lock("elbow"), errors.UnknownNameError, "elbow_joint"),
    (lambda r: r.with_lock({"elbow_joint": "half"}), errors.InputError, "must be a number"),
    (lambda r: r.with_armature({"elbow_joint": -1}), errors.RangeError, "elbow_joint"),
    (lambda r: r.with_armature({"elbow_joint": [1, 2]}), errors.InputError, "elbow_joint"),
    (lambda r: r.with_armature({"elbow_joint": 1}, gear={"wrist": 2}), errors.InputError, "wrist"),
    (lambda r: r.with_ground(normal=[0, 0, 0]), errors.RangeError, "normal"),
    (lambda r: r.with_ground().with_ground(), errors.InputError, "already"),
]


@pytest.mark.parametrize(("mistake", "kind", "words"), MISTAKES)
def test_a_mistake_is_named(mistake, kind, words):
    with pytest.raises(kind) as caught:
        mistake(ik.Robot.from_example("ur5"))
    assert words in str(caught.value)


def test_the_ground_of_a_combined_world_is_called_ground():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    world = ik.combine(a=ball, b=ball, placements={"b": [1, 0, 0], "a": [0, 0, 2]}).with_ground(0.1)
    scene = ik.Scene(world, contacts=[ik.Collision("b/ball", "ground", restitution=0.5)])
    q = world.configuration({"b/root_joint": [0, 0, 0.15, 0, 0, 0, 1]})
    again = read_scene(dump_scene(scene), "text").scene
    for each in (scene, again):
        impact = ik.solve(each, q, world.velocity({"b/root_joint": [0, 0, -1, 0, 0, 0]}))
        assert impact.contacts[0].touching and impact.v_after[8] == pytest.approx(0.5)
    # A robot that has its own keeps it under its name.
    both = ik.combine(a=ball.with_ground(), b=ball)
    names = [item.name for item in both.collision_model.geometryObjects]
    assert "a/ground" in names and "ground" not in names
