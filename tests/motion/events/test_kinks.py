"""One-sided springs: steps end where such a spring begins or ceases to act."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik

from ..models import particle, sliders

NOWHERE = [0, 0, 0]


def test_a_bumper_is_not_flown_past_between_two_looks():
    # 4 m of free flight, of which 2 mm pass by a bumper that reaches 1 mm.
    robot, k, reach, aside = particle(mass=2.0), 2e9, 1e-3, 1e-4
    bumper = ik.Spring("z", stiffness=k, rest_length=reach, acts="push")
    scene = ik.Scene(robot, forces=[bumper], gravity=NOWHERE)
    q, v = robot.configuration(along_x=-2.0, along_y=aside), robot.velocity(along_x=20.0)
    motion = ik.simulate(scene, q, v, duration=0.2)

    def rates(t, y):
        length = np.hypot(y[0], y[1])
        push = k * (reach - length) / (2.0 * length)
        return [y[2], y[3], push * y[0], push * y[1]]

    def leaves(t, y):
        return np.hypot(y[0], y[1]) - reach

    leaves.terminal, leaves.direction = True, 1.0
    begin = [-np.sqrt(reach**2 - aside**2), aside, 20.0, 0.0]
    inside = solve_ivp(rates, (0, 1), begin, "DOP853", events=leaves, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(motion.v[-1, :2], inside.y[2:, -1], rtol=1e-6)
    assert abs(motion.v[-1, 1]) > 0.1


def test_what_comes_to_rest_at_a_kink_rests_there():
    # Damped from both sides it is at rest but for rounding after a second.
    robot = sliders(1)
    springs = [
        ik.JointSpring("z00", stiffness=1000.0, damping=60.0, acts="above"),
        ik.JointSpring("z00", damping=3.0, rest=0.2, acts="below"),
        ik.JointSpring("z00", stiffness=20.0),
    ]
    scene = ik.Scene(robot, forces=springs, gravity=NOWHERE)
    motion = ik.simulate(scene, [0.05], [1.0], duration=30.0, accuracy="high")
    assert motion.status.finished
    np.testing.assert_allclose([motion.q[-1, 0], motion.v[-1, 0]], 0.0, atol=1e-11)


@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_a_motor_at_its_limit_comes_back_from_it_when_it_should(damping):
    # Full torque first, -k q - c v (cosine and sine of the linear law) once that is below it.
    robot, k, limit, start = sliders(1), 100.0, 15.0, 1.0
    m = robot.mass
    motor = ik.Actuator("z00", ik.PD(k, damping, limit=limit))
    scene = ik.Scene(robot, forces=[motor], gravity=NOWHERE)
    motion = ik.simulate(scene, [start], [0.0], duration=4.0)

    def rates(t, y):
        return [y[1], min(max(-k * y[0] - damping * y[1], -limit), limit) / m]

    y, t = np.array([start, 0.0]), 0.0
    side, seen = 1.0, []
    while t < 4.0:

        def off(t, y, side=side):
            torque = -k * y[0] - damping * y[1]
            return limit - abs(torque) if side == 0.0 else side * -torque - limit

        off.terminal, off.direction = True, -1.0

        def own(t, y, side=side):
            torque = -k * y[0] - damping * y[1] if side == 0.0 else -side * limit
            return [y[1], torque / m]

        run = solve_ivp(own, (t, 4.0), y, "DOP853", events=off, rtol=1e-13, atol=1e-15)
        t, y = run.t[-1], run.y[:, -1]
        if run.status == 1:
            seen.append(t)
            side = np.sign(k * y[0] + damping * y[1]) if side == 0.0 else 0.0
            y = y + 1e-14 * np.array(own(t, y, side))
    assert len(seen) > (4 if damping == 0.0 else 0)
    for when in seen:
        assert np.abs(motion.step_times - when).min() < 1e-9
    np.testing.assert_allclose([motion.q[-1, 0], motion.v[-1, 0]], y, atol=1e-9)
