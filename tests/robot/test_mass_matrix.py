"""The mass matrix where joints mimic others, again and again with the same memory."""

import numpy as np
import pinocchio as pin

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.robot.masses import crba_of
from tests.robots_with_armature import dense_masses, point_jacobian, random_configuration


def arm(mimic):
    """Three hinges one behind the other, of which the second follows the first, 0.7 times."""
    parts = [link_text(f"link_{k}", k + 1, (0.1, 0.2, 0.15), at="0.1 0.2 0.3") for k in range(4)]
    for k in (1, 2, 3):
        parts.append(
            joint_text(
                f"j{k}", "revolute", f"link_{k - 1}", f"link_{k}", (0, k - 2, 1), at="0.3 0 0.1",
                turn=(0.4, k, 0), far=2,
                more='<mimic joint="j1" multiplier="0.7" offset="0.3"/>' if k == 2 else "",
            )
        )  # fmt: skip
    text = robot_text("m", *parts)
    return ik.Robot.from_urdf(text, root="freeflyer", mimic=mimic)


LED, FREE = arm(True), arm(False)
# Speeds of all joints from those of the arm's.
SPREAD = np.zeros((9, 8))
SPREAD[:7, :7], SPREAD[7, 6], SPREAD[8, 7] = np.eye(7), 0.7, 1.0


def states(seed, count=4):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = pin.integrate(LED.model, LED.neutral(), rng.uniform(-0.8, 0.8, 8))
        yield q, np.r_[q[:8], 0.7 * q[7] + 0.3, q[8]], rng.normal(size=8)


def masses(q):
    """(8, 8) M out of that of the arm whose joints are all free."""
    upper = np.triu(pin.crba(FREE.model, FREE.model.createData(), q))
    return SPREAD.T @ (upper + np.triu(upper, 1).T) @ SPREAD


def test_the_mass_matrix_is_right_every_time():
    data, crba = LED.model.createData(), crba_of(LED.model)
    for led, free, _ in states(0):
        upper = np.triu(crba(LED.model, data, led))
        np.testing.assert_allclose(upper, np.triu(masses(free)), atol=1e-13)


def test_a_blow_moves_a_follower_where_its_offset_puts_it():
    blow = ik.AppliedImpulse("link_3", linear=[1, 2, 3], at=[0.1, 0, 0.2])
    for led, free, v in states(1):
        there = ik.solve(ik.Scene(FREE, [blow]), free, SPREAD @ v)
        dv = ik.solve(ik.Scene(LED, [blow]), led, v).dv
        np.testing.assert_allclose(
            masses(free) @ dv, SPREAD.T @ there.generalized_impulse, atol=1e-12
        )


def test_the_armature_of_a_leader_is_not_that_of_who_mimics_it():
    robot = ik.Robot.from_example("panda", mimic=True)
    robot.model.armature = np.linspace(0.1, 0.9, robot.nv)
    at, rng = (0.1, -0.2, 0.05), np.random.default_rng(0)
    scene = ik.Scene(robot, [ik.AppliedImpulse("panda_rightfinger", linear=[1, 2, 0], at=at)])
    q = np.array([random_configuration(robot, rng) for _ in range(3)])
    batch = ik.solve_batch(scene, q, outputs=("dv",))
    for pose, dv in zip(q, batch.dv, strict=True):
        blow = point_jacobian(robot, pose, "panda_rightfinger", at).T @ [1, 2, 0]
        np.testing.assert_allclose(dv, np.linalg.solve(dense_masses(robot, pose), blow), rtol=1e-9)
