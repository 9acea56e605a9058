"""One contact with springs along its normal and its tangents."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from impulsekit.design import fit_impacts
from impulsekit.impact.contact_law import ContactProblem, solve_contacts
from impulsekit.measured import Measurement

from ..robots import one_body

COMPLIANT = ik.Law(slip="compliant")
SPENT = 1e-6
# A phase that begins on the edge of sticking leaves it by more than this.
ROUNDING = 1e-13


def struck(W, u, e, mu, ratio, law=COMPLIANT):
    one = np.ones(1)
    problem = ContactProblem(W, u, u, e * one, mu * one, 0 * one, stiffness_ratio=ratio * one)
    return solve_contacts(problem, law)


def drawn(seed):
    """W (3, 3), u⁻, e, µ and the ratio of stiffnesses."""
    rng = np.random.default_rng(seed)
    J, u = rng.normal(size=(3, 6)), rng.normal(size=3)
    u[2] = -abs(u[2]) - 0.05
    return J @ J.T + 0.1 * np.eye(3), u, *rng.uniform([0.1, 0.05, 0.3], [0.95, 1.5, 2.0])


def integrated(W, u0, e, mu, ratio):
    """(3,) u⁺ by phases, each followed in time: P, δ, and ζ or the angle of slip."""
    k, gives = 1.0 / W[2, 2], 1.0
    way, slips = np.arctan2(u0[1], u0[0]), ratio * np.hypot(*u0[:2]) > mu * abs(u0[2])
    begun = 1e-7 if slips else 0.0
    P = 0.5 * k * begun**2 * abs(u0[2]) * np.array([-mu * np.cos(way), -mu * np.sin(way), 1.0])
    state = [*P, begun * abs(u0[2]), *(([way, 0.0]) if slips else ([0.0, 0.0]))]
    for _ in range(100):

        def rates(_, y, slips=slips, gives=gives):
            u = u0 + W @ y[:3]
            if not slips:
                return [*(-ratio * k * y[4:6]), k * y[3], -gives * u[2], *u[:2]]
            F, c, s = k * y[3], np.cos(y[4]), np.sin(y[4])
            turns = ratio * k * (c * u[1] - s * u[0]) / (mu * F)
            return [-mu * F * c, -mu * F * s, F, -gives * u[2], turns, 0.0]

        def leaves(_, y, slips=slips, gives=gives):
            if not slips:
                return mu * y[3] - ratio * np.hypot(y[4], y[5]) + ROUNDING
            u = u0 + W @ y[:3]
            return u[0] * np.cos(y[4]) + u[1] * np.sin(y[4]) + mu / ratio * gives * u[2] + ROUNDING

        events = [leaves, lambda _, y: (u0 + W @ y[:3])[2], lambda _, y: y[3] - SPENT]
        for event, rising in zip(events, (-1, 1 if gives == 1.0 else -1, -1), strict=True):
            event.terminal, event.direction = True, rising
        found = solve_ivp(
            rates, [0.0, 1e3], state, "DOP853", rtol=1e-12, atol=1e-15, events=events,
            first_step=1e-8, max_step=0.05,
        )  # fmt: skip
        state = found.y[:, -1].copy()
        if len(found.t_events[2]):
            return u0 + W @ state[:3]
        if slips:
            turned = mu / ratio * state[3] * np.array([np.cos(state[4]), np.sin(state[4])])
        else:
            turned = np.array([np.arctan2(state[5], state[4]), 0.0])
        if len(found.t_events[0]):
            slips, state[4:6] = not slips, turned
        if len(found.t_events[1]):
            gives = 1.0 / e**2 if gives == 1.0 else 1.0
    raise AssertionError("the impact does not end")


@pytest.mark.slow
@pytest.mark.parametrize(
    "seeds", [range(30), pytest.param(range(30, 1000), marks=pytest.mark.sweep)]
)
def test_in_space_it_is_as_integrated(seeds):
    for seed in seeds:
        holds_as_integrated(seed)


def holds_as_integrated(seed):
    W, u, *coefficients = drawn(seed)
    found = struck(W, u, *coefficients)
    assert found.status is ik.Status.SOLVED
    size = np.abs(u).max()
    assert found.velocity_after == pytest.approx(integrated(W, u, *coefficients), abs=1e-8 * size)


def test_energy_never_rises_and_friction_stays_in_its_cone():
    for seed in range(1000):
        W, u, e, mu, ratio = drawn(seed)
        found = struck(W, u, e, mu, ratio)
        assert found.status is ik.Status.SOLVED
        assert 0.5 * found.impulse @ (u + found.velocity_after) < 0.0
        assert np.hypot(*found.impulse[:2]) <= mu * found.impulse[2] * (1.0 + 1e-9)
        assert found.velocity_after[2] >= 0.0


def test_it_ends_whatever_the_coefficients():
    """Hard and plastic, smooth and rough, soft and stiff along tangents, grazing and straight."""
    for seed in range(600):
        rng = np.random.default_rng(seed + 10**6)
        J, u = rng.normal(size=(3, 6)), rng.normal(size=3)
        u[2] = -(10.0 ** rng.uniform(-4, 1))
        e = rng.choice([0.0, 1.0, rng.uniform(0, 1), 1e-3])
        mu, ratio = 10.0 ** rng.uniform([-3, -2], [1, 3])
        found = struck(J @ J.T + 1e-3 * np.eye(3), u, e, mu, ratio)
        assert found.status is ik.Status.SOLVED, seed
        assert 0.5 * found.impulse @ (u + found.velocity_after) < 1e-12
        assert np.hypot(*found.impulse[:2]) <= mu * found.impulse[2] * (1.0 + 1e-6)


def test_rigid_along_tangents_is_coulombs_friction_along_the_path():
    path = ik.Law("stronge", "path")
    for seed in range(50):
        W, u, e, mu, _ = drawn(seed)
        found, expected = struck(W, u, e, mu, np.inf), struck(W, u, e, mu, 1.0, path)
        assert found.velocity_after == pytest.approx(expected.velocity_after, abs=1e-12)


def test_a_stiff_spring_tends_to_coulombs_friction():
    """What is left falls as 1/κ."""
    path, found = ik.Law("stronge", "path"), []
    for ratio in (1e1, 1e2, 1e3):
        off = []
        for seed in range(50):
            W, u, e, mu, _ = drawn(seed)
            here, rigid = struck(W, u, e, mu, ratio), struck(W, u, e, mu, 1.0, path)
            assert here.status is ik.Status.SOLVED
            off.append(np.abs(here.velocity_after - rigid.velocity_after).max() / np.abs(u).max())
        found.append(np.median(off))
    assert found[1:] == pytest.approx([1e-3, 1e-4], rel=0.1) and found[0] < 0.02


@pytest.mark.parametrize("turns", [1, 2])
@pytest.mark.parametrize("e", [1.0, 0.7])
def test_sticking_throughout_is_two_springs(e, turns):
    """u_t⁺ = u_t⁻ cos(ω t_f), t_f = (1 + e) π/2, where both springs let go at once: ω t_f = n π."""
    u = np.array([0.03, -0.04, -1.0])
    ratio = (2.0 * turns / (1.0 + e)) ** 2 / 3.5
    found = struck(np.diag([3.5, 3.5, 1.0]), u, e, 30.0, ratio)
    assert found.velocity_after == pytest.approx([*(u[:2] * (-1.0) ** turns), e], abs=1e-10)


def test_the_rim_of_a_superball_turns_back():
    """The speed of its rim turns round at each bounce."""
    ball = one_body("ball", 0.05, 0.4 * 0.05 * 0.02**2)
    contact = ik.Contact(
        "ball", at=[0, 0, -0.02], restitution=0.9, friction=1.0, stiffness_ratio=0.35
    )
    scene = ik.Scene(ball, contacts=[contact], law=COMPLIANT, gap_bound=np.inf)
    q, v = ball.neutral(), np.array([0.5, 0, -3.0, 0, 0, 0])
    impact = ik.solve(scene, q, v)
    rim = impact.v_after[0] - 0.02 * impact.v_after[4]
    assert impact.is_valid() and rim < -0.2
    batch = ik.solve_batch(scene, q[None], v[None])
    assert batch.v_after[0] == pytest.approx(impact.v_after, abs=1e-12)
    assert ik.contact_problem(scene, q, v).solve().v_after == pytest.approx(impact.v_after)
    free = ik.Scene(ball, contacts=[contact], law=COMPLIANT, gravity=[0, 0, -9.81])
    motion = ik.simulate(free, ball.configuration(root_joint=[0, 0, 0.5, 0, 0, 0, 1]), v, 0.5)
    assert motion.status.finished and len(motion.impacts) >= 1


def test_what_it_does_not_take_is_told():
    ball = one_body("ball", 1.0, 1.0)
    with pytest.raises(ik.errors.InputError, match="stiffness_ratio of every contact"):
        ik.Scene(ball, contacts=[ik.Contact("ball", friction=0.5)], law=COMPLIANT)
    for ratio in (0.0, -1.0, np.nan):
        with pytest.raises(ik.errors.InputError, match="stiffness_ratio"):
            ik.Contact("ball", stiffness_ratio=ratio)
    for law in ({"restitution": "poisson"}, {"order": "sequential"}, {"restitution": "lzb"}):
        with pytest.raises(ik.errors.InputError):
            ik.Law(slip="compliant", **law)


def test_coefficients_are_fitted_to_noisy_impacts():
    """e by speed, κ and µ of 120 impacts with noise of 2 %, within five of their intervals."""
    rng = np.random.default_rng(3)
    ball = one_body("ball", 0.0027, 2.0 / 3.0 * 0.0027 * 0.02**2)

    def scene(e, mu, ratio):
        contact = ik.Contact(
            "ball", at=[0, 0, -0.02], restitution=ik.RestitutionTable([0.0, 10.0], e), friction=mu,
            stiffness_ratio=ratio, name="rubber",
        )  # fmt: skip
        return ik.Scene(ball, contacts=[contact], law=COMPLIANT, gap_bound=np.inf)

    true, first = scene([0.9, 0.7], 0.4, 0.35), scene([0.8, 0.8], 0.3, 0.25)
    seen = []
    for _ in range(120):
        v = np.r_[rng.uniform(-8, 8, 2), -rng.uniform(1, 10), rng.uniform(-200, 200, 3)]
        after = ik.solve(true, ball.neutral(), v).v_after
        sigma = 0.02 * np.r_[np.full(3, np.abs(after[:3]).max()), np.full(3, 200.0)]
        noisy = after + sigma * rng.normal(size=6)
        seen.append(Measurement(first, ball.neutral(), v, noisy, sigma=sigma))
    fit = fit_impacts(seen, restitution=["rubber"], friction=["rubber"], stiffness_ratio=["rubber"])
    found = np.array([fit[name] for name in fit.names])
    assert found == pytest.approx([0.9, 0.7, 0.4, 0.35], rel=0.03)


@pytest.mark.parametrize("e", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("mu", [0.05, 10.0])
def test_the_normal_spring_loses_its_share_and_friction_the_rest(e, mu):
    """Where normal and tangents do not act on each other: −(1 − e²) u_n²/2 W_nn."""
    W, u = np.diag([3.5, 3.5, 2.0]), np.array([0.4, -0.3, -1.5])
    found = struck(W, u, e, mu, 0.8)
    normal = -(1.0 - e * e) * 1.5**2 / 4.0
    total = 0.5 * found.impulse @ (u + found.velocity_after)
    assert found.normal_work[0] == pytest.approx(normal, abs=1e-9)
    assert found.friction_work[0] == pytest.approx(total - normal, abs=1e-9)
