"""Forces over time against closed forms, fifty digits and compliant motions in full."""

import math

import mpmath as mp
import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp
from scipy.special import gamma

import impulsekit as ik
from impulsekit.compliance import Hertz, HuntCrossley, MeasuredCurve, force_history
from impulsekit.models import pendulum_urdf

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
MASS = float(BALL.model.inertias[1].mass)
RUBBER = Hertz(E=1e7, nu=0.5, radius=0.1)


def dropped(e, speed=2.0, **more):
    floor = ik.Contact("ball", at=[0, 0, -0.1], restitution=e, name="floor", **more)
    scene = ik.Scene(BALL, contacts=[floor], gap_bound=np.inf)
    return ik.solve(scene, BALL.neutral(), BALL.velocity(root_joint=[0.4, 0, -speed, 0, 0, 0]))


@pytest.mark.parametrize("e", [1.0, 0.7, 0.05])
def test_hertz_has_the_closed_forms_of_textbooks(e):
    """Johnson (1985), 11.4: δ = (15 m c²/(16 E* √R))^0.4, 2.94 δ/c for both halves."""
    found = force_history(dropped(e), RUBBER)
    deepest = (15.0 * MASS * 4.0 / (16.0 * RUBBER.modulus * math.sqrt(0.1))) ** 0.4
    peak = 4.0 / 3.0 * RUBBER.modulus * math.sqrt(0.1) * deepest**1.5
    half = deepest / 2.0 * math.sqrt(math.pi) * gamma(1.4) / gamma(0.9)
    assert found.indentation == pytest.approx(deepest, rel=1e-12)
    assert found.peak_force == pytest.approx(peak, rel=1e-12)
    assert found.compression == pytest.approx(half, rel=1e-12)
    assert found.duration == pytest.approx(half * (1.0 + e), rel=1e-12)
    assert found.restitution == pytest.approx(e, abs=1e-12)
    assert found.lost == pytest.approx((1.0 - e * e) * 0.5 * MASS * 4.0, rel=1e-12)


@pytest.mark.parametrize("curve", [RUBBER, MeasuredCurve([0, 1e-3, 4e-3, 0.02], [0, 90, 80, 6e3])])
def test_the_force_accelerates_the_mass(curve):
    """m δ'' = −F, by finite differences of the indentation itself and the area under F."""
    found = force_history(dropped(0.6), curve)
    assert np.trapezoid(found.force, found.t) == pytest.approx(found.impulse, rel=1e-4)
    for share in (0.11, 0.43, 0.78, 0.97):
        t, h = share * found.duration, 1e-4 * found.duration
        before, here, after = (found.at(x) for x in (t - h, t, t + h))
        assert (after.indentation - before.indentation) / (2 * h) == pytest.approx(
            here.rate, abs=1e-5
        )
        assert -MASS * (after.rate - before.rate) / (2 * h) == pytest.approx(here.force, rel=1e-5)
        assert here.impulse == pytest.approx(MASS * (2.0 - here.rate), rel=1e-12)
    assert found.at(found.duration).rate == pytest.approx(-1.2, rel=1e-12)


@pytest.mark.parametrize(("e", "n"), [(0.999999, 1.5), (0.8, 1.5), (0.2, 1.0), (0.1, 3.0)])
def test_hunt_crossley_keeps_e_in_fifty_digits(e, n):
    """d + e d = ln((1 + d)/(1 − e d)), d = λ c, and the deepest point from the energy."""
    found = force_history(dropped(e), HuntCrossley(2e6, n))
    with mp.workdps(50):
        d, real = mp.mpf(found.damping) * 2, mp.mpf(e)
        off = (mp.log1p(d) - mp.log1p(-real * d)) / d - 1 - real
        assert abs(off / (1 / (1 - real * d) - 1)) < 1e-12
        depth = ((n + 1) * MASS * 4 / d**2 * (d - mp.log1p(d)) / 2e6) ** (1 / mp.mpf(n + 1))
        assert abs(found.indentation / depth - 1) < 1e-12
    # Followed in time it comes back with e.
    k, x = 2e6, found.damping

    def left(t, y):
        return y[0] + (1.0 if t < 0.5 * found.duration else 0.0)

    left.terminal = True
    way = solve_ivp(
        lambda t, y: [y[1], -k * max(y[0], 0.0) ** n * (1 + x * y[1]) / MASS],
        [0, 2 * found.duration], [0, 2.0], method="DOP853", rtol=1e-12, atol=1e-15, events=left,
    )  # fmt: skip
    assert -way.y_events[0][0][1] / 2.0 == pytest.approx(e, abs=3e-11)
    assert way.t_events[0][0] == pytest.approx(found.duration, rel=1e-10)


def test_a_measured_curve_of_a_line_is_a_spring():
    found = force_history(dropped(0.5), MeasuredCurve([0, 0.5, 1.0], [0, 5e3, 1e4]))
    rate = math.sqrt(1e4 / MASS)
    assert found.compression == pytest.approx(0.5 * math.pi / rate, rel=1e-12)
    assert found.duration == pytest.approx(0.5 * math.pi / rate * 1.5, rel=1e-12)
    assert found.peak_force == pytest.approx(2.0 * math.sqrt(1e4 * MASS), rel=1e-12)


def test_friction_along_the_path_keeps_work_and_impulse():
    """Slip that stops within the impact changes the effective mass between the two phases."""
    law = ik.Law(restitution="stronge", slip="path")
    rod = ik.Robot.from_urdf("models/rod.urdf", root="freeflyer")
    q = rod.configuration(root_joint=[0, 0, 0, 0, math.sin(0.3), 0, math.cos(0.3)])
    tip = ik.Contact("rod", at=[0.5, 0, 0], restitution=0.6, friction=0.4)
    scene = ik.Scene(rod, contacts=[tip], law=law, gap_bound=np.inf)
    impact = ik.solve(scene, q, rod.velocity(root_joint=[-0.3, 0, -1, 0, 0.2, 0]))
    found = force_history(impact, RUBBER)
    assert found.restitution == pytest.approx(0.6, abs=1e-9)
    assert found.impulse == pytest.approx(impact.contacts[0].impulse[2], rel=1e-12)


def test_peak_joint_loads_are_those_of_a_compliant_motion():
    """Two links that strike a stiff spring with their tip, every term of their motion kept."""
    arm = ik.Robot.from_urdf(pendulum_urdf(2))
    q, v = arm.configuration(joint_1=0.4, joint_2=0.5), arm.velocity(joint_1=-1.0, joint_2=-0.7)
    k = 1e9
    place = ik.solve(ik.Scene(arm), q, v).velocity_at("link_2", [0, 0, -1])
    assert place.before[0] > 0.5
    tip = ik.Contact("link_2", at=[0, 0, -1], normal=[-1, 0, 0], restitution=1.0)
    scene = ik.Scene(arm, contacts=[tip], gap_bound=9.0)
    found = force_history(ik.solve(scene, q, v), HuntCrossley(k))
    model = arm.model
    data = model.createData()
    frame = model.getFrameId("link_2")
    at = np.array([0, 0, -1.0])

    def tip_of(q):
        pin.forwardKinematics(model, data, q)
        pin.updateFramePlacements(model, data)
        return data.oMf[frame].act(at)

    start = tip_of(q)[0]

    def force(q):
        return -k * max(tip_of(q)[0] - start, 0.0) ** 1.5

    def torque(q):
        J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
        arm_of = tip_of(q) - data.oMf[frame].translation
        return (J[:3] - pin.skew(arm_of) @ J[3:])[0] * force(q)

    way = solve_ivp(
        lambda t, y: [*y[2:], *pin.aba(model, data, y[:2], y[2:], torque(y[:2]))],
        [0, found.duration], [*q, *v], method="DOP853", rtol=1e-9, atol=1e-12,
        t_eval=np.linspace(0, found.duration, 201),
    )  # fmt: skip
    forces = np.array([force(y[:2]) for y in way.y.T])
    top = int(np.argmin(forces))
    assert -forces[top] == pytest.approx(found.peak_force, rel=1e-3)
    # The root carries what moves the centres of mass, less the force at the tip.
    y = way.y[:, top]
    a = pin.aba(model, data, y[:2], y[2:], torque(y[:2]))
    pin.centerOfMass(model, data, y[:2], y[2:], a)
    carried = data.mass[0] * data.acom[0][0] - forces[top]
    assert found.peak_reactions["joint_1"][0] == pytest.approx(carried, rel=1e-2)
