"""Joint reactions and link velocities of many states at once."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.jobs import falling_talos
from tests.reference.models import mass_matrix

from ..robots import one_body, relative

TALOS = ik.Robot.from_example("talos", root="freeflyer")


def states(robot, count, seed=0):
    rng = np.random.default_rng(seed)
    q = np.array(
        [pin.integrate(robot.model, robot.neutral(), rng.normal(size=robot.nv))
         for _ in range(count)]
    )  # fmt: skip
    return q, rng.normal(size=(count, robot.nv))


def scenes():
    yield (
        "talos on its hands",
        ik.Scene(
            TALOS,
            [ik.AppliedImpulse("torso_2_link", [1, 2, 3], [0.1, 0.2, 0.3], [0.1, 0, 0])],
            contacts=[
                ik.Contact(f"gripper_{side}_base_link", at=[0, 0, -0.1], friction=0.4)
                for side in ("left", "right")
            ],
        ),
    )
    arm = ik.Robot.from_example("panda")
    yield (
        "blows in own axes, a joint impulse",
        ik.Scene(
            arm,
            [
                ik.AppliedImpulse("panda_link5", [1, 2, 3], [4, 5, 6], [0.1, 0.2, 0], axes="local"),
                ik.JointImpulse("panda_joint3", 0.7),
            ],
            constraints=[ik.JointLock("panda_joint2")],
        ),
    )
    both = ik.combine(a=arm, b=arm, placements={"b": [0.5, 0, 0]})
    yield "two arms held together", ik.Scene(
        both,
        [ik.AppliedImpulse("a/panda_link4", [1, 2, 3])],
        constraints=[
            ik.FrameAnchor("a/panda_hand", "b/panda_hand", directions=("x", "rz"), axes="local"),
            ik.PointAnchor("a/panda_link6", "b/panda_link5", at=[0.1, 0, 0], other_at=[0, 0.2, 0]),
            ik.JointCoupling("a/panda_joint1", "b/panda_joint1", 0.5),
        ],
        contacts=[ik.Contact("a/panda_link7", against="b/panda_link7", at=[0, 0, 0.1],
                             friction=0.3), ik.JointStop("b/panda_joint2", lower=-9.0, upper=-8.0)],
    )  # fmt: skip
    yield (
        "planar, continuous and sliding",
        ik.Scene(
            ik.Robot.from_urdf(ik.models.chain_urdf(4), root="planar"),
            [ik.AppliedImpulse("link_4", [0, 5, 0], at=[1, 0, 0])],
        ),
    )


@pytest.mark.parametrize(("name", "scene"), list(scenes()), ids=lambda value: str(value)[:30])
def test_they_are_those_of_single_states(name, scene):
    """``solve`` finds them by Pinocchio's RNEA, which is held against Kane's equations."""
    q, v = states(scene.robot, 6)
    batch = ik.solve_batch(scene, q, v, outputs=("reactions", "bodies", "v_after"))
    assert batch.reactions.shape == (6, len(scene.robot.joint_names), 6)
    compared = 0
    for row in range(len(q)):
        impact = ik.solve(scene, q[row], v[row])
        if not (impact.is_valid() and batch.valid[row]):
            continue
        if np.abs(impact.v_after - batch.v_after[row]).max() > 1e-12 * np.abs(impact.dv).max():
            continue
        compared += 1
        size = max(np.abs(wrench).max() for wrench in impact.reactions.values())
        for k, joint in enumerate(scene.robot.joint_names):
            np.testing.assert_allclose(
                batch.reactions[row, k], impact.reactions[joint], atol=1e-11 * size
            )
        for k, link in enumerate(scene.robot.links):
            body = impact.bodies[link.name]
            expected = np.concatenate([body.dv_com, body.domega])
            np.testing.assert_allclose(
                batch.bodies[row, k], expected, atol=1e-11 * np.abs(impact.dv).max()
            )
    assert compared >= 3


@pytest.mark.slow
def test_a_thousand_falls_on_both_hands():
    """All joints of Talos in one call, as ``solve`` has them row by row."""
    scene, q, v = falling_talos(1000)
    batch = ik.solve_batch(scene, q, v, outputs=("reactions",))
    assert batch.valid.all()
    pressed = 0
    for row in range(0, 1000, 4):
        impact = ik.solve(scene, q[row], v[row])
        expected = np.array([impact.reactions[name] for name in scene.robot.joint_names])
        assert relative(batch.reactions[row] - expected, expected) < 1e-11
        pressed += all(contact.impulse[2] > 0.0 for contact in impact.contacts)
    assert pressed > 50


def test_blows_that_vary_row_by_row():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])])
    blows = np.random.default_rng(1).normal(size=(5, 6))
    batch = ik.solve_batch(scene, robot.neutral(), impulses=blows, outputs=("reactions",))
    for blow, told in zip(blows, batch.reactions, strict=True):
        own = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", blow[:3], blow[3:])])
        impact = ik.solve(own, robot.neutral(), robot.velocity())
        expected = [impact.reactions[name] for name in robot.joint_names]
        np.testing.assert_allclose(told, expected, atol=1e-11 * np.abs(expected).max())


def test_whittakers_pins_carry_what_the_fractions_say():
    from impulsekit.reference.whittaker import struck_chain

    robot = ik.Robot.from_urdf(ik.models.chain_urdf(10), root="planar")
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_10", [0, 5, 0], at=[1, 0, 0])])
    batch = ik.solve_batch(scene, np.array([robot.neutral()] * 3), outputs=("reactions",))
    exact = [float(s) for s in struck_chain(10, impulse=5).pin_impulses]
    pins = np.abs(batch.reactions[0, 1:, 1])
    # The first is the blow itself; nine pins follow.
    np.testing.assert_allclose(pins[::-1], np.abs(exact[1:10]), atol=1e-12)


def told_by_solve(scene, q, v):
    """Reactions and bodies of each row, by ``solve``."""
    robot, reactions, bodies = scene.robot, [], []
    for one_q, one_v in zip(q, v, strict=True):
        impact = ik.solve(scene, one_q, one_v)
        reactions.append([impact.reactions[name] for name in robot.joint_names])
        moved = [impact.bodies[link.name] for link in robot.links]
        bodies.append([[*body.dv_com, *body.domega] for body in moved])
    return np.array(reactions), np.array(bodies)


def test_what_has_no_kernel_for_loads_gets_them_from_solve():
    """Masses that vary, points that geometry finds, joints that only Pinocchio knows."""
    outputs = ("reactions", "bodies", "v_after")
    arm = ik.Robot.from_example("panda")
    scene = ik.Scene(arm, [ik.AppliedImpulse("panda_hand", [1, 2, 3])])
    q, v = states(arm, 2)
    varied = ik.solve_batch(scene, q, v, masses={"panda_link5": [1.0, 3.0]}, outputs=outputs)
    reactions, bodies = told_by_solve(scene, q, v)
    np.testing.assert_allclose(varied.reactions[0], reactions[0], atol=1e-12)
    np.testing.assert_allclose(varied.bodies[0], bodies[0], atol=1e-12)
    # The blow less what the links take is what the world gives: M dv of the heavier arm.
    heavier = arm.model.copy()
    own = next(link for link in arm.links if link.name == "panda_link5")
    heavier.inertias[own.joint_id] += own.spatial_inertia() + own.spatial_inertia()
    masses = mass_matrix(heavier, q[1])
    data = arm.model.createData()
    pin.computeJointJacobians(arm.model, data, q[1])
    hand = arm.model.getFrameId("panda_hand")
    pin.updateFramePlacements(arm.model, data)
    jacobian = pin.getFrameJacobian(arm.model, data, hand, pin.LOCAL_WORLD_ALIGNED)[:3]
    jump = np.linalg.solve(masses, jacobian.T @ [1, 2, 3])
    np.testing.assert_allclose(varied.v_after[1] - v[1], jump, atol=1e-11 * abs(jump).max())

    ball = one_body("ball", 2, 0.1, '<sphere radius=".5"/>').with_ground()
    falls = ik.Scene(ball, contacts=[ik.Collision("ball", "ground", restitution=0.5)])
    q = np.array([ball.configuration(root_joint=[x, 0, 0.5, 0, 0, 0, 1]) for x in (0.0, 3.0)])
    v = np.array([ball.velocity(root_joint=[0, 0, -speed, 0, 0, 0]) for speed in (1.0, 2.0)])
    batch = ik.solve_batch(falls, q, v, outputs=outputs)
    np.testing.assert_allclose(batch.bodies[:, 0, 2], [1.5, 3.0], rtol=1e-12)
    assert np.abs(batch.reactions).max() < 1e-12, "nothing is joined to the ball"

    screw = ik.Robot.from_example("panda", root=pin.JointModelHX(0.1))
    blow = ik.Scene(screw, [ik.AppliedImpulse("panda_hand", [1, 2, 3])])
    q, v = states(screw, 2)
    batch = ik.solve_batch(blow, q, v, outputs=outputs)
    reactions, bodies = told_by_solve(blow, q, v)
    np.testing.assert_allclose(batch.reactions, reactions, atol=1e-12)
    np.testing.assert_allclose(batch.bodies, bodies, atol=1e-12)


def test_moments_against_rolling_and_spin_are_borne_by_joints():
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(3))
    tip = ik.Contact("link_3", at=[0, 0, -1], normal=[1, 0.2, 0.3], friction=0.4, rolling=0.2)
    scene = ik.Scene(arm, contacts=[tip], gap_bound=99)
    q, v = states(arm, 4)
    batch = ik.solve_batch(scene, q, v, outputs=("reactions",))
    turned = 0.0
    for row in range(4):
        one = ik.solve(scene, q[row], v[row])
        turned = max(turned, float(np.abs(one.contacts[0].angular_impulse).max()))
        own = np.array([one.reactions[name] for name in arm.joint_names])
        assert batch.reactions[row] == pytest.approx(own, abs=1e-12)
    assert turned > 0.1


def test_a_robot_without_links_has_no_bodies_to_tell():
    model = pin.Model()
    kind = pin.JointModelUniversal(np.array((1.0, 0.0, 0.0)), np.array((0.0, 1.0, 0.0)))
    joint = model.addJoint(0, kind, pin.SE3.Identity(), "cross")
    model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    placement = pin.SE3(np.eye(3), np.array((0.0, 0.0, 1.0)))
    model.addFrame(pin.Frame("tip", joint, 0, placement, pin.FrameType.OP_FRAME))
    robot = ik.Robot.from_model(model)
    scene = ik.Scene(robot, contacts=[ik.Contact("tip", normal=[1, 0, 0])], gap_bound=np.inf)
    v = np.array([[1.0, -1.0]] * 2)
    batch = ik.solve_batch(scene, robot.neutral(), v, outputs=("bodies",))
    assert batch.bodies.shape == (2, 0, 6)
