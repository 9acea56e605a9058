"""Rotors behind gears that a URDF tells of add to the diagonal of the mass matrix."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import UrdfError

CHAIN = ik.models.chain_urdf(3)
FORMS = {
    "Drake's": '<actuator name="m"><drake:gear_ratio xmlns:drake="d" value="101"/>'
    '<drake:rotor_inertia xmlns:drake="d" value="6e-5"/></actuator>',
    "as text": '<actuator name="m"><mechanicalReduction>-101</mechanicalReduction>'
    "<motorInertia> 6e-5 </motorInertia></actuator>",
}


def with_transmission(inside, joint="joint_2"):
    transmission = f'<transmission name="t"><joint name="{joint}"/>{inside}</transmission>'
    return CHAIN.replace("</robot>", transmission + "</robot>")


@pytest.mark.parametrize("form", FORMS)
def test_a_rotor_counts_by_the_square_of_its_gear(form):
    robot = ik.Robot.from_urdf(with_transmission(FORMS[form]))
    np.testing.assert_allclose(robot.model.armature, [101**2 * 6e-5, 0])
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_3", linear=[0, 1, 0])])
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    assert impact.is_valid() and ik.check(impact).agrees
    plain = ik.Robot.from_urdf(CHAIN).with_armature({"joint_2": 6e-5}, gear={"joint_2": 101})
    same = ik.solve(ik.Scene(plain, scene.impulses), plain.neutral(), plain.velocity())
    np.testing.assert_allclose(impact.dv, same.dv, rtol=1e-14)


def test_a_transmission_without_a_rotor_adds_nothing():
    ratio = "<actuator><mechanicalReduction>50</mechanicalReduction></actuator>"
    assert not ik.Robot.from_urdf(with_transmission(ratio)).model.armature.any()
    elsewhere = with_transmission(FORMS["as text"], "no_such_joint")
    assert not ik.Robot.from_urdf(elsewhere).model.armature.any()


def test_a_rotor_that_no_motor_has_is_named():
    with pytest.raises(UrdfError, match=r'transmission of joint "joint_2".*motorInertia.*-1'):
        ik.Robot.from_urdf(
            with_transmission("<actuator><motorInertia>-1</motorInertia></actuator>")
        )
