"""One contact: known answers, every answer there can be, and none where there is none."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from tests.conformance.end_laws import answers_of_one
from tests.conformance.path_laws import struck_along_path

from .rows import block, in_own_rows, rod, solved, solved_rows, sphere

LAWS = [
    ik.Law(restitution, slip)
    for restitution in ("newton", "poisson", "stronge")
    for slip in ("end", "path")
    if (restitution, slip) != ("stronge", "end")
]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.slip}")
every_path = pytest.mark.parametrize("law", LAWS[1::2] + LAWS[4:], ids=lambda x: x.restitution)


@every_law
@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_a_sphere_slips_or_rolls(law, e):
    """It slips below µ = (2/7)|v_t|/((1+e)|v_n|) and rolls with 5/7 v_t above."""
    m, v_t, v_n = 1.7, 0.9, 1.3
    direction = np.array([0.6, -0.8])
    limit = 2 / 7 * v_t / ((1 + e) * v_n)
    u = np.r_[v_t * direction, -v_n]
    for mu in (0.3 * limit, 0.99 * limit):
        impact, after = solved(sphere(m), u, e, mu, law=law)
        P = m * (1 + e) * v_n
        assert in_own_rows(impact) == pytest.approx(np.r_[-mu * P * direction, P], abs=1e-13 * P)
        assert after[:2] == pytest.approx((v_t - 3.5 * mu * (1 + e) * v_n) * direction, abs=1e-13)
        assert impact.contacts[0].mode == "sliding"
    for mu in (1.01 * limit, 30.0):
        impact, after = solved(sphere(m), u, e, mu, law=law)
        assert after == pytest.approx([0, 0, e * v_n], abs=1e-13)
        centre = v_t * direction + in_own_rows(impact)[:2] / m
        assert centre == pytest.approx(5 / 7 * v_t * direction, abs=1e-13)
        assert impact.contacts[0].mode == "sticking" and impact.is_valid()


def test_a_superball():
    """e = e_t = 1: u_t turns around, the centre keeps 3/7 of its speed and no energy is lost."""
    impact, after = solved(sphere(2.0), [1.0, 0, -1], 1.0, 10.0, 1.0)
    assert after == pytest.approx([-1, 0, 1], abs=1e-14)
    assert 1.0 + in_own_rows(impact)[0] / 2.0 == pytest.approx(3 / 7, abs=1e-14)
    assert impact.energy.change == pytest.approx(0, abs=1e-14) and impact.is_valid()


@every_law
@pytest.mark.parametrize("theta", [0.4, 0.9, 1.3])
def test_painleves_critical_friction(theta, law):
    """Above µ = (1 + 3cos²θ)/(3 sin θ cos θ), where W_nn = µ W_nt·s, slip of any speed jams."""
    critical = (1 + 3 * np.cos(theta) ** 2) / (3 * np.sin(theta) * np.cos(theta))
    W = rod(theta)
    bad = np.sign(W[0, 2])
    for speed in (2.0, 1e4):
        u = [speed * bad, 0, -0.5]
        jam, after = solved(W, u, 0.0, 1.01 * critical, law=law)
        assert jam.is_valid() and after == pytest.approx(np.zeros(3), abs=1e-11 * speed)
    slides, after = solved(W, [1e4 * bad, 0, -0.5], 0.0, 0.99 * critical, law=law)
    assert slides.is_valid() and bad * after[0] > 1e3
    back, _ = solved(W, [-2.0 * bad, 0, -0.5], 0.0, 1.01 * critical, law=law)
    assert back.is_valid() and not back.uniqueness.several


@every_law
def test_a_rough_floor_raises_the_energy_under_newtons_law_alone(law):
    """A rod that is thrown backwards against its tilt (Kane & Levinson 1985)."""
    W = rod(0.8)
    u = np.array([np.sign(W[0, 2]) * -0.5, 0, -1.0])
    impact, after = solved(W, u, 1.0, 1.0, law=law)
    gain = 0.5 * in_own_rows(impact) @ (u + after)
    assert impact.energy.change == pytest.approx(gain, abs=1e-13)
    assert impact.is_valid() == (gain <= 1e-12)
    if law.restitution == "newton" and law.slip == "end":
        assert gain > 0.01 and impact.status is ik.Status.ENERGY_GAIN
    if law.restitution == "stronge":
        assert gain <= 1e-14


@every_law
def test_known_impulses_at_the_same_instant(law):
    """Newton's target is −e u_n⁻; what known impulses do comes on top of the start."""
    _, after = solved(sphere(), [0.2, 0, -1.0], 0.5, 0.1, free=[0.2, 0, -1.5], law=law)
    assert after[2] == pytest.approx(0.5 if law.restitution == "newton" else 0.75, abs=1e-13)


@pytest.mark.parametrize("approach", [1e-3, 1e-9, 1e-13])
def test_a_graze_is_not_taken_for_a_jam(approach):
    """Sticking would need friction along the slip; however slow the approach, it only slides."""
    W = np.array([[3.285969, 0.061805, -2.956236], [0.061805, 0.125385, -0.196972],
                  [-2.956236, -0.196972, 2.831259]])  # fmt: skip
    impact, after = solved(W, [0.2528784, -0.1479444, -approach], mu=1.5)
    P = in_own_rows(impact)
    assert 0.0 < P[2] < 10.0 * approach
    slip = after[:2] / np.linalg.norm(after[:2])
    assert P[:2] == pytest.approx(-1.5 * P[2] * slip, rel=1e-5)


def test_all_answers_and_no_other():
    """Whether all modes give one or several is told, and what is shown is one of them."""
    rng, seen = np.random.default_rng(11), set()
    for _ in range(100):
        rows = rng.normal(size=(3, rng.integers(3, 7))) * np.exp(rng.normal(size=(3, 1)))
        W, mu = rows @ rows.T, 10 ** rng.uniform(-1.5, 0.7)
        u = rng.normal(size=3) * rng.choice([0.1, 1.0, 10.0], size=3)
        u[2], e = -abs(u[2]), rng.uniform()
        every = answers_of_one(W, u * [1, 1, 1 + e], mu)
        impact, _ = solved(W, u, e, mu)
        seen.add(len(every))
        if not every:
            assert not impact.is_valid()
            continue
        off = min(np.abs(P - in_own_rows(impact)).max() for P in every)
        assert off <= 1e-12 * np.linalg.cond(W) * np.abs(every).max()
        assert impact.uniqueness.several == (len(every) > 1)
        assert len(impact.uniqueness.others) == len(every) - 1
    assert {1, 3} <= seen


def test_what_parts_may_be_drawn_in_and_another_answer_is_told():
    rng, drawn = np.random.default_rng(13), 0
    for _ in range(40):
        rows = rng.normal(size=(3, 3))
        W, u, mu = rows @ rows.T, rng.normal(size=3), rng.uniform(1.0, 6.0)
        u[2] = abs(u[2])
        impact, _ = solved(W, u, 0.0, mu)
        several = len(answers_of_one(W, u, mu)) > 1
        assert impact.uniqueness.several == several
        assert not in_own_rows(impact).any()
        drawn += several
    assert drawn > 3


@every_path
def test_along_its_path_as_integrated(law):
    """Of every rank and shape: in a plane, of long thin links, slip that turns or is nothing."""
    rng = np.random.default_rng(3)
    for k in range(40):
        W = rod(rng.uniform(0.1, 1.5)) if k % 3 == 0 else block(rng, 3 + k % 4)
        u = rng.normal(size=3) * (rng.choice([0.1, 1.0, 10.0]), k % 3 != 0, 1.0)
        u[2] = -abs(u[2])
        e, mu = rng.uniform(0.05, 1.0), 10 ** rng.uniform(-2, 0.3)
        if k % 3 == 0:
            # Nothing moves across the plane.
            W[1, 1] = 1.0
        impact, _ = solved(W, u, e, mu, law=law)
        P = in_own_rows(impact)
        truth = struck_along_path(W, u, e, mu, law.restitution)
        assert pytest.approx(truth, abs=1e-9 * truth[2]) == P
        if law.restitution == "stronge":
            assert impact.energy.change <= 1e-12


@every_path
@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("slip", [-1.0, 0.0, 1.0])
def test_what_wedges_while_it_approaches_has_no_answer(law, slip, e):
    """One speed s moves the contact by (1, 0, 0.1) s; the rest of its approach is driven."""
    rows = np.column_stack([[1.0, 0.0, 0.1], [0.0, 0.0, -1.0]])
    impact = solved_rows(rows, [slip, 1.0], e, 0.6, law=law, kept=1)
    assert not impact.is_valid() and np.isfinite(impact.v_after).all()
