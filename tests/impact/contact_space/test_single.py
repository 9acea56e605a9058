"""One contact with friction: known answers, and every answer there can be."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from impulsekit.errors import InputError, NotFiniteError, RangeError, ShapeError
from impulsekit.impact.contact_law import solve_contacts
from impulsekit.laws.coulomb import coulomb, coulomb_impulse
from impulsekit.laws.quartic import slides
from impulsekit.laws.status import Status
from impulsekit.scene.law import Law

from .problems import block, problem, rod, solved, sphere

LAWS = [
    Law(restitution, slip)
    for restitution in ("newton", "poisson", "stronge")
    for slip in ("end", "path")
    if (restitution, slip) != ("stronge", "end")
]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.slip}")


@every_law
@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_a_sphere_slips_or_rolls(law, e):
    """It slips below µ = (2/7)|v_t|/((1+e)|v_n|) and rolls with 5/7 v_t above."""
    m, v_t, v_n = 1.7, 0.9, 1.3
    direction = np.array([0.6, -0.8])
    limit = 2 / 7 * v_t / ((1 + e) * v_n)
    u = np.r_[v_t * direction, -v_n]
    for mu in (0.3 * limit, 0.99 * limit):
        answer = solved(sphere(m), u, e, mu, law=law)
        P = m * (1 + e) * v_n
        np.testing.assert_allclose(answer.impulse, np.r_[-mu * P * direction, P], atol=1e-14 * P)
        slip = v_t - 3.5 * mu * (1 + e) * v_n
        np.testing.assert_allclose(answer.velocity_after[:2], slip * direction, atol=1e-14)
    for mu in (1.01 * limit, 30.0):
        answer = solved(sphere(m), u, e, mu, law=law)
        np.testing.assert_allclose(answer.velocity_after, [0, 0, e * v_n], atol=1e-14)
        centre = v_t * direction + answer.impulse[:2] / m
        np.testing.assert_allclose(centre, 5 / 7 * v_t * direction, atol=1e-14)
        assert answer.status is Status.SOLVED


def test_a_rough_floor_can_raise_the_energy_with_newton():
    """A rod that is thrown backwards against its tilt (Kane & Levinson 1985)."""
    theta = 0.8
    W = rod(theta)
    u = np.array([np.sign(W[0, 2]) * -0.5, 0, -1.0])
    gain = {}
    for law in LAWS:
        answer = solved(W, u, 1.0, 1.0, law=law)
        gain[law.restitution, law.slip] = answer.normal_work[0] + answer.friction_work[0]
        change = answer.impulse @ (u + answer.velocity_after) / 2
        assert gain[law.restitution, law.slip] == pytest.approx(change, abs=1e-13)
        raised = gain[law.restitution, law.slip] > 1e-9
        assert (answer.status is Status.ENERGY_GAIN) == raised
    assert gain["newton", "end"] > 0.01
    assert gain["stronge", "path"] <= 0


@pytest.mark.slow
@given(st.integers(0, 10**6))
@settings(max_examples=400, deadline=None)
def test_every_direction_of_slip_is_found(seed):
    """The quartic against walking around the circle."""
    rng = np.random.default_rng(seed)
    W = block(rng, int(rng.integers(3, 6)))
    mu, b = rng.uniform(0.05, 3), rng.normal(size=3)
    b[2] = -abs(b[2])
    upper = (W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2])
    count, *directions = slides(upper, *b, mu)
    found = np.array(directions[:count]).reshape(-1, 2)
    angle = np.linspace(0, 2 * np.pi, 20001)
    s = np.array([np.cos(angle), np.sin(angle)])
    pn = -b[2] / (W[2, 2] - mu * W[2, :2] @ s)
    xi = b[:2, None] + pn * (W[:2, 2, None] - mu * W[:2, :2] @ s)
    across, along = s[0] * xi[1] - s[1] * xi[0], (s * xi).sum(axis=0)
    size = np.abs(xi).max(axis=0)
    crossing = (across[1:] > 0) != (across[:-1] > 0)
    good = crossing & (pn[1:] > 0) & (pn[:-1] > 0) & (along[1:] > 1e-3 * size[1:])
    for k in np.flatnonzero(good):
        assert np.hypot(*(found - s[:, k]).T).min() < 1e-3
    for x in found:
        p = -b[2] / (W[2, 2] - mu * W[2, :2] @ x)
        xi = b[:2] + p * (W[:2, 2] - mu * W[:2, :2] @ x)
        size = np.abs(b).max() + p * np.abs(W).max() * (1 + mu)
        assert abs(x[0] * xi[1] - x[1] * xi[0]) < 1e-12 * size
        assert x @ xi > -1e-9 * size and p > 0


def target_of(u, e, law):
    """b of Coulomb's law at the end: with Newton's restitution in its normal part."""
    return np.array([u[0], u[1], (1 + e) * u[2] if law.restitution == "newton" else u[2]])


@every_law
def test_a_contact_that_parts_gets_nothing(law):
    answer = solved(rod(0.7), [3.0, 0, 0.1], 0.5, 0.5, law=law)
    assert not answer.impulse.any() and answer.status is Status.SOLVED


@every_law
def test_known_impulses_at_the_same_instant(law):
    """The target is −e u_n⁻; what known impulses do comes on top of the start."""
    before, free = np.array([0.2, 0, -1.0]), np.array([0.2, 0, -1.5])
    answer = solved(sphere(), before, 0.5, 0.1, free=free, law=law)
    expected = 0.5 if law.restitution == "newton" else 0.75
    assert answer.velocity_after[2] == pytest.approx(expected, abs=1e-14)


def test_what_is_refused():
    with pytest.raises(InputError, match='needs slip="path"'):
        Law(restitution="stronge")
    with pytest.raises(RangeError, match="newton"):
        Law(restitution="hooke")
    for law in LAWS[1:]:
        with pytest.raises(InputError, match="tangential restitution"):
            solved(sphere(), [1, 0, -1], 0.5, 0.3, 0.5, law=law)
    with pytest.raises(RangeError, match=r"restitution must be 0 to 1, got 1\.5"):
        solved(sphere(), [1, 0, -1], 1.5)
    with pytest.raises(RangeError, match="friction"):
        solved(sphere(), [1, 0, -1], 0.5, -0.1)
    with pytest.raises(NotFiniteError, match="velocity_before"):
        solved(sphere(), [np.nan, 0, -1], 0.5)
    with pytest.raises(NotFiniteError, match="delassus"):
        solved(np.diag([np.inf, 1, 1]), [0, 0, -1], 0.5)
    with pytest.raises(ShapeError, match="delassus"):
        solved(np.eye(4), [0, 0, -1], 0.5)
    with pytest.raises(ShapeError, match="velocity_free"):
        solve_contacts(problem(np.eye(3), [0, 0, -1], free=[0, -1]), Law())


@pytest.mark.parametrize("seed", range(200))
def test_the_impulse_by_itself_is_that_of_the_whole_answer(seed):
    rng = np.random.default_rng(seed)
    W, b = block(rng), rng.normal(size=3)
    entries = (W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2])
    mu = 0.0 if seed % 10 == 0 else 2.0 * rng.uniform()
    whole, _ = coulomb(entries, *b, mu, 1.0)
    assert coulomb_impulse(entries, *b, mu, 1.0) == whole


def test_a_superball():
    """e = e_t = 1: u_t turns around, the centre keeps 3/7 of its speed and no energy is lost."""
    answer = solved(sphere(2.0), [1.0, 0, -1], 1.0, 10.0, 1.0)
    np.testing.assert_allclose(answer.velocity_after, [-1, 0, 1], atol=1e-14)
    assert 1.0 + answer.impulse[0] / 2.0 == pytest.approx(3 / 7, abs=1e-14)
    assert answer.normal_work[0] + answer.friction_work[0] == pytest.approx(0, abs=1e-14)
    assert answer.status is Status.SOLVED
