"""Partial velocities are what they say: derivatives of where the bodies are."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from impulsekit.reference import Arithmetic, KaneSystem
from impulsekit.reference.kinematics import partial_rates

from .models import EVERY_KIND, jacobian_at, pinocchio_model, random_state, relative

ROOTS = ["fixed", "planar", "freeflyer"]
FIFTY = Arithmetic.mpmath(50)
# With steps of 1e-16 a central difference errs by 1e-32, far above 50-digit rounding.
STEP = FIFTY.number("1e-16")


def moved(system, model, q, y, time):
    """q after moving with constant speeds y in body axes for an infinitesimal time.

    Displacements to first order in ``time``, in 50 digits; of every joint kind.
    """
    after = FIFTY.array(q)
    for body in system.bodies:
        joint = body.joint
        rate, own = FIFTY.array(y)[joint.speeds] * time, after[joint.coordinates]
        if joint.kind in ("revolute", "prismatic"):
            own += rate
        elif joint.kind == "continuous":
            own += rate[0] * np.array([-own[1], own[0]])
        elif joint.kind == "planar":
            cosine, sine = own[2], own[3]
            own[0] += cosine * rate[0] - sine * rate[1]
            own[1] += sine * rate[0] + cosine * rate[1]
            own[2:] += rate[2] * np.array([-sine, cosine])
        elif joint.kind == "floating":
            x, y_, z, w = own[3:]
            body_index = system.body_of_joint(joint.name)
            turned = system.kinematics(q).rotations
            parent = system.bodies[body_index].parent
            frame = joint.placement[0] if parent < 0 else turned[parent] @ joint.placement[0]
            own[:3] += frame.T @ turned[body_index] @ rate[:3]
            p, r, s = rate[3:] / 2
            own[3:] += np.array(
                [
                    w * p + y_ * s - z * r,
                    w * r + z * p - x * s,
                    w * s + x * r - y_ * p,
                    -x * p - y_ * r - z * s,
                ]
            )
    return after


@pytest.fixture(params=ROOTS)
def every_kind(request):
    model = pinocchio_model(EVERY_KIND, request.param)
    system = KaneSystem.from_urdf(EVERY_KIND, request.param, arithmetic=FIFTY)
    q, y = random_state(model, 3)
    return system, model, system.configuration(q), system.speeds(y)


def test_rates_are_derivatives_of_the_partial_velocities(every_kind):
    """ω̇_klm and v̇_klm of eqs. (3), (4) along the motion."""
    system, model, q, y = every_kind
    rates = partial_rates(system, system.kinematics(q), y)
    ahead = system.kinematics(moved(system, model, q, y, STEP))
    behind = system.kinematics(moved(system, model, q, y, -STEP))
    assert np.abs((ahead.linear - behind.linear) / (2 * STEP) - rates.linear).max() < 1e-27
    assert np.abs((ahead.angular - behind.angular) / (2 * STEP) - rates.angular).max() < 1e-27


@pytest.mark.parametrize("root", ROOTS)
def test_partial_velocities_are_pinocchios_jacobians(root):
    model, system = pinocchio_model(EVERY_KIND, root), KaneSystem.from_urdf(EVERY_KIND, root)
    q, _ = random_state(model, 5)
    at = system.kinematics(q)
    assert at.linear.shape == at.angular.shape == (len(system.link_names), model.nv, 3)
    for k, body in enumerate(system.bodies):
        jacobian = jacobian_at(model, q, body.name, body.mass_centre)
        assert relative(np.vstack([at.linear[k].T, at.angular[k].T]), jacobian) < 1e-14


@pytest.mark.parametrize("root", ROOTS)
def test_accelerations_of_links_are_pinocchios(root):
    model, system = pinocchio_model(EVERY_KIND, root), KaneSystem.from_urdf(EVERY_KIND, root)
    q, y = random_state(model, 6)
    at, change = system.kinematics(q), np.linspace(-1, 1, model.nv)
    rates = partial_rates(system, at, y)
    data = model.createData()
    pin.forwardKinematics(model, data, q, y, change)
    for k, body in enumerate(system.bodies):
        frame = model.getFrameId(body.name, pin.FrameType.BODY)
        pin.updateFramePlacements(model, data)
        model_frame = model.frames[frame]
        owner = model_frame.parentJoint
        centre = pin.SE3(np.eye(3), model_frame.placement.act(body.mass_centre))
        classical = pin.getFrameClassicalAcceleration(
            model, data, owner, centre, pin.LOCAL_WORLD_ALIGNED
        )
        found = at.linear[k].T @ change + rates.linear[k].T @ y  # a_k, eq. (4)
        assert np.abs(found - classical.linear).max() < 1e-12
        found = at.angular[k].T @ change + rates.angular[k].T @ y  # α_k, eq. (3)
        assert np.abs(found - classical.angular).max() < 1e-12
