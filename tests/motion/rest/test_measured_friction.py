"""Motions with static and kinetic friction, and friction by slip speed, against integrations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik

from ...robots import one_body

BLOCK = one_body("block", 2, 1)
G = 9.81


def slid(friction, v, duration, gravity=(0, 0, -G), **more):
    floor = ik.Contact("block", friction=friction, name="floor")
    scene = ik.Scene(BLOCK, contacts=[floor], gravity=gravity, **more)
    return ik.simulate(scene, BLOCK.neutral(), BLOCK.velocity(root_joint=v), duration=duration)


def stribeck(speed):
    return 0.2 + 0.3 * np.exp(-speed / 0.3) + 0.05 * speed


def test_friction_by_speed_against_an_own_integration():
    motion = slid(stribeck, [1.2, 1.6, 0, 0, 0, 0], 0.4)

    def rates(t, y):
        return [y[1], -stribeck(y[1]) * G]

    truth = solve_ivp(rates, (0, 0.4), [0, 2.0], method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    q, v = motion.at(0.4)
    assert q[:2] == pytest.approx(truth[0] * np.array([0.6, 0.8]), abs=1e-8)
    assert v[:2] == pytest.approx(truth[1] * np.array([0.6, 0.8]), abs=1e-8)
    force = motion.contacts["floor"].force(0.4)
    assert np.linalg.norm(force[:2]) == pytest.approx(stribeck(truth[1]) * 2 * G, rel=1e-8)


def test_it_stops_and_sticks_with_its_static_friction():
    """Thrown up a slope it stops by its kinetic µ, and stays by its static one."""
    gravity = (-G * np.sin(0.3), 0, -G * np.cos(0.3))
    rate = G * (np.sin(0.3) + 0.2 * np.cos(0.3))
    for static, stays in ((0.35, True), (0.25, False)):
        motion = slid((static, 0.2), [1.0, 0, 0, 0, 0, 0], 1.0, gravity)
        back = 0.0 if stays else -G * (np.sin(0.3) - 0.2 * np.cos(0.3)) * (1.0 - 1.0 / rate)
        assert motion.status.name == "FINISHED"
        assert motion.v[-1][0] == pytest.approx(back, abs=1e-8)
        assert np.abs(motion._path.step_times - 1.0 / rate).min() < 1e-8


@pytest.mark.slow
def test_a_pull_that_grows_tears_it_off_at_the_static_friction():
    """F = 10 t: it holds until µ_s m g, then m v̇ = 10 t − µ_k m g."""
    pull = ik.AppliedForce("block", linear=lambda t: [10 * t, 0, 0])
    motion = slid((0.3, 0.2), np.zeros(6), 1.2, forces=[pull])
    start = 0.3 * 2 * G / 10
    v = (5 * (1.2**2 - start**2) - 0.2 * 2 * G * (1.2 - start)) / 2
    assert motion.v[-1][0] == pytest.approx(v, abs=1e-7)


@pytest.mark.parametrize("friction", [lambda u: 0.5 * u, ik.FrictionTable([0, 9], [0, 4.5])])
def test_friction_that_is_none_without_slip(friction):
    """µ = u/2: v = exp(−g t/2) thrown, and pushed from rest (F/m)/(g/2) (1 − exp(−g t/2))."""
    thrown = slid(friction, [1.0, 0, 0, 0, 0, 0], 0.3)
    assert thrown.v[-1][0] == pytest.approx(np.exp(-0.5 * G * 0.3), abs=1e-9)
    push = ik.AppliedForce("block", linear=[3.0, 0, 0])
    pushed = slid(friction, np.zeros(6), 0.3, forces=[push])
    assert pushed.v[-1][0] == pytest.approx(3.0 / G * (1 - np.exp(-0.5 * G * 0.3)), abs=1e-7)


@pytest.mark.slow
def test_a_box_on_four_points_holds_until_all_of_them_together_cannot():
    """A pull through its centre loads the front points more: none of them slips by itself."""
    box = one_body("box", 1, 0.0067)
    feet = [
        ik.Contact("box", at=[x, y, -0.1], friction=(0.5, 0.3))
        for x in (-0.1, 0.1)
        for y in (-0.1, 0.1)
    ]
    pull = ik.AppliedForce("box", linear=lambda t: (6.0 * np.sin(8.0 * t), 0, 0))
    g = np.array([0.9, 0.0, -9.7])
    scene = ik.Scene(box, contacts=feet, forces=[pull], gravity=g)
    q = box.configuration(root_joint=[0, 0, 0.1, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, box.velocity(), 0.1)
    begin = np.arcsin((0.5 * 9.7 - 0.9) / 6.0) / 8.0
    speed = (0.9 - 0.3 * 9.7) * (0.1 - begin) + 0.75 * (np.cos(8.0 * begin) - np.cos(0.8))
    assert motion.v[-1][0] == pytest.approx(speed, abs=1e-8)
    assert np.abs(motion.v[-1][1:]).max() < 1e-9
