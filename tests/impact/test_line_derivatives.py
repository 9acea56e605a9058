"""Rods and ropes turn with the points that they join: derivatives follow the line."""

import warnings

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, SetupWarning
from impulsekit.models import pendulum_urdf

from ..robots import one_body

STEP = 1e-6

ROD = ik.DistanceAnchor("a/body", "c/link_3", at=[0.1, 0.2, 0])
ROPE = ik.Rope("a/body", "b/body", at=[0, 0.1, 0], length=0.01, restitution=0.3, name="rope")
OTHER = ik.Rope("c/link_3", "a/body", at=[0, 0.1, 0.2], length=0.01, restitution=0.5)


def robot():
    bodies = {name: one_body("body", 1, (0.1, 0.2, 0.15)) for name in "ab"}
    return ik.combine(**bodies, c=ik.Robot.from_urdf(pendulum_urdf(3)))


def differences(scene, q, v, value):
    """Central differences of ``value(impact)`` with the configuration."""
    model, columns = scene.robot.model, []
    for step in STEP * np.eye(model.nv):
        ahead, back = (
            value(ik.solve(scene, pin.integrate(model, q, sign * step), v)) for sign in (1, -1)
        )
        columns.append((ahead - back) / (2 * STEP))
    return np.array(columns).T


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize(
    ("constraints", "contacts"), [([ROD], []), ([], [ROPE]), ([ROD], [ROPE]), ([], [ROPE, OTHER])]
)
def test_derivatives_of_rods_and_ropes_are_differences_of_solve(law, constraints, contacts):
    scene = ik.Scene(robot(), [], constraints, contacts, law=ik.Law(restitution=law))
    model, rng = scene.robot.model, np.random.default_rng(2)
    q = pin.integrate(model, scene.robot.neutral(), rng.normal(size=model.nv))
    v = rng.normal(size=model.nv)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SetupWarning)
        found = ik.derivatives(ik.solve(scene, q, v))
        truth = differences(scene, q, v, lambda impact: impact.v_after)
        assert np.abs(truth).max() > 0.1
        np.testing.assert_allclose(found.dv_after_dq, truth, atol=1e-8 * np.abs(truth).max())
        for index, name in enumerate(found.contacts):
            truth = differences(scene, q, v, lambda impact, i=index: impact.contacts[i].impulse)
            size = max(np.abs(truth).max(), 1.0)
            np.testing.assert_allclose(found.contacts[name].dq, truth, atol=1e-8 * size)


@pytest.mark.slow
def test_a_swinging_rope_that_stretches_has_a_sensitivity():
    body = one_body("body", 1, (0.1, 0.2, 0.15))
    scene = ik.Scene(body, contacts=[ik.Rope("body", at=[0.1, 0.2, 0.05], length=0.6)])
    q = body.configuration(root_joint=[0.1, 0.1, -0.2, 0, 0, 0, 1])
    v = body.velocity(root_joint=[1, 0.4, -2, 0.1, 0.3, -0.5])

    def end(speeds):
        return ik.simulate(scene, q, speeds, duration=0.25).v[-1]

    motion = ik.simulate(scene, q, v, duration=0.25)
    assert len(motion.impacts) == 1
    step = 1e-5 * np.eye(6)[0]
    truth = (end(v + step) - end(v - step)) / 2e-5
    np.testing.assert_allclose(ik.sensitivity(motion).matrix[6:, 6], truth, atol=1e-7)


def test_gaps_that_are_functions_of_q_have_no_derivatives_and_say_so():
    body = one_body("body", 1, (0.1, 0.2, 0.15))
    bowl = ik.GapContact(lambda q: q[2] - 0.1 * q[0] ** 2, restitution=0.4)
    scene = ik.Scene(body, contacts=[bowl])
    q = body.configuration(root_joint=[0.3, 0, 0.009, 0, 0, 0, 1])
    v = body.velocity(root_joint=[1, 0, -2, 0, 0, 0])
    with pytest.raises(InputError, match="second derivatives of its functions"):
        ik.derivatives(ik.solve(scene, q, v))
