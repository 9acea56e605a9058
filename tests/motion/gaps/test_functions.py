"""Constraints and contacts by functions of q, against closed forms and integrations by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text

G = 9.81


def bead(second="0 0 1"):
    """A mass of 2 kg with the coordinates x and z (or y)."""
    links = (link_text("base"), link_text("a"), link_text("bead", 2, 0.1))
    joints = (joint_text("x", "prismatic", "base", "a", "1 0 0", far=90),
              joint_text("z", "prismatic", "a", "bead", second, far=90))  # fmt: skip
    return ik.Robot.from_urdf(robot_text("bead", *links, *joints))


WIRE = {
    "gradient": ik.GapConstraint(
        lambda q: q[1] - q[0] ** 2, gradient=lambda q: [[-2 * q[0], 1]], name="wire"
    ),
    "differences": ik.GapConstraint(lambda q: q[1] - q[0] ** 2, name="wire"),
    "bias": ik.GapConstraint(
        lambda q: [q[1] - q[0] ** 2],
        gradient=lambda q: [-2 * q[0], 1],
        bias=lambda q, v: -2 * v[0] ** 2,
        name="wire",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("way", WIRE)
def test_bead_on_a_parabola(way):
    """(1 + 4x²) ẍ = −4 x ẋ² − 2 g x, and the force of the wire m (z̈ + g) along z."""
    motion = ik.simulate(
        ik.Scene(bead(), constraints=[WIRE[way]]), [0.5, 0.25], [0.3, 0.3], duration=1.5
    )

    def slope(t, y):
        x, u = y
        return [u, -(4 * x * u * u + 2 * G * x) / (1 + 4 * x * x)]

    found = solve_ivp(slope, (0, 1.5), [0.5, 0.3], "DOP853", rtol=1e-12, atol=1e-13)
    x, u = found.y[:, -1]
    np.testing.assert_allclose(motion.q[-1], [x, x * x], atol=1e-8)
    np.testing.assert_allclose(motion.v[-1], [u, 2 * x * u], atol=1e-8)
    force = motion.constraints["wire"].force(1.5)
    rate = slope(0, (x, u))[1]
    np.testing.assert_allclose(force, 2.0 * (2 * u * u + 2 * x * rate + G), rtol=1e-7)


def cam_robot():
    links = (link_text("base"), link_text("disc", 1, 0.1), link_text("rod", 1, 0.1))
    joints = (joint_text("cam", "revolute", "base", "disc", "0 1 0", far=90),
              joint_text("lift", "prismatic", "base", "rod", "0 0 1", far=90))  # fmt: skip
    return ik.Robot.from_urdf(robot_text("cam", *links, *joints))


R, A, W, E = 0.2, 0.05, 21.0, 0.4


def height(angle):
    return R + A * math.cos(angle) + 0.2 * A * math.cos(2 * angle)


def test_cam_and_follower_that_jumps():
    """The cam turns evenly; the follower falls on it again and again with e = 0.4."""
    cam = ik.GapContact(
        lambda q: q[1] - height(q[0]),
        normal=lambda q: [A * math.sin(q[0]) + 0.4 * A * math.sin(2 * q[0]), 1.0],
        restitution=E,
        name="cam",
    )
    drive = ik.Driven("cam", lambda t: W * t, lambda t: W, lambda t: 0.0)
    scene = ik.Scene(cam_robot(), constraints=[drive], contacts=[cam])
    motion = ik.simulate(scene, [0.0, 0.4], [W, 0.0], duration=1.0)
    z, v, t, right = 0.4, 0.0, 0.0, []
    for _ in range(3):

        def gap(s, z=z, v=v, t=t):
            return z + v * (s - t) - 0.5 * G * (s - t) ** 2 - height(W * s)

        s = t + 1e-4
        while gap(s) > 0.0:
            s += 1e-4
        s = brentq(gap, s - 1e-4, s, xtol=1e-15)
        lift = -W * (A * math.sin(W * s) + 0.4 * A * math.sin(2 * W * s))
        v, z, t = lift - E * (v - G * (s - t) - lift), height(W * s), s
        right.append(s)
    np.testing.assert_allclose([t for t, _ in motion.impacts], right, atol=1e-8)


def test_friction_by_tangents():
    """A block on a slope by functions of q: g (sin − µ cos) along it."""
    slope, mu = 0.5, 0.3
    c, s = math.cos(slope), math.sin(slope)
    plane = ik.GapContact(
        lambda q: q[1] * c - q[0] * s,
        normal=lambda q: [-s, c],
        tangents=lambda q: [c, s],
        friction=mu,
        name="slope",
    )
    motion = ik.simulate(ik.Scene(bead(), contacts=[plane]), [0.0, 0.0], [0.0, 0.0], duration=1.0)
    way = -0.5 * G * (s - mu * c)
    np.testing.assert_allclose(motion.q[-1], [way * c, way * s], atol=1e-8)
    force = motion.contacts["slope"].force(0.5)
    np.testing.assert_allclose(force, [2 * mu * G * c, 0.0, 2 * G * c], rtol=1e-9)
    hit = ik.solve(ik.Scene(bead(), contacts=[plane]), [0.0, 0.0], [0.0, -1.0])
    along = -s + mu * c
    np.testing.assert_allclose(hit.v_after, [along * c, along * s], atol=1e-14)
    assert hit.contacts["slope"].mode == "sliding"
