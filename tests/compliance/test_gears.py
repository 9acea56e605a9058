"""Peak torques of gears against a rotor that follows through a spring."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from impulsekit.compliance import gear_peaks

ARM = ik.Robot.from_example("ur5")
BLOW = ik.AppliedImpulse("tool0", linear=[0, 3, 5])
IMPACT = ik.solve(ik.Scene(ARM, [BLOW]), ARM.configuration(elbow_joint=1.0), ARM.velocity())
STIFF = {"elbow_joint": 2e4, "shoulder_lift_joint": 3e4}
ROTORS = {"elbow_joint": 0.92, "shoulder_lift_joint": 1.1}


def test_it_is_the_peak_of_a_rotor_behind_a_spring():
    peak = {each.joint: each for each in gear_peaks(IMPACT, STIFF, inertia=ROTORS)}["elbow_joint"]
    k, J = STIFF["elbow_joint"], ROTORS["elbow_joint"]

    def rates(_, y):  # wind-up and speed of the rotor behind a link that moves on at Δω
        return [peak.jump - y[1], k * y[0] / J]

    end = math.pi * math.sqrt(J / k)
    followed = solve_ivp(rates, (0, end), [0, 0], rtol=1e-10, atol=1e-12, max_step=end / 400)
    assert np.abs(k * followed.y[0]).max() == pytest.approx(peak.torque, rel=1e-4)


def test_the_largest_share_of_its_limit_comes_first():
    limits = {"elbow_joint": 1e3, "shoulder_lift_joint": 1.0}
    first, second = gear_peaks(IMPACT, STIFF, inertia=ROTORS, limits=limits)
    assert first.joint == "shoulder_lift_joint" and first.share > second.share
    assert first.share == first.torque
    geared = ARM.with_armature(ROTORS)
    own = ik.solve(ik.Scene(geared, [BLOW]), IMPACT.q, IMPACT.v_before)
    assert gear_peaks(own, STIFF)[0].torque == pytest.approx(
        gear_peaks(own, STIFF, inertia=ROTORS)[0].torque
    )


def test_what_has_no_gear_is_said():
    with pytest.raises(ik.errors.InputError, match="no rotor is known behind joint"):
        gear_peaks(IMPACT, STIFF)
    with pytest.raises(ik.errors.UnknownNameError, match='did you mean "elbow_joint"'):
        gear_peaks(IMPACT, {"elbow_jiont": 1.0}, inertia=ROTORS)
    with pytest.raises(ik.errors.RangeError, match="stiffness"):
        gear_peaks(IMPACT, {"elbow_joint": -1.0}, inertia=ROTORS)
