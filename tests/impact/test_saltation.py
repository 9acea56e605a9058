"""Saltation matrices against closed forms and against motions nearby."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact.saltation import saltation_matrix
from tests.conformance.differences import by_differences

GRAVITY = 9.81


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
def test_motions_nearby_follow_the_sensitivity(friction, law):
    motion, truth = differences(rolling_ball(friction, law), *_start(), 0.15)
    assert len(motion.impacts) == 1
    found = ik.sensitivity(motion)
    assert found.exists
    assert np.abs(found.matrix - truth).max() < 1e-6 * np.abs(truth).max()


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


def test_the_end_of_a_motion_by_its_coefficients():
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    q = box.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1])
    v = box.velocity(root_joint=[1, 0.2, 0, 0.3, -0.2, 0.4])

    def motion(e=0.0, mu=0.0):
        corner = ik.Contact("box", [0.1, 0.05, -0.05], restitution=0.6 + e, friction=0.2 + mu)
        return ik.simulate(ik.Scene(box, contacts=[corner]), q, v, duration=0.6)

    there = motion()
    assert len(there.impacts) == 2

    def moved(other):
        return np.r_[pin.difference(box.model, there.q[-1], other.q[-1]), other.v[-1]]

    found, w = ik.sensitivity(there), np.arange(12.0)
    pulled = found.vjp(w)
    for kind, own in (("restitution", found.by_restitution), ("friction", found.by_friction)):
        name = "e" if kind == "restitution" else "mu"
        truth = by_differences(lambda h, name=name: moved(motion(**{name: h})))
        ours = own["contacts[0]"]
        assert np.abs(ours - truth).max() < 1e-7 * np.abs(truth).max()
        assert pulled[kind]["contacts[0]"] == pytest.approx(w @ ours)
    np.testing.assert_allclose(pulled["q"], (w @ found.matrix)[:6])


def test_the_end_of_a_simulation_by_its_controls():
    """Torques that change on the way, and a stop that is hit in between."""
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    first, second = arm.joint_names
    scene = ik.Scene(arm, contacts=[ik.JointStop(second, upper=0.25, restitution=0.5)])

    def run(change=(0.0, 0.0), q=(0.2, 0.1)):
        sim = ik.Simulation(scene, q, [0.0, 2.0])
        sim.controls[first], sim.controls[second] = 1.0 + change[0], change[1]
        sim.step(0.15)
        sim.controls[first] = -2.0 + change[0]
        return sim.step(0.25)

    def ends(sim):
        return np.r_[sim.q, sim.v]

    sim = run()
    assert sim.impacts
    found = ik.sensitivity(sim, controls=True)
    for i, way in enumerate(np.eye(2)):
        by_torque = by_differences(lambda h, way=way: ends(run(h * way)))
        by_place = by_differences(lambda h, way=way: ends(run(q=[0.2, 0.1] + h * way)))
        np.testing.assert_allclose(found.by_controls[:, i], by_torque, atol=1e-6)
        np.testing.assert_allclose(found.matrix[:, i], by_place, atol=1e-6)
    np.testing.assert_allclose(found.vjp(np.ones(4))["controls"], found.by_controls.sum(axis=0))
