"""What turns with a motor is part of M: batches, single states and dense equations agree."""

from __future__ import annotations

import numpy as np

import impulsekit as ik

from ..robots_with_armature import (
    IN_KERNELS,
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
