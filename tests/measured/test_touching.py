"""Ropes that jerk taut, gaps that are functions of q and stops, found in recordings with noise."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import brentq

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.measured import Recording, find_impacts, fit_impacts
from tests.measured.bodies import G
from tests.measured.test_recovery import point_scene

E, LENGTH, HEIGHT, WAVE, NOISE, STEP = 0.4, 0.8, 0.05, 5.0, 3e-4, 0.004


def cam(q):
    return q[2] - HEIGHT * np.cos(WAVE * q[0])


# By kind: the contact, its gap at a place and the gap's gradient there, where throws begin.
KINDS = {
    "rope": (
        ik.Rope("point", length=LENGTH, restitution=0.2, name="hit"),
        lambda p: LENGTH - np.linalg.norm(p),
        lambda p: -p / np.linalg.norm(p),
        ([0.1, 0.0, 0.1], [2.0, 0.5, 0.5]),
    ),
    "cam": (
        ik.GapContact(cam, restitution=0.2, name="hit"),
        cam,
        lambda p: np.array([HEIGHT * WAVE * np.sin(WAVE * p[0]), 0.0, 1.0]),
        ([0.1, 0.0, 0.4], [0.5, 0.2, 0.0]),
    ),
}


def thrown(kind, robot, rng):
    """A point that flies, hits once and flies on: v⁺ = v⁻ − (1 + e) n (n·v⁻)/n². With noise."""
    _, gap, normal, (place, v) = KINDS[kind]
    place, v = place + 0.05 * rng.normal(size=3), v + 0.2 * rng.normal(size=3)
    fall = np.array([0.0, 0.0, -G])

    def at(time, place, v):
        return place + v * time + 0.5 * fall * time**2

    later = next(s for s in np.arange(1, 2000) * 1e-3 if gap(at(s, place, v)) < 0.0)
    hit = brentq(lambda s: gap(at(s, place, v)), later - 1e-3, later)
    there, fast = at(hit, place, v), v + fall * hit
    n = normal(there)
    left = fast - (1 + E) * n * (n @ fast) / (n @ n)
    t, turn = np.arange(0.0, hit + 0.15, STEP), np.array([1.0, -2.0, 0.5])
    q = np.array(
        [
            [
                *(at(s, place, v) if s < hit else at(s - hit, there, left)),
                *pin.Quaternion(pin.exp3(turn * s)).coeffs(),
            ]
            for s in t
        ]
    )
    q[:, :3] += NOISE * rng.normal(size=(len(t), 3))
    return Recording(robot, t, q, name=f"{hit}")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_restitution_comes_back_where_noise_leaves_a_gap(kind):
    robot, rng = point_scene().robot, np.random.default_rng(6)
    scene = ik.Scene(robot, contacts=[KINDS[kind][0]], gravity=[0, 0, -G])
    found = find_impacts([thrown(kind, robot, rng) for _ in range(4)], scene)
    assert [each.contacts for each in found.impacts] == [("hit",)] * 4
    # Some of them are found before they touch.
    assert max(each.gaps[0] for each in found.impacts) > 5e-5
    fit = fit_impacts(found.balanced().measurements(scene), restitution=["hit"])
    assert fit.notes == ()
    sigma = np.sqrt(fit.covariance[0, 0])
    assert sigma < 0.003 and abs(fit.values[0] - E) < 3 * sigma


# A rod that swings down towards negative angles.
ROD = robot_text(
    "rod", link_text("base"), link_text("rod", 1, 0.03, at="-0.3 0 0"),
    joint_text("hinge", "revolute", "base", "rod", "0 1 0", far=3),
)  # fmt: skip


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
