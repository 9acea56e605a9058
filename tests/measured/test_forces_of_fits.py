"""Damping and dry friction of joints come back out of whole motions."""

from dataclasses import replace

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, RangeError, UnknownNameError
from impulsekit.measured import Recording, fit_motion
from impulsekit.models import pendulum_urdf

ARM = ik.Robot.from_urdf(pendulum_urdf(1))
FORCES = {
    "damping": ik.JointSpring("joint_1", stiffness=0.0, damping=0.5, name="bearing"),
    "torque": ik.JointFriction("joint_1", 0.5, name="bearing"),
}


def swings(scene, count=8):
    """Released at rest at several angles, sampled 67 times a second."""
    found = []
    for k in range(count):
        motion = ik.simulate(scene, [0.6 + 0.1 * k], [0.0], duration=0.6, samples=41)
        noise = 1e-4 * np.random.default_rng(k).normal(size=motion.q.shape)
        found.append(Recording(ARM, motion.t, motion.q + noise, sigma=1e-4, name=str(k)))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("what", FORCES)
def test_a_joint_force_comes_back(what):
    true = ik.Scene(ARM, forces=[FORCES[what]], gravity=[0, 0, -9.81])
    wrong = replace(FORCES[what], **{what: 0.6 * getattr(FORCES[what], what)})
    scene = replace(true, forces=[wrong])
    fit = fit_motion(swings(true), scene, forces={"bearing": [what]}, held_out=0.0, threads=1)
    truth = getattr(FORCES[what], what)
    # 8 swings of 41 samples with noise of 1e-4 rad.
    assert fit[f"bearing: {what}"] == pytest.approx(truth, rel=1e-3)
    assert getattr(fit.scene.forces[0], what) == fit.values[0]
    low, high = fit.intervals()[0]
    assert low < truth < high < 1.004 * low
    assert not fit.notes


def test_forces_that_cannot_be_fitted_are_told():
    scene = ik.Scene(ARM, forces=[replace(FORCES["damping"], damping=0.0)], gravity=[0, 0, -9.81])
    recordings = swings(scene)
    with pytest.raises(UnknownNameError, match='unknown force "spring"'):
        fit_motion(recordings, scene, forces={"spring": ["damping"]})
    for given in (["bearing"], {"bearing": "damping"}):
        with pytest.raises(InputError, match="lists of parameters by the name of a force"):
            fit_motion(recordings, scene, forces=given)
    with pytest.raises(UnknownNameError, match="torque"):
        fit_motion(recordings, scene, forces={"bearing": ["torque"]})
    with pytest.raises(RangeError, match=r"damping of bearing.*above 0"):
        fit_motion(recordings, scene, forces={"bearing": ["damping"]})
