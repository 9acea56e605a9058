"""A ball between ball and cloth: friction along the path at three contacts at once."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik

from ..robots import one_body

# Mathavan, Jackson & Parkin (2014): a snooker ball, its friction on balls and cloth.
MASS, RADIUS, E, ON_BALL, ON_CLOTH = 0.1406, 0.02625, 0.89, 0.05, 0.21
INERTIA = 0.4 * MASS * RADIUS**2
NORMAL, UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def rates(state):
    """By impulse between the balls: velocities and spins of both, and the approach.

    The cloth carries what friction between the balls presses a ball into it, and rubs.
    """
    v1, w1, v2, w2 = state.reshape(4, 3)
    u = v1 + np.cross(w1, RADIUS * NORMAL) - v2 - np.cross(w2, -RADIUS * NORMAL)
    slip = u - NORMAL * (u @ NORMAL)
    speed = np.linalg.norm(slip)
    friction = -ON_BALL * slip / speed if speed > 1e-12 else np.zeros(3)
    parts = []
    for v, w, sign in ((v1, w1, -1.0), (v2, w2, 1.0)):
        own = -sign * friction
        touch = v + np.cross(w, -RADIUS * UP)
        touch = touch - UP * (touch @ UP)
        speed = np.linalg.norm(touch)
        load = max(0.0, -own[2])
        cloth = -ON_CLOTH * load * touch / speed if speed > 1e-12 else np.zeros(3)
        parts.append((sign * NORMAL + own + load * UP + cloth) / MASS)
        arms = np.cross(-sign * RADIUS * NORMAL, own) + np.cross(-RADIUS * UP, cloth)
        parts.append(arms / INERTIA)
    return np.concatenate(parts), u @ NORMAL


def followed(v, w, steps):
    """Velocities and spins behind the collision, e² of the work regained."""
    state = np.concatenate([v, w, np.zeros(6)])
    d = MASS * np.linalg.norm(v) / steps
    work, most = 0.0, None
    while True:
        first, _ = rates(state)
        slope, middle = rates(state + 0.5 * d * first)
        share = 1.0
        if most is None and middle <= 0.0:
            most = work
        if most is not None and work + d * middle <= most * (1.0 - E * E):
            share = (most * (1.0 - E * E) - work) / (d * middle)
        state = state + share * d * slope
        work += share * d * middle
        if share < 1.0:
            return state


@pytest.mark.parametrize(
    ("v", "w"),
    [
        ([0.0, 1.539, 0.0], [-58.6, 0.0, 0.0]),
        ([0.0, 1.0, 0.0], [10.0, 0.0, 30.0]),
        ([0.7, 0.7, 0.0], [-20.0, 20.0, 0.0]),
    ],
    ids=["rolling", "with side", "at an angle"],
)
def test_ball_between_ball_and_cloth(v, w):
    ball = one_body("ball", MASS, INERTIA)
    balls = ik.combine(a=ball, b=ball)
    hit = ik.Contact(
        "a/ball", at=[0, RADIUS, 0], normal=[0, -1, 0], origin=[0, -RADIUS, 0], against="b/ball",
        restitution=E, friction=ON_BALL, stiffness=1.0,
    )  # fmt: skip
    cloth = [
        ik.Contact(f"{name}/ball", at=[0, 0, -RADIUS], friction=ON_CLOTH, stiffness=np.inf)
        for name in "ab"
    ]
    scene = ik.Scene(balls, contacts=[hit, *cloth], law=ik.Law("lzb"), gap_bound=np.inf)
    q = balls.configuration(
        {
            "a/root_joint": [0, 0, RADIUS, 0, 0, 0, 1],
            "b/root_joint": [0, 2 * RADIUS, RADIUS, 0, 0, 0, 1],
        }
    )
    impact = ik.solve(scene, q, balls.velocity({"a/root_joint": [*v, *w]}))
    assert impact.is_valid()
    own, truth = impact.v_after.reshape(4, 3), followed(v, w, 1000).reshape(4, 3)
    size = np.linalg.norm(v)
    # The truth itself has an error of some (1/1000)².
    assert np.abs(own - truth)[[0, 2]].max() < 1e-5 * size
    assert RADIUS * np.abs(own - truth)[[1, 3]].max() < 1e-5 * size
    for k in (0, 2):
        angles = [np.arctan2(each[k, 0], each[k, 1]) for each in (own, truth)]
        assert abs(np.degrees(angles[0] - angles[1])) < 0.02


# Mathavan, Jackson & Parkin (2010): a cushion whose nose is 7R/5 above the cloth.
E_CUSHION, ON_CUSHION, ON_TABLE = 0.98, 0.14, 0.212
OUT = np.array([0.0, -np.sqrt(0.84), -0.4])


def cushion_rates(state):
    """By impulse of the cushion: velocity, spin and work; and the slower of both slips."""
    v, w = state[:3], state[3:6]
    u = v + np.cross(w, -RADIUS * OUT)
    slip = u - OUT * (u @ OUT)
    friction = -ON_CUSHION * slip / np.linalg.norm(slip)
    load = -(OUT + friction)[2]
    touch = (v + np.cross(w, -RADIUS * UP)) * (1.0 - UP)
    cloth = -ON_TABLE * load * touch / np.linalg.norm(touch)
    dv = (OUT + friction + load * UP + cloth) / MASS
    dw = (np.cross(-RADIUS * OUT, friction) + np.cross(-RADIUS * UP, cloth)) / INERTIA
    slowest = min(np.linalg.norm(slip), np.linalg.norm(touch))
    return np.concatenate([dv, dw, [u @ OUT]]), slowest


def along_cushion(v, w):
    """Velocities and spin behind the cushion, at 1e-12; both contacts slip throughout."""
    state, most = np.concatenate([v, w, [0.0]]), None

    def turns(_, y):
        return cushion_rates(y)[0][6]

    def regained(_, y):
        return y[6] - most * (1.0 - E_CUSHION**2)

    for end in (turns, regained):
        end.terminal = True
        way = solve_ivp(
            lambda _, y: cushion_rates(y)[0], [0, 5 * MASS], state, "DOP853",
            rtol=1e-12, atol=1e-14, events=end,
        )  # fmt: skip
        state = way.y[:, -1]
        assert way.status == 1 and min(cushion_rates(y)[1] for y in way.y.T) > 0.1
        most = state[6]
    return state[:6]


@pytest.mark.parametrize(
    ("angle", "side", "top"), [(20, -2, 0), (45, 1, 3), (70, 2, 0), (45, -1, 0)]
)
def test_ball_between_cushion_and_cloth(angle, side, top):
    ball = one_body("ball", MASS, INERTIA)
    cushion = ik.Contact(
        "ball", at=-RADIUS * OUT, normal=OUT, restitution=E_CUSHION, friction=ON_CUSHION,
        stiffness=1.0,
    )  # fmt: skip
    cloth = ik.Contact("ball", at=[0, 0, -RADIUS], friction=ON_TABLE, stiffness=np.inf)
    scene = ik.Scene(ball, contacts=[cushion, cloth], law=ik.Law("lzb"), gap_bound=np.inf)
    v = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
    w = (np.cross(UP, v) * top + side * UP) / RADIUS
    impact = ik.solve(scene, ball.neutral(), np.concatenate([v, w]))
    truth = along_cushion(v, w)
    assert impact.is_valid()
    assert np.abs(impact.v_after - truth)[:3].max() < 1e-9
    assert RADIUS * np.abs(impact.v_after - truth)[3:].max() < 1e-9
