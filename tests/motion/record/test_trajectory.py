"""``Trajectory``: states, histories, files; and how motions end."""

import sys

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import MotionStatus, errors

from ..models import GRAVITY, MODELS, particle, sliders


@pytest.fixture(scope="module")
def motion():
    ball = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5, name="floor")])
    q = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    v = ball.velocity(root_joint=[1, 0, 0, 0, 3, 0])
    return ik.simulate(scene, q, v, duration=1.0, samples=51)


def test_samples_are_even_and_read_only(motion):
    np.testing.assert_allclose(motion.t, np.linspace(0, 1, 51), atol=0)
    assert motion.q.shape == (51, 7)
    assert motion.v.shape == (51, 6)
    for array in (motion.t, motion.q, motion.v):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_any_time_may_be_asked_for(motion):
    q, _ = motion.at(0.2)
    assert q[2] == pytest.approx(1 - 0.5 * GRAVITY * 0.04, abs=1e-9)
    np.testing.assert_allclose(motion.at(motion.t[7])[0], motion.q[7], atol=1e-14)
    time, impact = motion.impacts[0]
    np.testing.assert_allclose(motion.at(time)[1], impact.v_after, atol=1e-12)
    np.testing.assert_allclose(motion.at(np.nextafter(time, 0))[1], impact.v_before, atol=1e-9)
    for outside in (-1e-9, 1.1, np.nan):
        with pytest.raises(errors.RangeError):
            motion.at(outside)


def test_histories(motion):
    energy, momentum = motion.energy(), motion.momentum()
    assert energy.total.shape == (51,)
    assert momentum.linear.shape == momentum.angular.shape == (51, 3)
    mass = motion.scene.robot.mass
    np.testing.assert_allclose(energy.gravity, mass * GRAVITY * motion.q[:, 2], rtol=1e-12)
    assert momentum.linear[0, 0] == pytest.approx(mass)
    # About the world's origin: r x p, and the spin.
    assert momentum.angular[0, 1] > mass * 1.0


def test_xarray_or_a_clear_word(motion, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "xarray", None)
        with pytest.raises(errors.MissingExtraError, match=r"\.\[study\]"):
            motion.to_xarray()
    pytest.importorskip("xarray")
    data = motion.to_xarray()
    assert data.q.dims == ("time", "coordinate")
    assert data.kinetic_energy.attrs["units"] == "J"
    np.testing.assert_array_equal(data.v.values, motion.v)


def test_stiffness_that_explodes_ends_with_a_status_and_keeps_what_there_is():
    robot = sliders(1)
    stiff = ik.JointSpring("z00", stiffness=1e16, damping=1e3)
    scene = ik.Scene(robot, forces=[stiff])
    motion = ik.simulate(scene, [0.1], [0.0], duration=1.0, max_steps=300)
    assert motion.status is MotionStatus.TOO_MANY_STEPS
    assert "radau" in motion.status.value
    assert 0.0 < motion.duration < 1.0
    assert np.isfinite(motion.q).all()
    assert motion.t[-1] == motion.duration


def test_spins_that_no_number_of_steps_can_follow_end_at_once():
    scene = ik.Scene(ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer"))
    flight = ik.simulate(scene, scene.robot.neutral(), [0, 0, 0, 1e8, 0, 0], duration=1.0)
    assert flight.status is MotionStatus.TOO_MANY_STEPS
    assert flight.steps < 5000
    assert "units of the velocities" in flight.detail


@pytest.mark.parametrize("speed", [1e8, 1e16])
def test_high_speeds_are_followed(speed):
    scene = ik.Scene(ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer"))
    # As fast for as long as it takes: the same motion in other units of time.
    short = ik.simulate(scene, scene.robot.neutral(), [speed, 0, 0, 0, 0, 0], duration=300 / speed)
    assert short.status.finished
    assert np.allclose(short.q[-1], [300, 0, 0, 0, 0, 0, 1], rtol=1e-12)


def test_a_force_without_bound_ends_with_a_status():
    robot = sliders(1)
    away = ik.Actuator("z00", lambda t, q, v: v[0] ** 2)
    scene = ik.Scene(robot, forces=[away], gravity=[0, 0, 0])
    motion = ik.simulate(scene, [0.0], [1.0], duration=2.0)
    assert motion.status in (MotionStatus.STEP_TOO_SMALL, MotionStatus.NOT_FINITE)
    assert motion.duration == pytest.approx(1.0, abs=1e-6)
    assert len(motion.t) > 90


def test_an_event_storm_ends_with_a_status():
    robot = sliders(1)
    # The slower it comes the better it bounces: it never settles.
    floor = ik.Contact("b00", restitution=lambda speed: 1.0 if speed < 0.1 else 0.5)
    scene = ik.Scene(robot, contacts=[floor])
    motion = ik.simulate(scene, [1.0], [0.0], duration=10.0, max_impacts=40)
    assert motion.status is MotionStatus.EVENT_STORM
    assert len(motion.impacts) == 40
    assert 0.0 < motion.duration < 10.0
    assert not motion.status.finished


def test_a_robot_that_is_singular_where_it_starts_is_told():
    # The head of iCub is a point mass: upright, rolling and turning it are one motion less. It
    # was followed by rounding, for half a minute.
    icub = ik.Robot.from_example("icub", root="freeflyer")
    with pytest.raises(errors.SingularMassError, match="neck_roll"):
        ik.simulate(ik.Scene(icub), icub.neutral(), icub.velocity(), duration=0.01)


def test_progress_is_told():
    told = []
    ik.simulate(ik.Scene(particle()), [0, 0, 0], [0, 0, 0], duration=1.0, progress=told.append)
    assert told
    assert told[-1] == 1.0
    assert (np.diff(told) > 0).all()
