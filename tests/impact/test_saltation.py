"""Saltation matrices against closed forms and against motions nearby."""

import math
import pathlib
import runpy

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact.saltation import saltation_matrix

from ..robots import one_body

GRAVITY = 9.81


def test_a_ball_on_a_moving_table_against_its_closed_form():
    # The table stands at z = A sin ωt; w⁺ = −e w + (1 + e) ż. From height to height the
    # bounce is a map whose derivative is known in closed form (Holmes 1982, with e).
    e, amplitude, rate, t = 0.7, 0.02, 9.0, 0.13
    table = amplitude * rate * math.cos(rate * t)
    table_rate = -amplitude * rate**2 * math.sin(rate * t)
    w = -1.8
    after = -e * w + (1.0 + e) * table
    found = saltation_matrix(
        [[1, 0], [0, -e]],
        [w, -GRAVITY],
        [after, -GRAVITY],
        [1, 0],
        guard_rate=-table,
        reset_rate=[0, (1.0 + e) * table_rate],
    )
    # δt = −δz/(w − ż): z⁺ and w⁺ follow by hand.
    speed = w - table
    assert found[0] == pytest.approx([-e, 0.0])
    by_height = (-GRAVITY - e * GRAVITY - (1.0 + e) * table_rate) / speed
    assert found[1] == pytest.approx([by_height, -e])

    def bounced(height, velocity):
        """The state at time t of a ball that meets the table near it, by root finding."""
        early = t - 0.02
        z0 = amplitude * math.sin(rate * t) - w * 0.02 - 0.5 * GRAVITY * 0.02**2 + height
        w0 = w + GRAVITY * 0.02 + velocity

        def gap(s):
            d = s - early
            return z0 + w0 * d - 0.5 * GRAVITY * d * d - amplitude * math.sin(rate * s)

        from scipy.optimize import brentq

        s = brentq(gap, t - 0.01, t + 0.01, xtol=1e-15)
        d = s - early
        hit = -e * (w0 - GRAVITY * d) + (1.0 + e) * amplitude * rate * math.cos(rate * s)
        back = t - s
        z = amplitude * math.sin(rate * s) + hit * back - 0.5 * GRAVITY * back * back
        return np.array([z, hit - GRAVITY * back])

    flow = np.array([[1.0, 0.02], [0.0, 1.0]])
    base = bounced(0.0, 0.0)
    gaps = []
    for h in (1e-3, 5e-4):
        move = h * np.array([0.6, 3.0])
        gaps.append(np.linalg.norm(bounced(*move) - base - found @ flow @ move))
    # Half the deviation, a quarter of the error.
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.05)


def rolling_ball(friction=0.4, law="newton"):
    ball = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    corner = ik.Contact("box", at=[0.15, 0.1, -0.05], restitution=0.6, friction=friction)
    return ik.Scene(ball, contacts=[corner], law=ik.Law(restitution=law))


def _start():
    q = np.array([0.0, 0.0, 0.35, *(np.array([0.1, 0.2, -0.1, 0.95]) / np.sqrt(0.9625))])
    q[3:] /= np.linalg.norm(q[3:])
    return q, np.array([0.5, -0.3, -1.0, 0.4, -0.2, 0.7])


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("friction", [0.1, 2.0])
def test_motions_nearby_follow_the_sensitivity_to_second_order(friction, law):
    scene = rolling_ball(friction, law)
    q, v = _start()
    motion = ik.simulate(scene, q, v, duration=0.15, samples=2, rtol=1e-12, atol=1e-13)
    assert len(motion.impacts) == 1
    found = ik.sensitivity(motion)
    assert found.exists
    model = scene.robot.model
    rng = np.random.default_rng(0)
    errors = []
    direction = rng.normal(size=12)
    for h in (2e-4, 1e-4):
        near = ik.simulate(
            scene,
            pin.integrate(model, q, h * direction[:6]),
            v + h * direction[6:],
            duration=0.15,
            samples=2,
            rtol=1e-12,
            atol=1e-13,
        )
        change = np.concatenate(
            [pin.difference(model, motion.q[-1], near.q[-1]), near.v[-1] - motion.v[-1]]
        )
        errors.append(np.linalg.norm(change - h * found.matrix @ direction))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] < 1e-4


def test_a_blow_at_a_fixed_time_has_no_shift_in_time():
    rod = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    scene = ik.Scene(rod, [ik.AppliedImpulse("link_2", linear=[1, 0, 0])])
    impact = ik.solve(scene, [0.3, -0.4], [0.5, 1.0])
    found = ik.saltation(impact, acceleration_before=[0, 0], acceleration_after=[0, 0])
    assert np.array_equal(found.matrix, found.reset)
    assert not found.guard.any() and found.speed == 0.0


# -- contacts that rest, and several at once ----------------------------------------------------


def differences(scene, q, v, duration, h=1e-4):
    """Φ by Richardson's extrapolation of motions nearby."""
    model, nv = scene.robot.model, len(v)

    def end(move):
        near = ik.simulate(
            scene,
            pin.integrate(model, q, move[:nv]),
            v + move[nv:],
            duration=duration,
            samples=2,
            rtol=1e-12,
            atol=1e-13,
        )
        return np.concatenate([pin.difference(model, base.q[-1], near.q[-1]), near.v[-1]])

    base = ik.simulate(scene, q, v, duration=duration, samples=2, rtol=1e-12, atol=1e-13)
    columns = []
    for unit in np.eye(2 * nv):
        coarse, fine = ((end(s * unit) - end(-s * unit)) / (2 * s) for s in (2 * h, h))
        columns.append((4 * fine - coarse) / 3)
    return base, np.array(columns).T


def test_balls_that_land_together_have_each_its_own_bounce():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    both = ik.combine(a=ball, b=ball)
    floor = [ik.Contact(f"{name}/ball", restitution=0.6) for name in "ab"]
    scene = ik.Scene(both, contacts=floor)
    q = both.configuration(
        {"a/root_joint": [0, 0, 0.2, 0, 0, 0, 1], "b/root_joint": [1, 0, 0.2, 0, 0, 0, 1]}
    )
    motion, truth = differences(scene, q, both.velocity(), 0.3)
    assert len(motion.impacts) == 1
    found = ik.sensitivity(motion)
    assert found.exists and len(found.saltations) == 2
    assert np.abs(found.matrix - truth).max() < 1e-6 * np.abs(truth).max()


def test_two_corners_that_land_together_have_no_derivative():
    # Which corner of a box is first decides how it turns.
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    corners = [ik.Contact("box", at=[x, 0, -0.05], restitution=0.5) for x in (-0.15, 0.15)]
    scene = ik.Scene(box, contacts=corners)
    drop = box.configuration(root_joint=[0, 0, 0.2, 0, 0, 0, 1])
    motion = ik.simulate(scene, drop, box.velocity(), duration=0.25, samples=2)
    assert len(motion.impacts) == 1
    with pytest.raises(ik.errors.InputError, match="it matters which is first"):
        ik.sensitivity(motion)


def test_a_ball_that_lies_still_keeps_its_deviations_along_the_floor():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    floor = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.0)])
    lying = ik.simulate(floor, ball.neutral(), ball.velocity(), duration=0.1, samples=2)
    assert lying.rests
    found = ik.sensitivity(lying).matrix
    wanted = np.eye(12)
    wanted[:6, 6:] = 0.1 * np.eye(6)
    assert found == pytest.approx(wanted, abs=1e-6)


# -- periodic motions ---------------------------------------------------------------------------

ALPHA, RADIUS = math.pi / 8, 1.0


INERTIA = 0.01


def heel_strike(omega):
    """The impact at which the next leg takes over; it turns about the last foot by omega."""
    wheel = one_body("hub", 1, INERTIA, root="planar")
    # In the plane y is up; the hub stands ALPHA past the foot that leaves.
    hub = RADIUS * np.array([math.sin(ALPHA), math.cos(ALPHA)])
    next_foot = RADIUS * np.array([math.sin(ALPHA), -math.cos(ALPHA)])
    scene = ik.Scene(wheel, constraints=[ik.PointAnchor("hub", at=[*next_foot, 0])])
    along = np.array([hub[1], -hub[0], -1.0])
    return ik.solve(scene, wheel.neutral(), omega * along), along


def test_the_rimless_wheel_loses_speed_as_known():
    # About the new foot angular momentum is kept: (1 + λ) ω⁺ = (cos 2α + λ) ω, λ = I/m l².
    share = (math.cos(2 * ALPHA) + INERTIA) / (1.0 + INERTIA)
    impact, along = heel_strike(1.3)
    assert -impact.v_after[2] == pytest.approx(1.3 * share, rel=1e-12)
    found = ik.derivatives(impact)
    assert -(found.dv_after_dv @ along)[2] == pytest.approx(share, rel=1e-12)


def test_a_bouncing_ball_keeps_its_period_under_a_perfect_floor():
    # With e = 1 the bounce is conservative: Φ over a period has determinant 1.
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=1.0)], gravity=(0, 0, -GRAVITY))
    height = 0.5
    period = 2.0 * math.sqrt(2.0 * height / GRAVITY)
    drop = ball.configuration(root_joint=[0, 0, height, 0, 0, 0, 1])
    motion = ik.simulate(scene, drop, ball.velocity(), duration=period, samples=2)
    found = ik.sensitivity(motion)
    own = found.matrix[np.ix_([2, 8], [2, 8])]
    assert np.linalg.det(own) == pytest.approx(1.0, abs=1e-6)
    # T = 2 √(2h/g): from the top, z stays and the phase shifts with dT/dh.
    shift = 2.0 / math.sqrt(2.0 * height * GRAVITY)
    assert own == pytest.approx(np.array([[1.0, 0.0], [GRAVITY * shift, 1.0]]), abs=1e-6)


def example(name):
    return runpy.run_path(str(pathlib.Path(__file__).parents[2] / "examples" / f"{name}.py"))


def test_the_simplest_walker_walks_stably_with_the_multipliers_of_its_return_map():
    # Stable below a slope of 0.015 rad (Garcia et al. 1998).
    walker = example("compass_gait")
    found = walker["gait"](0.009)
    assert found.start[:2] == pytest.approx([0.200310900544, -0.199832473005], abs=1e-10)

    def back(short):
        theta, rate = short
        full = np.array([theta, rate, 2 * theta, (1 - math.cos(2 * theta)) * rate])
        return walker["strike"](walker["step"](full, 0.009)[0])[0][:2]

    def differences(h):
        start = found.start[:2]
        return np.array([(back(start + h * e) - back(start - h * e)) / (2 * h) for e in np.eye(2)])

    pair = np.linalg.eigvals((4 * differences(5e-5) - differences(1e-4)) / 3)
    wanted = [0.0, *np.sort(np.abs(pair)), 1.0]
    assert np.sort(np.abs(found.multipliers)) == pytest.approx(wanted, abs=1e-6)
    assert np.abs(pair).max() < 0.6


def test_period_one_bounces_on_a_moving_table_against_the_closed_form():
    # λ² − ((1 + e)² (1 + z̈/g) − 2e) λ + e² = 0, with the table's acceleration z̈ at the hit:
    # w⁻ = −gT/2 and ż = gT (1 − e)/(2 (1 + e)) make the bounce repeat after T.
    e, period, table_rate = 0.8, 0.2, -3.0
    w, table = -0.5 * GRAVITY * period, 0.5 * GRAVITY * period * (1.0 - e) / (1.0 + e)
    after = -e * w + (1.0 + e) * table
    assert after == pytest.approx(-w)
    hit = saltation_matrix(
        [[1, 0], [0, -e]],
        [w, -GRAVITY],
        [after, -GRAVITY],
        [1, 0],
        guard_rate=-table,
        reset_rate=[0, (1.0 + e) * table_rate],
    )
    monodromy = np.array([[1.0, period], [0.0, 1.0]]) @ hit
    assert np.linalg.det(monodromy) == pytest.approx(e**2, rel=1e-13)
    trace = (1.0 + e) ** 2 * (1.0 + table_rate / GRAVITY) - 2.0 * e
    assert np.trace(monodromy) == pytest.approx(trace, rel=1e-13)
