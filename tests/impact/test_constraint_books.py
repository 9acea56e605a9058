"""Velocities that are kept or prescribed; the books of energy and momentum."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ..close import close
from ..robots import random_state
from .test_constraints import solved


@pytest.mark.parametrize("axes", ["world", "local"])
def test_prescribed_velocities_are_reached(axes):
    talos = ik.Robot.from_example("talos", root="freeflyer")
    q, v = random_state(talos, 5)
    wanted = np.array([0.3, -0.2, 0.5, 1, 2, 3])
    anchor = ik.FrameAnchor("left_sole_link", at=(0.1, 0, 0.05), axes=axes, velocity=wanted)
    impact = solved(talos, [anchor, ik.JointLock("torso_1_joint", 0.7)], v, q)
    model, data = talos.model, talos.model.createData()
    pin.framesForwardKinematics(model, data, q)
    turned = data.oMf[model.getFrameId("left_sole_link")].rotation if axes == "local" else np.eye(3)
    reached = impact.velocity_at("left_sole_link", (0.1, 0, 0.05)).after
    close(turned.T @ reached, wanted[:3], 1e-12)
    close(impact.constraints[0].velocity_after, wanted, 1e-12)
    assert impact.v_after[model.joints[talos.joint_id("torso_1_joint")].idx_v] == pytest.approx(0.7)


def test_a_point_of_the_world_is_anchored_like_a_point_of_the_link():
    """Which end comes first is a matter of sign, the one that is None of coincidence."""
    dog = ik.Robot.from_example("solo12", root="freeflyer")
    both = ik.combine(dog=dog, placements={"dog": [5, 6, 7]})
    q, v = random_state(both, 2)
    model, data = both.model, both.model.createData()
    pin.framesForwardKinematics(model, data, q)
    local = np.array([0.3, 0.1, -0.2])
    place = data.oMf[both.frame_id("dog/FR_FOOT")].act(local)
    plain = solved(both, [ik.PointAnchor("dog/FR_FOOT", at=local)], v, q)
    turned = solved(both, [ik.PointAnchor("world", "dog/FR_FOOT", at=place)], v, q)
    close(turned.v_after, plain.v_after, 1e-12)
    received = plain.constraints[0].impulse
    close(turned.constraints[0].impulse, -received, 1e-12)
    assert turned.energy.imbalance < 1e-12


# -- books ---------------------------------------------------------------------------------

IMPOSED = {
    "feet": [ik.FrameAnchor("left_sole_link"), ik.FrameAnchor("right_sole_link")],
    "hands": [ik.FrameAnchor("gripper_left_base_link", "gripper_right_base_link", axes="local"),
              ik.JointLock("torso_1_joint")],
    "gears": [ik.JointCoupling("arm_left_4_joint", ["arm_right_4_joint", "head_1_joint"],
                               ratio=[0.5, -2]),
              ik.PointAnchor("head_2_link", "gripper_left_base_link", at=(0, 0, 1))],
    "four corners": [ik.PointAnchor("left_sole_link", at=(x, y, 0))
                     for x in (0.1, -0.1) for y in (0.05, -0.05)],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("imposed", IMPOSED)
@pytest.mark.parametrize("seed", range(3))
def test_carnot_s_theorem(imposed, seed):
    """What imposed constraints take is the energy of the lost velocities."""
    talos = ik.Robot.from_example("talos", root="freeflyer")
    q, v = random_state(talos, seed)
    energy = solved(talos, IMPOSED[imposed], v, q).energy
    assert energy.before - energy.after == pytest.approx(energy.of_lost_velocities, rel=1e-11)
    assert energy.change == pytest.approx(-energy.of_lost_velocities, rel=1e-11)
    assert energy.of_lost_velocities > 0 and energy.imbalance < 1e-12
