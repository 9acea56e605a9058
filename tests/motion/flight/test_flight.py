"""Motion between impacts: the figures of the paper, conservation, charts and integrators."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ..models import MODELS
from ..pendulum import pins_after_blow

TIGHT = {"rtol": 1e-13, "atol": 1e-13}
FOOT = 0.3048


def struck_chain():
    chain = ik.Robot.from_urdf(MODELS / "whittaker_chain_10.urdf", root="planar")
    blow = ik.AppliedImpulse("link_1", linear=[0, 5, 0])
    return ik.Scene(chain, impulses=[blow], gravity=[0, 0, 0])


def struck_pendulum():
    pendulum = ik.Robot.from_urdf(MODELS / "pendulum_10.urdf")
    blow = ik.AppliedImpulse("link_10", linear=[133.447, 0, 0], at=[0, 0, -FOOT])
    return ik.Scene(pendulum, impulses=[blow])


def follow(scene, duration, **changes):
    robot = scene.robot
    return ik.simulate(scene, robot.neutral(), robot.velocity(), duration=duration, **changes)


def test_figure_2_keeps_energy_and_momenta_for_ten_seconds():
    motion = follow(struck_chain(), 10.0, samples=501, **TIGHT)
    energy, momentum = motion.energy().total, motion.momentum()
    assert energy[0] == pytest.approx(5 * 17.3205 / 2, rel=1e-4)
    assert np.ptp(energy) < 1e-9 * energy[0]
    np.testing.assert_allclose(momentum.linear, np.tile([0, 5, 0], (501, 1)), atol=1e-9)
    # Of the size of what is added up: 5 N s at some 5 m.
    assert np.abs(momentum.angular).max() < 1e-9 * 25


@pytest.mark.slow
def test_figure_3_agrees_with_kanes_equations_integrated_on_their_own():
    motion = follow(struck_pendulum(), 2.0, samples=41)
    robot = motion.scene.robot
    known = pins_after_blow(10, 14.5939, FOOT, 133.447, 9.81, motion.t)
    data = robot.model.createData()
    pin_of = [robot.frame_id(f"link_{i}") for i in range(1, 11)]
    for q, wanted in zip(motion.q, known, strict=True):
        pin.framesForwardKinematics(robot.model, data, q)
        ends = [data.oMf[i].act(np.array([0.0, 0.0, -FOOT])) for i in pin_of]
        assert np.abs(np.array(ends)[:, [0, 2]] - wanted).max() < 1e-6


def test_steps_that_are_cut_short_take_four_evaluations_and_are_of_order_four():
    pendulum = ik.Robot.from_urdf(MODELS / "pendulum_10.urdf")
    rng = np.random.default_rng(0)
    start = ik.Scene(pendulum), rng.uniform(-1, 1, pendulum.nq), rng.normal(size=pendulum.nv)
    known = ik.simulate(*start, 0.1, samples=101, **TIGHT)
    errors = []
    for longest in (1e-3, 5e-4):
        motion = ik.simulate(*start, 0.1, samples=101, rtol=1e-6, max_step=longest)
        assert motion.evaluations < 4.4 * motion.steps
        errors.append(np.abs(motion.v - known.v).max())
    assert errors[1] < 1e-8
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"method": "radau", "rtol": 1e-8, "atol": 1e-10}, 1e-7),
        ({"method": "rk4", "step": 5e-4}, 1e-5),
        ({"method": "semi-implicit", "step": 1e-4}, 2e-1),
    ],
)
def test_other_integrators_tell_the_same(changes, error):
    wanted = follow(struck_pendulum(), 0.4)
    motion = follow(struck_pendulum(), 0.4, **changes)
    assert motion.status.finished
    assert np.abs(motion.q - wanted.q).max() < error
