"""What turns with a motor is part of M: batches, single states and dense equations agree."""

from __future__ import annotations

import numpy as np

import impulsekit as ik

from ..robots_with_armature import (
    dense_masses,
    point_jacobian,
    random_configuration,
)

AT = (0.1, -0.2, 0.05)
ROWS = 3


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
