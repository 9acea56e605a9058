"""Periodic motions across impacts: walkers, against equations by hand and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, one_body, robot_text

G = 9.81


# Compass gait (Goswami, Thuillot & Espiau 1998): legs of 1 m with 5 kg in their middles, 10 kg at
# the hip, a slope of 3°.
LEG, HALF, MASS, HIP, SLOPE = 1.0, 0.5, 5.0, 10.0, np.radians(3.0)


def compass():
    """The walker on a level floor, with gravity that leans forward by the slope."""
    legs = (link_text(name, MASS, 0, at=(0, 0, -HALF)) for name in "ab")
    top = joint_text("top", "fixed", "a", "hip")
    hip = joint_text("hip_joint", "revolute", "a", "b", "0 1 0", far=3)
    urdf = robot_text("compass", *legs, link_text("hip", HIP, 0), top, hip)
    robot = ik.Robot.from_urdf(urdf, root="sagittal")
    feet = [
        # A foot counts where it is in front of the other: else it scuffs.
        ik.Contact(
            name,
            at=[0, 0, -LEG],
            friction=5.0,
            name=name,
            active=lambda q, v, sign=sign: sign * q[3] - 0.05,
        )
        for name, sign in (("a", 1.0), ("b", -1.0))
    ]
    gravity = [G * np.sin(SLOPE), 0, -G * np.cos(SLOPE)]
    return ik.Scene(robot, contacts=feet, gravity=gravity)


def start(x):
    """Half the angle between the legs, and the rates of the leg in front and of the other."""
    half, front, rear = x
    q = np.array([-LEG * np.sin(half), LEG * np.cos(half), -half, 2.0 * half])
    v = [LEG * np.cos(half) * front, LEG * np.sin(half) * front, front, rear - front]
    return q, np.array(v)


def back(q, v):
    """The same of the other leg, which is in front now."""
    return [-0.5 * q[3], v[2] + v[3], v[2]]


def turn_by_hand(x):
    """The return map by Lagrange's equations of both legs about the foot, and angular momentum."""
    m, h, b, length = MASS, HIP, HALF, LEG

    def slope(t, y):
        s, w, ds, dw = y
        c, d = np.cos(s - w), np.sin(s - w)
        mass = np.array(
            [
                [m * b * b + (h + m) * length**2, -m * length * b * c],
                [-m * length * b * c, m * b * b],
            ]
        )
        force = np.array(
            [
                m * length * b * d * dw**2 + (m * b + (h + m) * length) * G * np.sin(s + SLOPE),
                -m * length * b * d * ds**2 - m * b * G * np.sin(w + SLOPE),
            ]
        )
        return [ds, dw, *np.linalg.solve(mass, force)]

    def lands(t, y):
        # The legs part, scuff, and part again with the swing leg further ahead, its foot up.
        return y[0] + y[1] if t > 0.1 else 1.0

    lands.terminal, lands.direction = True, 1
    half, front, rear = x
    found = solve_ivp(
        slope,
        (0, 2),
        [-half, half, front, rear],
        "DOP853",
        [],
        events=lands,
        rtol=1e-12,
        atol=1e-13,
    )
    s, w, ds, dw = found.y_events[0][0]
    # Angular momentum of all about the new foot, and of the old stance leg about the hip.
    place = {  # leg angle θ: the hip is at the foot + l (sin θ, cos θ)
        "old": np.array([np.sin(s), np.cos(s)]),
        "new": np.array([np.sin(w), np.cos(w)]),
    }
    turn = {key: np.array([p[1], -p[0]]) for key, p in place.items()}

    def momenta(hip_speed, old_speed, new_speed):
        """About the new foot, of all; about the hip, of the old stance leg."""
        masses = [
            (h, length * place["new"], hip_speed),
            (m, length * place["new"] - b * place["old"], old_speed),
            (m, (length - b) * place["new"], new_speed),
        ]
        whole = sum(mass * across(r, u) for mass, r, u in masses)
        return np.array([whole, m * across(-b * place["old"], old_speed)])

    hip = length * turn["old"] * ds
    before = momenta(hip, hip - b * turn["old"] * ds, hip - b * turn["new"] * dw)

    def after(new, old):
        hip = length * turn["new"] * new
        return momenta(hip, hip - b * turn["old"] * old, hip - b * turn["new"] * new)

    matrix = np.array([after(1.0, 0.0), after(0.0, 1.0)]).T
    new, old = np.linalg.solve(matrix, before)
    return np.array([0.5 * (s - w), new, old]), found.t_events[0][0]


def across(r, u):
    """r × u about y."""
    return r[1] * u[0] - r[0] * u[1]


def differences(function, x, h=1e-5):
    return np.array(
        [(function(x + h * e) - function(x - h * e)) / (2 * h) for e in np.eye(len(x))]
    ).T


@pytest.mark.slow
def test_compass_gait():
    guess = np.array([0.2710, 1.0924, 0.3774])
    orbit = ik.find_orbit(compass(), guess, start=start, back=back, contact="b", duration=1.5)
    assert orbit.residual < 1e-10 and not orbit.by_differences and orbit.is_stable
    x = guess
    for _ in range(6):
        off = turn_by_hand(x)[0] - x
        slope = differences(lambda y: turn_by_hand(y)[0], x)
        x = x + np.linalg.solve(np.eye(3) - slope, off)
    np.testing.assert_allclose(orbit.x, x, atol=1e-11)
    assert orbit.period == pytest.approx(turn_by_hand(x)[1], abs=1e-11)
    # As published: 0.734 s.
    assert round(orbit.period, 3) == 0.734
    right = np.linalg.eigvals(differences(lambda y: turn_by_hand(y)[0], x))
    np.testing.assert_allclose(
        np.sort_complex(orbit.multipliers), np.sort_complex(right), atol=1e-6
    )


INERTIA = 1e-3


def wheel(spokes):
    """A rimless wheel: 1 kg, all but a point, on massless spokes of 1 m; half the angle between."""
    half = np.pi / spokes
    robot = one_body("hub", 1, (0, INERTIA, 0), root="sagittal")
    feet = [
        ik.Contact(
            "hub",
            at=[-np.sin(sign * half), 0, -np.cos(half)],
            friction=5.0,
            name=name,
        )
        for name, sign in (("rear", 1.0), ("front", -1.0))
    ]
    return robot, half, feet


@pytest.mark.slow
def test_rimless_wheel():
    """The multiplier is cos² 2α, and the speed that returns its closed form (McGeer 1990)."""
    robot, half, feet = wheel(8)
    slope = np.radians(5.0)
    scene = ik.Scene(robot, contacts=feet, gravity=[G * np.sin(slope), 0, -G * np.cos(slope)])

    def start(x):
        # On the spoke in front, which is upright after half a step: turned back to be the rear.
        q = np.array([-np.sin(half), np.cos(half), -2.0 * half])
        return q, [np.cos(half) * x[0], np.sin(half) * x[0], x[0]]

    orbit = ik.find_orbit(
        scene, [1.144], start=start, back=lambda q, v: [v[2]], contact="front", duration=1.0
    )
    inertia = 1.0 + INERTIA
    kept = (INERTIA + np.cos(2.0 * half)) / inertia
    # ω⁺² = kept² (ω⁺² + 4 m g l sin α sin γ / (I + m l²)).
    gained = 4.0 * G * np.sin(half) * np.sin(slope) / inertia
    right = np.sqrt(kept**2 * gained / (1.0 - kept**2))
    np.testing.assert_allclose(orbit.x, [right], atol=1e-8)
    np.testing.assert_allclose(orbit.multipliers, [kept**2], atol=1e-7)
    np.testing.assert_allclose(orbit.multipliers, [np.cos(2.0 * half) ** 2], atol=INERTIA)


def test_a_foot_that_does_not_count_passes_through():
    """A ball falls through a floor that counts only for what comes up... and lands when it does."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    floor = ik.Contact("ball", normal=[0, 0, 1], name="floor", active=lambda q, v: -9.0 - v[2])
    push = ik.Actuator("root_joint", lambda t, q, v: [0, 0, 40.0 if q[2] < -2.0 else 0.0, 0, 0, 0])
    q = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    down = ik.simulate(ik.Scene(ball, contacts=[floor]), q, ball.velocity(), duration=1.0)
    assert not down.impacts and down.status is ik.MotionStatus.FINISHED
    np.testing.assert_allclose(down.q[-1][2], 1.0 - 0.5 * G, atol=1e-10)
    # Thrown up from below, it comes out, and is fast enough to count when it comes back.
    scene = ik.Scene(ball, contacts=[floor], forces=[push])
    below = ball.configuration(root_joint=[0, 0, -1, 0, 0, 0, 1])
    up = ball.velocity(root_joint=[0, 0, 11.0, 0, 0, 0])
    motion = ik.simulate(scene, below, up, duration=2.5)
    speed = np.sqrt(121.0 - 2 * G)
    assert [round(t, 9) for t, _ in motion.impacts] == [round((11.0 + speed) / G, 9)]
    assert motion.q[-1][2] == pytest.approx(0.0, abs=1e-9)
