"""Forces that act briefly, or jump: their momentum arrives, whenever and however long they act."""

import math

import numpy as np
import pytest

import impulsekit as ik

from ..models import MODELS


@pytest.fixture(scope="module")
def ball():
    return ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")


def pulse(at, width, momentum=1.0):
    """A Gaussian of time whose integral is known; and that integral from 0 to t."""

    def force(t):
        return momentum / width / math.sqrt(2 * math.pi) * math.exp(-0.5 * ((t - at) / width) ** 2)

    def integral(t):
        below = [math.erf((x - at) / width / math.sqrt(2.0)) for x in (0.0, t)]
        return 0.5 * momentum * (below[1] - below[0])

    return force, integral


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dop853", "radau"])
@pytest.mark.parametrize("seed", range(4))
def test_no_pulse_is_stepped_over(ball, seed, method):
    rng = np.random.default_rng(seed)
    duration = 10.0 ** rng.uniform(-2, 3)
    mass = ball.mass
    for _ in range(6 if method == "dop853" else 2):
        at, width = duration * rng.uniform(), duration * 10.0 ** rng.uniform(-3, -1)
        force, integral = pulse(at, width)
        wind = ik.AppliedForce("ball", linear=lambda t, f=force: [0.0, f(t), 0.0])
        scene = ik.Scene(ball, forces=[wind], gravity=[0, 0, 0])
        tolerance = {} if method == "dop853" else {"rtol": 1e-7, "atol": 1e-9}
        motion = ik.simulate(
            scene, ball.neutral(), ball.velocity(), duration=duration, method=method, **tolerance
        )
        assert motion.status.finished
        assert motion.v[-1, 1] == pytest.approx(integral(duration) / mass, rel=1e-4, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["dop853", "radau", "rk4", "semi-implicit"])
@pytest.mark.parametrize("after", [lambda t: t > 1.0, lambda t: t >= 1.0])
def test_a_force_that_jumps_at_a_stop_time_is_exact(ball, method, after):
    force = ik.AppliedForce("ball", linear=lambda t: [3.0 if after(t) else 0.0, 0, 0])
    scene = ik.Scene(ball, forces=[force], gravity=[0, 0, 0])
    motion = ik.simulate(
        scene,
        ball.neutral(),
        ball.velocity(),
        duration=3.0,
        method=method,
        step=0.01,
        stop_times=[1.0, 7.0],
    )
    assert 1.0 in motion.step_times
    assert motion.v[-1, 0] == pytest.approx(6.0 / ball.mass, rel=1e-12)
    if method == "dop853":
        assert motion.steps < 30
    if method != "semi-implicit":
        assert motion.q[-1, 0] == pytest.approx(6.0 / ball.mass, rel=1e-9)


@pytest.mark.parametrize("method", ["dop853", "radau", "rk4"])
def test_no_step_is_longer_than_the_longest(ball, method):
    scene = ik.Scene(ball, gravity=[0, 0, 0])
    motion = ik.simulate(
        scene, ball.neutral(), ball.velocity(), duration=1.0, method=method, step=0.1, max_step=0.03
    )
    assert np.diff([*motion.step_times, 1.0]).max() <= 0.03 * (1.0 + 1e-12)


def test_a_pulse_too_short_to_be_looked_for_is_met_at_stop_times(ball):
    # 1e-5 of the motion.
    force, integral = pulse(0.7, 1e-5)
    wind = ik.AppliedForce("ball", linear=lambda t: [force(t), 0, 0])
    scene = ik.Scene(ball, forces=[wind], gravity=[0, 0, 0])
    times = 0.7 + 1e-5 * np.arange(-8, 9)
    motion = ik.simulate(scene, ball.neutral(), ball.velocity(), duration=1.0, stop_times=times)
    assert motion.v[-1, 0] == pytest.approx(integral(1.0) / ball.mass, rel=1e-8)
