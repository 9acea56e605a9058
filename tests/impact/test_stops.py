"""Joints at the end of their travel."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik


@pytest.fixture(scope="module")
def pendulum() -> ik.Robot:
    return ik.Robot.from_urdf(ik.models.pendulum_urdf(2))


@pytest.mark.parametrize(
    ("angle", "rate", "touching", "after"),
    [
        (0.0, -2.0, True, 1.0),  # at the lower limit, going past it
        (-0.1, -2.0, True, 1.0),  # beyond it
        (1.0, 2.0, True, -1.0),  # at the upper one
        (0.5, 2.0, False, 2.0),  # between the two
        (0.0, 2.0, True, 2.0),  # leaving
    ],
)
def test_a_stop_turns_the_joint_back(pendulum, angle, rate, touching, after):
    stop = ik.JointStop("joint_2", lower=0.0, upper=1.0, restitution=0.5)
    impact = ik.solve(ik.Scene(pendulum, contacts=[stop]), [0.3, angle], [1.0, rate])
    result = impact.contacts[0]
    assert result.touching is touching
    assert impact.v_after[1] == pytest.approx(after, abs=1e-14)
    if after != rate:
        assert result.impulse.shape == (1,)
        np.testing.assert_allclose(impact.generalized_impulse, [0.0, result.impulse[0]], atol=1e-14)
        np.testing.assert_allclose(result.velocity_before, [rate])
        np.testing.assert_allclose(result.velocity_after, [after], atol=1e-14)
    else:
        assert not impact.dv.any()
    assert impact.is_valid()


def test_the_models_own_limits_serve_when_none_are_given():
    robot = ik.Robot.from_example("panda")
    upper = robot.model.upperPositionLimit[3]
    q = robot.configuration(panda_joint4=upper)
    v = robot.velocity(panda_joint4=1.0)
    impact = ik.solve(ik.Scene(robot, contacts=[ik.JointStop("panda_joint4")]), q, v)
    assert impact.v_after[3] == pytest.approx(0.0, abs=1e-13)
    assert impact.contacts[0].impulse[0] < 0.0
