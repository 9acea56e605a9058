"""Rows of contacts and constraints where an impact was measured."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy import stats

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.measured.active_contacts import ClosingContacts
from tests.measured.bodies import ball_scene

# A rod that swings down towards negative angles.
ROD = robot_text(
    "rod", link_text("base"), link_text("rod", 1, 0.03, at="-0.3 0 0"),
    joint_text("hinge", "revolute", "base", "rod", "0 1 0", far=3),
)  # fmt: skip


def test_rows_of_a_rod_are_the_rate_of_its_length():
    scene = ball_scene()
    rod = ik.DistanceAnchor("ball", at=[0.01, 0.02, 0.03], other_at=[0.2, -0.1, 0.6], name="rod")
    closing = ClosingContacts(replace(scene, constraints=[rod]))
    model, rng = scene.robot.model, np.random.default_rng(0)
    for _ in range(200):  # memory that is not there shows itself after a while
        q = pin.integrate(model, scene.robot.neutral(), rng.normal(size=6))
        rows = closing.mass_and_rows(q)[1]
    v = rng.normal(size=6)

    def length(share):
        place = pin.XYZQUATToSE3(pin.integrate(model, q, share * v))
        return np.linalg.norm(place.act(np.array(rod.at)) - rod.other_at)

    assert rows.shape == (4, 6)
    assert rows[-1] @ v == pytest.approx((length(1e-6) - length(-1e-6)) / 2e-6, abs=1e-8)


def noisy_motion(scene, q, v, duration, count, sigma, rng, name):
    motion = ik.simulate(scene, q, v, duration=duration, samples=count)
    model = scene.robot.model
    seen = [pin.integrate(model, row, sigma * rng.normal(size=model.nv)) for row in motion.q]
    return ik.measured.Recording(scene.robot, motion.t, np.array(seen), name=name)


@pytest.mark.slow
def test_joints_that_noise_keeps_from_their_limits_have_hit_them():
    rod = ik.Robot.from_urdf(ROD)
    stop = ik.JointStop("hinge", lower=-0.4, upper=2.0, restitution=0.6, name="stop")
    scene, rng = ik.Scene(rod, contacts=[stop], gravity=[0, 0, -9.81]), np.random.default_rng(1)
    seen = [
        noisy_motion(scene, [1.0 + 0.05 * k], [0.0], 0.7, 71, 2e-4, rng, str(k)) for k in range(5)
    ]
    found = ik.measured.find_impacts(seen, scene)
    assert any(each.gaps[0] > 0.0 for each in found.impacts if each.contacts)
    start = replace(scene, contacts=[replace(stop, restitution=0.3)])
    fit = ik.measured.fit_impacts(found.measurements(start), restitution=["stop"])
    assert fit["stop: restitution"] == pytest.approx(0.6, abs=0.01)


def test_balance_of_a_corner_that_hits_a_floor_is_as_likely_as_it_says():
    # The corner stays where it is in the body: noise of the turn must not widen the balance.
    # In the body's axes Δv = R' J / m and Δω = I⁻¹ (r × R' J), J in the world.
    cube = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    corner = np.array([0.05, -0.05, -0.05])
    floor = ik.Contact("ball", at=corner, restitution=0.3, friction=0.2, name="corner")
    closing, rng = ClosingContacts(ik.Scene(cube, contacts=[floor])), np.random.default_rng(5)
    body, found = cube.model.inertias[1], []
    noise = np.array([3e-4] * 3 + [5e-3] * 3 + [5e-3] * 3 + [5e-3] * 3)
    for _ in range(100):
        q = pin.integrate(cube.model, cube.neutral(), 0.4 * rng.normal(size=6))
        turn = pin.XYZQUATToSE3(q).rotation
        q[2] = -(turn @ corner)[2]
        local = turn.T @ np.array([0.2, 0.1, 1.0])
        jump = np.concatenate(
            [local / body.mass, np.linalg.solve(body.inertia, np.cross(corner, local))]
        )
        off = noise * rng.normal(size=12)
        seen = pin.integrate(cube.model, q, off[:6])
        found.append(closing.of_jump(seen, jump + off[6:], np.diag(noise**2), np.zeros(6), 0.01)[3])
    assert stats.kstest(found, "uniform").pvalue > 0.01
