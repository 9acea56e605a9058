"""Bilateral rows that move nothing, or that others imply, stay in the kernels."""

import pathlib

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.batch.solve import solve_batch
from impulsekit.laws.status import Status

from .compare import random_states, worst_difference

pytest.importorskip("numba")

MODELS = pathlib.Path(__file__).parents[2] / "models"
CORNERS = ((0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


@pytest.fixture(scope="module")
def four_bar():
    robot = ik.Robot.from_urdf(MODELS / "four_bar.urdf")
    blow = ik.AppliedImpulse("coupler", linear=[1, 0, 0], at=[0.25, 0, 0])
    loop = ik.PointAnchor("coupler", "rocker", at=[0.5, 0, 0], other_at=[0, 0.5, 0])
    return robot, blow, loop


def agrees_in_kernels(scene, q, v, bar=1e-12):
    worst, batch = worst_difference(scene, q, v)
    assert worst < bar
    return batch


def test_a_row_across_a_planar_loop_bears_nothing(four_bar):
    robot, blow, loop = four_bar
    q, v = random_states(robot, 20, spread=0.5)
    batch = agrees_in_kernels(ik.Scene(robot, [blow], constraints=[loop]), q, v)
    assert not batch.constraint_impulses[:, 2].any()
    assert batch.constraint_impulses[:, :2].any(axis=1).all()


def test_a_scene_at_rest_stays_in_the_kernels(four_bar):
    robot, blow, loop = four_bar
    q, _ = random_states(robot, 20, spread=0.5)
    agrees_in_kernels(ik.Scene(robot, [blow], constraints=[loop]), q, np.zeros((20, robot.nv)))


def test_a_loop_closed_twice_shares_its_impulse(four_bar):
    robot, blow, loop = four_bar
    q, v = random_states(robot, 20, spread=0.5)
    once = solve_batch(
        ik.Scene(robot, [blow], constraints=[loop]), q, v, outputs=("constraint_impulses",)
    )
    twice = agrees_in_kernels(ik.Scene(robot, [blow], constraints=[loop, loop]), q, v)
    halves = twice.constraint_impulses.reshape(20, 2, 3)
    np.testing.assert_allclose(halves[:, 0], halves[:, 1], atol=1e-13)
    np.testing.assert_allclose(halves.sum(axis=1), once.constraint_impulses, atol=1e-12)


def test_redundant_rows_that_contradict_each_other_are_told(solo):
    apart = [
        ik.PointAnchor("base_link", at=at, velocity=(0, 0, k)) for k, at in enumerate(CORNERS * 2)
    ]
    q, v = random_states(solo, 5)
    batch = solve_batch(ik.Scene(solo, constraints=apart), q, v)
    assert (batch.status == Status.CONTRADICTION).all()
    assert np.isnan(batch.v_after).all()


def test_a_lock_beside_a_lock_of_the_same_joint():
    panda = ik.Robot.from_example("panda")
    blow = ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])
    q, v = random_states(panda, 20)
    locks = [ik.JointLock("panda_joint4"), ik.JointLock("panda_joint4")]
    batch = agrees_in_kernels(ik.Scene(panda, [blow], constraints=locks), q, v)
    np.testing.assert_allclose(batch.v_after[:, 3], 0.0, atol=1e-14)


def test_a_pin_on_the_axis_of_the_only_joint_that_could_move_it(capfd):
    panda = ik.Robot.from_example("panda")
    blow = ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])
    pin = ik.PointAnchor("panda_link1", at=(0.0, 0.0, 0.1))
    q, v = random_states(panda, 20)
    batch = agrees_in_kernels(ik.Scene(panda, [blow], constraints=[pin]), q, v)
    assert not batch.constraint_impulses.any()
    assert capfd.readouterr().err == ""


def test_contacts_of_a_body_that_is_held_are_left_to_solve(solo):
    pins = [ik.PointAnchor("base_link", at=at) for at in CORNERS]
    scene = ik.Scene(solo, constraints=pins, contacts=[ik.Contact("base_link")])
    q, v = random_states(solo, 5)
    worst, batch = worst_difference(scene, q, v)
    assert worst < 1e-12
    assert (batch.contact_impulses == 0.0).all()


@pytest.mark.parametrize("angle", [1e-14, 1e-5, 1e-3])
def test_an_arm_all_but_stretched_out_is_as_solve_has_it(angle):
    """Held at its tip, it loses a row as it stretches: near the limit rounding says whether."""
    arm = ik.Robot.from_urdf(MODELS / "whittaker_chain_10.urdf")
    tip = ik.PointAnchor("link_10", at=(1.0, 0.0, 0.0))
    blow = ik.AppliedImpulse("link_2", linear=[0.0, 1.0, 0.0], at=(0.3, 0.0, 0.0))
    q = angle * np.random.default_rng(0).uniform(-1, 1, (8, arm.nq))
    scene = ik.Scene(arm, [blow], constraints=[tip])
    batch = solve_batch(scene, q, np.zeros((8, arm.nv)))
    for i, pose in enumerate(q):
        impact = ik.solve(scene, pose, np.zeros(arm.nv))
        assert impact.status.valid and ik.Status(batch.status[i]).valid
        size = np.abs(impact.dv).max()
        assert np.abs(batch.v_after[i] - impact.v_after).max() < 1e-15 / angle * size + 1e-13
