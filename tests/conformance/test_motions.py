"""Motions with closed forms: flight, bounces, slides, swings, jerks, rests."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import impulsekit as ik

G = 9.81
NEAR = 1e-8

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
MASS, RADIUS, INERTIA = 0.5, 0.05, 0.0005


def masses(*axes, mass=1.0):
    """Masses on slides that hang on the world, each along its own axis."""
    links = "".join(
        f'<link name="m{i}"><inertial><mass value="{mass * (i + 1)}"/><inertia ixx="1" iyy="1" '
        f'izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="s{i}" type="prismatic">'
        f'<parent link="rail"/><child link="m{i}"/><axis xyz="{axis}"/><limit lower="-100" '
        'upper="100" effort="1e9" velocity="1e9"/></joint>'
        for i, axis in enumerate(axes)
    )
    return ik.Robot.from_urdf(f'<robot name="slides"><link name="rail"/>{links}</robot>')


def plane_mass():
    """A mass that slides along x and then z."""
    text = """<robot name="bead"><link name="rail"/>
    <link name="sleigh"><inertial><mass value="1e-9"/><inertia ixx="1e-9" iyy="1e-9" izz="1e-9"
      ixy="0" ixz="0" iyz="0"/></inertial></link>
    <link name="bead"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
      iyz="0"/></inertial></link>
    <joint name="x" type="prismatic"><parent link="rail"/><child link="sleigh"/><axis xyz="1 0 0"/>
      <limit lower="-9" upper="9" effort="1e9" velocity="1e9"/></joint>
    <joint name="z" type="prismatic"><parent link="sleigh"/><child link="bead"/><axis xyz="0 0 1"/>
      <limit lower="-9" upper="9" effort="1e9" velocity="1e9"/></joint></robot>"""
    return ik.Robot.from_urdf(text)


def follow(robot, q, v, duration, *, law=None, samples=11, **entries):
    scene = ik.Scene(robot, law=law or ik.Law(), gravity=(0, 0, -G), **entries)
    motion = ik.simulate(scene, q, v, duration=duration, samples=samples, accuracy="high")
    assert motion.status.finished
    return motion


def ball_at(x=0.0, z=0.0):
    return BALL.configuration(root_joint=[x, 0, z, 0, 0, 0, 1])


def test_a_free_rod_turns_as_euler_has_it():
    """ω_x stays, ω_y and ω_z go round at (I − I_x)/I ω_x; the mass centre flies a parabola."""
    rod = ik.Robot.from_urdf("models/rod.urdf", root="freeflyer")
    v = rod.velocity(root_joint=[1, 2, 3, 40.0, 0.5, -0.2])
    motion = follow(rod, rod.neutral(), v, 0.7)
    rate = (1.0 / 12.0 - 5e-5) * 12.0 * 40.0
    c, s = np.cos(rate * motion.t), np.sin(rate * motion.t)
    np.testing.assert_allclose(motion.v[:, 3], 40.0, atol=NEAR)
    np.testing.assert_allclose(motion.v[:, 4], 0.5 * c - 0.2 * s, atol=NEAR)
    np.testing.assert_allclose(motion.v[:, 5], -0.2 * c - 0.5 * s, atol=NEAR)
    momentum = motion.momentum().linear
    falls = motion.t[:, None] * np.array([0, 0, -G])
    np.testing.assert_allclose(momentum - momentum[0], falls, atol=NEAR)


def test_a_ball_bounces_ever_lower_and_rests():
    """t_k = t_0 (1 + 2 Σ eⁱ), and rest at t_0 (1 + e)/(1 − e)."""
    e, h = 0.5, 1.3
    floor = ik.Contact("ball", restitution=e)
    motion = follow(BALL, ball_at(z=h), BALL.velocity(), 2.0, contacts=[floor])
    first = math.sqrt(2.0 * h / G)
    times = [t for t, _ in motion.impacts][:8]
    wanted = first * (1.0 + 2.0 * np.array([sum(e**i for i in range(1, k + 1)) for k in range(8)]))
    np.testing.assert_allclose(times, wanted, atol=NEAR)
    assert motion.rests[-1].start == pytest.approx(first * (1 + e) / (1 - e), abs=1e-6)
    assert abs(motion.q[-1][2]) < NEAR and np.abs(motion.v[-1]).max() < NEAR


def test_a_pendulum_swings_with_legendres_period():
    """T = 4 K(sin²(θ/2)) √(2L/3g) of a rod."""
    arm, theta = ik.Robot.from_urdf(ik.models.pendulum_urdf(1)), 2.5
    period = 4.0 * ellipk(math.sin(0.5 * theta) ** 2) * math.sqrt(2.0 / (3.0 * G))
    motion = follow(arm, [theta], [0.0], period, samples=5)
    np.testing.assert_allclose(motion.q[:, 0], theta * np.array([1, 0, -1, 0, 1]), atol=1e-7)


def test_a_bead_slides_round_a_hoop_as_a_pendulum_swings():
    bead, theta = plane_mass(), 2.0
    period = 4.0 * ellipk(math.sin(0.5 * theta) ** 2) / math.sqrt(G)
    hoop = ik.GapConstraint(lambda q: q[0] ** 2 + q[1] ** 2 - 1.0)
    start = np.array([math.sin(theta), -math.cos(theta)])
    motion = follow(bead, start, [0.0, 0.0], period, samples=5, constraints=[hoop])
    wanted = [start, [0, -1], start * [-1, 1], [0, -1], start]
    np.testing.assert_allclose(motion.q, wanted, atol=1e-6)


def test_what_slides_on_a_floor_stops():
    """After v/(µ g), v²/(2 µ g) further on."""
    mu, speed = 0.3, 2.0
    floor = ik.Contact("ball", friction=mu)
    v = BALL.velocity(root_joint=[speed, 0, 0, 0, 0, 0])
    motion = follow(BALL, ball_at(), v, 1.0, contacts=[floor])
    end = speed / (mu * G)
    t = np.minimum(motion.t, end)
    np.testing.assert_allclose(motion.q[:, 0], speed * t - 0.5 * mu * G * t * t, atol=NEAR)


@pytest.mark.parametrize("mu", [0.2, 0.9])
def test_on_a_slope_it_sticks_or_slides(mu):
    """a = g (sin α − µ cos α) where that is above 0."""
    alpha = 0.5
    normal = [math.sin(alpha), 0.0, math.cos(alpha)]
    slope = ik.Contact("ball", normal=normal, friction=mu)
    motion = follow(BALL, ball_at(), BALL.velocity(), 0.5, contacts=[slope])
    rate = max(G * (math.sin(alpha) - mu * math.cos(alpha)), 0.0)
    far = 0.5 * rate * motion.t**2
    wanted = np.outer(far, [math.cos(alpha), 0.0, -math.sin(alpha)])
    np.testing.assert_allclose(motion.q[:, :3], wanted, atol=NEAR)


def test_a_ball_that_slides_rolls_at_last():
    """At 5/7 of its speed, from 2 v/(7 µ g) on."""
    world = ik.combine(ball=BALL, floor=ik.Robot.from_urdf("models/floor.urdf"))
    q = world.configuration(**{"ball/root_joint": ball_at(z=RADIUS)})
    v = world.velocity({"ball/root_joint": [1.4, 0, 0, 0, 0, 0]})
    mu = 0.2
    below = ik.Collision("ball/ball", "floor/floor", friction=mu)
    motion = follow(world, q, v, 0.4, contacts=[below])
    t = np.minimum(motion.t, 2.0 * 1.4 / (7.0 * mu * G))
    far = 1.4 * t - 0.5 * mu * G * t * t + (motion.t - t) * 1.0
    np.testing.assert_allclose(motion.q[:, 0], far, atol=NEAR)
    assert motion.v[-1][4] * RADIUS == pytest.approx(5.0 / 7.0 * 1.4, abs=NEAR)


def test_spin_on_a_pad_dies_out():
    """τ m g against it, until I ω is used up."""
    pad = ik.Contact("ball", torsion=0.002)
    v = BALL.velocity(root_joint=[0, 0, 0, 0, 0, 6.0])
    motion = follow(BALL, ball_at(), v, 0.5, contacts=[pad])
    wanted = np.maximum(6.0 - 0.002 * MASS * G / INERTIA * motion.t, 0.0)
    np.testing.assert_allclose(motion.v[:, 5], wanted, atol=NEAR)


def test_a_rope_jerks_taut():
    """The speed along the rope is lost, that across it stays."""
    length, aside = 1.0, 0.6
    rope = ik.Rope("ball", length=length)
    motion = follow(BALL, ball_at(x=aside), BALL.velocity(), 0.6, contacts=[rope])
    time, impact = motion.impacts[0]
    assert time == pytest.approx(math.sqrt(2.0 * 0.8 / G), abs=NEAR)
    fall = math.sqrt(2.0 * G * 0.8)
    across = np.array([-0.8, 0.0, -0.6])
    np.testing.assert_allclose(impact.v_after[:3], 0.6 * fall * across, atol=NEAR)
    far = np.linalg.norm(motion.q[motion.t > time, :3], axis=1)
    np.testing.assert_allclose(far, length, atol=NEAR)


def test_a_block_rocks_over_as_housner_has_it():
    """ω⁺ = (1 − ³⁄₂ sin² α) ω⁻ as it comes down on its other edge, and none of it slips."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    # 0.1 m high and 0.3 m long are no slender block: it stands on its short side.
    half, high = 0.05, 0.15
    alpha, tilt = math.atan2(half, high), 0.1
    ends = [(x, y, z) for z in (-half, half) for x in (-high,) for y in (-0.1, 0.1)]
    contacts = [ik.Contact("box", at=at, friction=3.0) for at in ends]
    # The box's −x is down, its z along the world's x; it leans over the edge at world +x.
    upright = math.pi / 2.0
    turn = tilt - upright
    edge = np.array([half, 0.0, 0.0])
    c, s = math.cos(tilt), math.sin(tilt)
    to_centre = np.array([-half * c + high * s, 0.0, half * s + high * c])
    quaternion = [0.0, math.sin(0.5 * turn), 0.0, math.cos(0.5 * turn)]
    q = box.configuration(root_joint=[*(edge + to_centre), *quaternion])
    motion = follow(box, q, box.velocity(), 0.6, contacts=contacts)
    hit = next(impact for _, impact in motion.impacts if abs(impact.v_before[4]) > 0.1)
    before, after = hit.v_before[4], hit.v_after[4]
    # m g R (cos(α − tilt) − cos α) became kinetic; I about the edge is 4/3 m R².
    radius = math.hypot(half, high)
    gained = 1.5 * G / radius * (math.cos(alpha - tilt) - math.cos(alpha))
    assert before**2 == pytest.approx(gained, rel=1e-6)
    assert after == pytest.approx((1.0 - 1.5 * math.sin(alpha) ** 2) * before, rel=1e-6)


def test_newtons_cradle_passes_the_speed_on():
    ball = ik.Robot.from_urdf("models/cradle_ball.urdf")
    places = {name: [0.022 * i, 0, 0] for i, name in enumerate("abc")}
    cradle = ik.combine(dict.fromkeys("abc", ball), placements=places)
    hits = [
        ik.Collision(f"{one}/ball", f"{other}/ball", restitution=1.0) for one, other in ("ab", "bc")
    ]
    q = cradle.configuration(**{"a/swing": 0.5})
    law = ik.Law(order="sequential")
    motion = follow(cradle, q, cradle.velocity(), 0.3, law=law, contacts=hits)
    (_, impact), *_ = motion.impacts
    length, inertia = 0.15, 2.11992e-06 + 0.0438 * 0.15**2
    speed = math.sqrt(2.0 * 0.0438 * G * length * (1.0 - math.cos(0.5)) / inertia)
    np.testing.assert_allclose(np.abs(impact.v_before), [speed, 0, 0], atol=NEAR)
    np.testing.assert_allclose(np.abs(impact.v_after), [0, 0, speed], atol=NEAR)


def test_a_ball_on_a_table_that_shakes():
    """It meets z = 0.1 sin 20 t on its fall, and leaves it with e of the relative speed."""
    robot = masses("0 0 1", "0 0 1")
    table = ik.Driven("s0", lambda t: 0.1 * math.sin(20.0 * t))
    floor = ik.Contact("m1", against="m0", restitution=0.6)
    motion = follow(robot, [0.0, 1.0], [2.0, 0.0], 0.6, constraints=[table], contacts=[floor])
    t = brentq(lambda t: 1.0 - 0.5 * G * t * t - 0.1 * math.sin(20.0 * t), 0.3, 0.5, xtol=1e-15)
    time, impact = motion.impacts[0]
    assert time == pytest.approx(t, abs=NEAR)
    moves = 2.0 * math.cos(20.0 * t)
    np.testing.assert_allclose(impact.v_after, [moves, moves + 0.6 * (moves + G * t)], atol=1e-7)


def test_two_masses_on_a_pulley():
    """a = g (m₂ − m₁)/(m₁ + m₂)."""
    robot = masses("0 0 1", "0 0 1")
    pulley = ik.JointCoupling("s0", "s1", ratio=-1.0)
    motion = follow(robot, [0.0, 0.0], [0.0, 0.0], 0.8, constraints=[pulley])
    np.testing.assert_allclose(motion.q[:, 0], 0.5 * G / 3.0 * motion.t**2, atol=NEAR)
    np.testing.assert_allclose(motion.q[:, 1], -motion.q[:, 0], atol=NEAR)


def test_a_rod_rebounds_from_its_stop():
    """It swings back to 1 − cos θ' = e² (1 − cos θ)."""
    arm, theta, e = ik.Robot.from_urdf(ik.models.pendulum_urdf(1)), 1.2, 0.7
    stop = ik.JointStop("joint_1", lower=0.0, restitution=e)
    motion = follow(arm, [theta], [0.0], 2.0, samples=20001, contacts=[stop])
    (first, impact), (second, _), *_ = motion.impacts
    speed = math.sqrt(3.0 * G * (1.0 - math.cos(theta)))
    assert impact.v_before[0] == pytest.approx(-speed, abs=NEAR)
    assert impact.v_after[0] == pytest.approx(e * speed, abs=NEAR)
    between = (motion.t > first) & (motion.t < second)
    highest = motion.q[between, 0].max()
    assert 1.0 - math.cos(highest) == pytest.approx(e * e * (1.0 - math.cos(theta)), abs=1e-6)
