"""What turns with a motor is part of M: batches, single states and dense equations agree."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik

from ..robots_with_armature import (
    IN_KERNELS,
    LEFT_TO_SOLVE,
    dense_masses,
    point_jacobian,
    random_configuration,
    random_robot,
)

AT = (0.1, -0.2, 0.05)
ROWS = 3


def _robot(seed, kinds=tuple(IN_KERNELS), size=6):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, rng.choice(list(kinds), size))
    q = np.array([random_configuration(robot, rng) for _ in range(ROWS)])
    return rng, robot, q, rng.normal(size=(ROWS, robot.nv))


def _close(found, right, tolerance=1e-12):
    np.testing.assert_allclose(found, right, rtol=0, atol=tolerance * max(np.abs(right).max(), 1))


@pytest.mark.parametrize("seed", range(3))
def test_a_known_blow_gives_the_jump_of_the_dense_equations(seed):
    _, robot, q, v = _robot(seed)
    blow = ik.AppliedImpulse("link_5", linear=[0.4, -1.0, 0.7], at=AT)
    scene = ik.Scene(robot, [blow])
    batch = ik.solve_batch(scene, q, v, outputs=("dv", "energy_change"))
    assert batch.valid.all()
    for k in range(ROWS):
        masses = dense_masses(robot, q[k])
        right = np.linalg.solve(masses, point_jacobian(robot, q[k], "link_5", AT).T @ blow.linear)
        _close(batch.dv[k], right)
        _close(ik.solve(scene, q[k], v[k]).dv, right)
        work = 0.5 * right @ masses @ (2.0 * v[k] + right)
        assert batch.energy_change[k] == pytest.approx(work, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("kind", LEFT_TO_SOLVE)
def test_joints_of_other_kinds_give_the_dense_jump_too(kind):
    rng = np.random.default_rng(3)
    robot = random_robot(rng, ["continuous", kind, "revolute", kind])
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_3", linear=[0.4, -1.0, 0.7], at=AT)])
    q = np.array([random_configuration(robot, rng) for _ in range(ROWS)])
    batch = ik.solve_batch(scene, q, outputs=("dv",))
    assert batch.valid.all()
    for k in range(ROWS):
        jacobian = point_jacobian(robot, q[k], "link_3", AT)
        _close(
            batch.dv[k], np.linalg.solve(dense_masses(robot, q[k]), jacobian.T @ [0.4, -1.0, 0.7])
        )


@pytest.mark.parametrize("seed", range(2))
def test_a_contact_without_friction_returns_e_times_its_approach(seed):
    _, robot, q, v = _robot(10 + seed)
    normal = np.array([0.0, 0.6, 0.8])
    contact = ik.Contact("link_5", at=AT, normal=normal, restitution=0.3)
    # One contact is solved apart from several, and along the path apart from slip at the end.
    for law in (ik.Law(), ik.Law(restitution="poisson"), ik.Law(order="sequential")):
        scene = ik.Scene(robot, contacts=[contact], law=law)
        batch = ik.solve_batch(scene, q, v, outputs=("dv",))
        assert batch.valid.all()
        for k in range(ROWS):
            row = normal @ point_jacobian(robot, q[k], "link_5", AT)
            moved = np.linalg.solve(dense_masses(robot, q[k]), row)
            impulse = max(-1.3 * (row @ v[k]) / (row @ moved), 0.0)
            _close(batch.dv[k], impulse * moved, 1e-11)


def test_the_armature_of_a_leader_is_not_that_of_who_mimics_it():
    robot = ik.Robot.from_example("panda", mimic=True)
    robot.model.armature = np.linspace(0.1, 0.9, robot.nv)
    scene = ik.Scene(robot, [ik.AppliedImpulse("panda_rightfinger", linear=[1, 2, 0], at=AT)])
    rng = np.random.default_rng(0)
    q = np.array([random_configuration(robot, rng) for _ in range(ROWS)])
    batch = ik.solve_batch(scene, q, outputs=("dv",))
    for k in range(ROWS):
        blow = point_jacobian(robot, q[k], "panda_rightfinger", AT).T @ [1, 2, 0]
        _close(batch.dv[k], np.linalg.solve(dense_masses(robot, q[k]), blow), 1e-11)


def test_what_is_combined_keeps_its_armature():
    _, robot, q, v = _robot(34)
    both = ik.combine(first=robot, second=robot)
    np.testing.assert_array_equal(both.model.armature, np.tile(robot.model.armature, 2))
    scene = ik.Scene(both, [ik.AppliedImpulse("second/link_5", linear=[0, 0, 1], at=AT)])
    dv = ik.solve(scene, np.r_[q[1], q[0]], np.r_[v[1], v[0]]).dv
    row = point_jacobian(robot, q[0], "link_5", AT)[2]
    _close(dv[robot.nv :], np.linalg.solve(dense_masses(robot, q[0]), row))
    _close(ik.solve_batch(scene, np.r_[q[1], q[0]], outputs=("dv",)).dv[0], dv)
