"""Contacts one after the other: to the last digit of their approach, and to the limit."""

from fractions import Fraction

import numpy as np
import pytest

from impulsekit.impact import Status
from impulsekit.scene.law import Law

from .problems import box, normals, problem, solved

LAWS = [
    Law("newton", "end", "sequential"),
    Law("poisson", "end", "sequential"),
    Law("newton", "path", "sequential"),
    Law("stronge", "path", "sequential"),
]
NEWTON = LAWS[0]


def named(law):
    return f"{law.restitution} {law.slip}"


def test_an_approach_far_slower_than_the_first_is_struck_as_well():
    before = [0, 0, -1.0, 0, 0, -5e-14]
    solution = solved(np.eye(6), before, e=0.5, law=NEWTON)
    assert solution.velocity_after[2::3] == pytest.approx([0.5, 2.5e-14], rel=1e-12)


@pytest.mark.parametrize("law", LAWS[:2], ids=named)
def test_the_unit_of_length_does_not_decide_which_comes_first(law):
    """A contact counts in m/s, a joint stop in rad/s: scaled rows give scaled impulses."""
    rng = np.random.default_rng(7)
    for _ in range(50):
        rows = rng.normal(size=(9, 6))
        W, u = rows @ rows.T, rng.normal(size=9)
        # The last is a stop: a single row, which no unit of length scales.
        W[6:8], W[:, 6:8], u[6:8] = 0.0, 0.0, 0.0
        mu = np.array([0.4, 0.2, 0.0])
        unit = np.r_[np.full(6, 1000.0), np.ones(3)]
        here = solved(W, u, e=0.6, mu=mu, law=law)
        there = solved(unit[:, None] * W * unit, unit * u, e=0.6, mu=mu, law=law)
        assert there.status is here.status
        if here.status.valid:
            assert there.velocity_after / unit == pytest.approx(here.velocity_after, abs=1e-9)
            assert there.impulse * unit == pytest.approx(here.impulse, abs=1e-9)


@pytest.mark.parametrize("law", LAWS[:2], ids=named)
def test_the_order_of_the_entries_does_not_decide_which_comes_first(law):
    rng = np.random.default_rng(8)
    for _ in range(50):
        rows = rng.normal(size=(12, 6))
        W, u = rows @ rows.T, rng.normal(size=12)
        e, mu = rng.uniform(0, 0.8, 4), rng.uniform(0, 0.5, 4)
        here = solved(W, u, e=e, mu=mu, law=law)
        turned = rng.permutation(4)
        place = (3 * turned[:, None] + np.arange(3)).ravel()
        there = solved(W[np.ix_(place, place)], u[place], e=e[turned], mu=mu[turned], law=law)
        assert there.status is here.status
        if here.status.valid:
            assert there.velocity_after == pytest.approx(here.velocity_after[place], abs=1e-9)


@pytest.mark.parametrize("law", LAWS, ids=named)
def test_rounding_at_a_contact_that_nothing_moves_is_no_approach(law):
    """Its parts cannot move against each other: row and velocity are rounding errors."""
    rng = np.random.default_rng(9)
    rows = rng.normal(size=(6, 6))
    rows[5] *= 1e-17
    v = rng.normal(size=6)
    rows[2] *= -np.sign(rows[2] @ v)
    rows[5] *= -np.sign(rows[5] @ v)
    u = rows @ v
    assert u[2] < 0.0 and u[5] < 0.0
    beside = solved(rows @ rows.T, u, e=0.3, mu=0.2, law=law)
    alone = solved((rows @ rows.T)[:3, :3], u[:3], e=0.3, mu=0.2, law=law)
    assert beside.status is alone.status
    assert beside.impulse[:3] == pytest.approx(alone.impulse, rel=1e-12)
    assert not beside.impulse[3:].any()


def test_what_no_impulse_can_stop_has_no_solution():
    W, u = normals(np.diag([1.0, 0.0]), [-1.0, -0.5])
    assert solved(W, u, law=NEWTON).status is Status.NO_SOLUTION


def test_walls_that_give_back_what_they_get_are_hit_without_end():
    W, u = normals([[1.0, -1.0], [-1.0, 1.0]], [-1.0, 1.0])
    assert solved(W, u, e=1.0, law=NEWTON).status is Status.NOT_CONVERGED


def test_walls_that_give_back_less_bring_what_is_between_them_to_rest():
    W, u = normals([[1.0, -1.0], [-1.0, 1.0]], [-1.0, 1.0])
    solution = solved(W, u, e=0.999, law=NEWTON)
    assert solution.status is Status.SOLVED
    assert np.abs(solution.velocity_after).max() < 1e-12
    # P₁ = 1 + e + (1 + e) e² + …, which is 1/(1 − e); P₂ is e times that.
    assert solution.impulse[[2, 5]] == pytest.approx([1000.0, 999.0], rel=1e-9)


def test_two_laws_for_one_contact_under_a_blow():
    """Sequential: the blow acts first, and the contact gives back what approaches then."""
    at_rest, struck = [0.0, 0.0, 0.0], [0.0, 0.0, -2.0]
    W = np.eye(3)
    both = problem(W, at_rest, e=0.5, free=struck)
    assert both.velocity_free[2] == -2.0
    one = solved(W, at_rest, e=0.5, free=struck, law=NEWTON)
    at_once = solved(W, at_rest, e=0.5, free=struck)
    assert one.velocity_after[2] == 1.0
    assert at_once.velocity_after[2] == 0.0


def test_walls_that_meet_one_motion_are_hit_in_the_same_order_to_the_end():
    """After many hits the paces of two walls that are one differ by what rounding has left."""
    rng = np.random.default_rng(0)
    mu, e = np.array([0.2, 0.6, 1.5]), np.array([1.0, 1.0, 0.7])
    for _ in range(20):
        ways = rng.normal(size=(3, 3))
        # The first wall ahead, the other two behind; the rest of W is what moves elsewhere.
        ways[:, 2] = np.abs(ways[:, 2]) * [-1, 1, 1]
        J, u = ways.reshape(9, 1), 9.9 * ways.ravel()
        found = []
        for order in ([0, 1, 2], [2, 1, 0], [1, 2, 0]):
            rows = [3 * i + k for i in order for k in range(3)]
            W = (J @ J.T)[np.ix_(rows, rows)]
            law = Law(slip="path", order="sequential")
            found.append(solved(W, u[rows], e=e[order], mu=mu[order], law=law).status)
        assert len(set(found)) == 1


@pytest.mark.parametrize("law", LAWS, ids=named)
@pytest.mark.parametrize("approach", [1.0, 1e-4, 1e-8, 1e-12])
def test_a_box_that_slides_fast_and_falls_slowly_on_its_corners_comes_to_lie(law, approach):
    """Rounding of its slip is no approach."""
    J, inverse = box()
    rng = np.random.default_rng(3)
    for _ in range(5):
        v = np.r_[3 * rng.normal(size=2), -approach, approach * rng.normal(size=2), 3.0]
        u = J @ v
        solution = solved(J @ inverse @ J.T, u, e=0.0, mu=0.3, law=law)
        assert solution.status is Status.SOLVED
        after = v + inverse @ J.T @ solution.impulse
        assert (J @ after)[2::3].min() >= -1e-12 * np.abs(u).max()


@pytest.mark.parametrize("gap", [0.3, 1e-2, 1e-4])
@pytest.mark.parametrize("e", [0.0, 0.2])
def test_a_geometric_series_of_hits_between_two_contacts_has_the_sum_that_fractions_give(gap, e):
    """W = [[1, c], [c, 1]] with c = gap − 1: each hit drives the other contact back, almost
    as fast, and in the limit none approaches: 0 = u + W P."""
    c = Fraction(gap) - 1
    first, second = Fraction(-1), Fraction(-1, 4)
    det = 1 - c * c
    exact = [(-first + c * second) / det, (c * first - second) / det]
    W, u = normals([[1, float(c)], [float(c), 1]], [-1.0, -0.25])
    solution = solved(W, u, e=e, law=NEWTON)
    assert solution.status is Status.SOLVED
    if e == 0.0 or gap <= 1e-2:
        assert solution.impulse[2::3] == pytest.approx([float(p) for p in exact], rel=1e-9)
        assert np.abs(solution.velocity_after[2::3]).max() <= 1e-12 / gap
    # The work is what the energy lost: ½ (P·u⁻ + P·u⁺).
    work = solution.normal_work.sum()
    assert work == pytest.approx(0.5 * solution.impulse @ (u + solution.velocity_after), rel=1e-9)
