"""Velocities that are kept or prescribed; the books of energy and momentum."""

from __future__ import annotations

import pytest

import impulsekit as ik

from ..robots import random_state
from .test_constraints import solved

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
