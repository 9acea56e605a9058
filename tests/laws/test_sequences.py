"""Contacts one after the other: to the last digit of their approach, and to the limit."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import impulsekit as ik

from .rows import box_rows, in_own_rows, solved, solved_rows
from .test_several_contacts import along_normals

LAWS = [
    ik.Law("newton", "end", "sequential"),
    ik.Law("poisson", "end", "sequential"),
    ik.Law("newton", "path", "sequential"),
    ik.Law("stronge", "path", "sequential"),
]
NEWTON = LAWS[0]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution} {law.slip}")
WALLS = along_normals([[1.0], [-1.0]])


def test_an_approach_far_slower_than_the_first_is_struck_as_well():
    J = along_normals(np.eye(2))
    after = solved_rows(J, [-1.0, -5e-14], 0.5, law=NEWTON).v_after
    assert after == pytest.approx([0.5, 2.5e-14], rel=1e-12)


@pytest.mark.parametrize(
    ("law", "approach"),
    [
        pytest.param(law, approach, id=f"{law.restitution}-{law.slip}-{approach}")
        for law in LAWS
        for approach in (1.0, 1e-3, 1e-8, 1e-12)
    ],
)  # fmt: skip
def test_a_box_that_slides_fast_and_falls_slowly_comes_to_lie(law, approach):
    """Rounding of its slip is no approach."""
    J, rng = box_rows(), np.random.default_rng(3)
    for _ in range(2):
        v = np.r_[3 * rng.normal(size=2), -approach, approach * rng.normal(size=2), 3.0]
        impact = solved_rows(J, v, 0.0, 0.3, law=law)
        assert impact.is_valid()
        assert (J @ impact.v_after)[2::3].min() >= -1e-12 * np.abs(J @ v).max()


@pytest.mark.parametrize("gap", [0.3, 1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("e", [0.0, 0.2])
def test_a_series_of_hits_has_the_sum_that_fractions_give(gap, e):
    """W = [[1, c], [c, 1]] with c = gap − 1: each hit drives the other contact back, almost
    as fast, and in the limit none approaches: 0 = u + W P."""
    c = Fraction(gap) - 1
    first, second = Fraction(-1), Fraction(-1, 4)
    det = 1 - c * c
    exact = [float((-first + c * second) / det), float((c * first - second) / det)]
    W, u = np.zeros((6, 6)), np.array([0, 0, -1.0, 0, 0, -0.25])
    W[2::3, 2::3] = [[1, float(c)], [float(c), 1]]
    impact, after = solved(W, u, e, law=NEWTON)
    assert impact.is_valid()
    if e == 0.0 or gap <= 1e-2:
        assert in_own_rows(impact)[2::3] == pytest.approx(exact, rel=1e-8)
        assert np.abs(after[2::3]).max() <= 1e-13 / gap


def test_walls_that_give_back_what_they_get_are_hit_without_end():
    assert not solved_rows(WALLS, [-1.0], 1.0, law=NEWTON).is_valid()


@pytest.mark.parametrize("e", [0.5, 0.999])
def test_walls_that_give_back_less_bring_what_is_between_them_to_rest(e):
    """P₁ = 1 + e + (1 + e) e² + …, which is 1/(1 − e); P₂ is e times that."""
    impact = solved_rows(WALLS, [-1.0], e, law=NEWTON)
    assert impact.is_valid() and np.abs(impact.v_after).max() < 1e-12
    assert in_own_rows(impact)[2::3] == pytest.approx([1 / (1 - e), e / (1 - e)], rel=1e-9)
    # All of 1/2 is lost, the first wall's share of it is 1/(1 + e²).
    works = [contact.work for contact in impact.contacts]
    assert works == pytest.approx([-0.5 / (1 + e * e), -0.5 * e * e / (1 + e * e)], rel=1e-9)


@every_law
def test_rounding_at_a_contact_that_nothing_moves_is_no_approach(law):
    """Its parts cannot move against each other: row and velocity are rounding errors."""
    rng = np.random.default_rng(9)
    J, v = rng.normal(size=(6, 6)), rng.normal(size=6)
    J[5] *= 1e-17
    J[2::3] *= -np.sign(J[2::3] @ v)[:, None]
    beside = solved_rows(J, v, 0.3, 0.2, law=law)
    alone = solved_rows(J[:3], v, 0.3, 0.2, law=law)
    assert beside.contacts[0].impulse == pytest.approx(alone.contacts[0].impulse, rel=1e-12)
    assert not beside.contacts[1].impulse.any()


def test_contacts_that_are_alike_are_hit_by_their_order_and_that_is_told():
    """A rod of length 2 and inertia 1/3 falls flat on its ends: one end, then the other."""
    J = along_normals([[1.0, -np.sqrt(3.0)], [1.0, np.sqrt(3.0)]])
    impact = solved_rows(J, [-1.0, 0.0], 0.5, law=NEWTON)
    assert not impact.uniqueness.proven
    for other in impact.uniqueness.others:
        assert other == pytest.approx(impact.v_after * [1, -1], abs=1e-13)
    assert solved_rows(J, [-1.0, 0.0], [0.5, 0.4], law=NEWTON).uniqueness.proven


def test_which_of_equally_fast_contacts_comes_first_is_the_same_in_turned_axes():
    """It is the one whose normal impulse has more effect on its slip."""
    told = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        J, v = rng.normal(size=(6, 6)), rng.normal(size=6)
        J[2::3] /= np.linalg.norm(J[2::3], axis=1)[:, None]
        apart, both = J[2] - J[5], J[2] + J[5]
        # In the directions of both normals equally fast.
        v -= apart * (apart @ v) / (apart @ apart) + both * (both @ v + 1.0) / (both @ both)
        found = []
        for angle in (0.0, *rng.uniform(0.0, 2.0 * np.pi, 2)):
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            rows = np.r_[turn @ J[:2], J[2:3], turn.T @ J[3:5], J[5:]]
            found.append(solved_rows(rows, v, 0.5, 0.4, law=NEWTON))
        for other in found[1:]:
            assert other.v_after == pytest.approx(found[0].v_after, abs=1e-10)
        told.append(found[0].uniqueness.proven)
    assert any(told)


@pytest.mark.parametrize("slip", ["end", "path"])
def test_energy_gained_in_turn_is_not_paid_by_what_lies_apart(slip):
    """Newton's hits may gain where contacts are coupled; what is lost elsewhere hides nothing."""
    law, gained = ik.Law("newton", slip, "sequential"), 0
    for seed in range(25):
        rng = np.random.default_rng(seed)
        part, v = rng.normal(size=(6, 3)), rng.normal(size=3)
        J = np.zeros((9, 6))
        J[:6, :3], J[6:, 3:] = part, 0.2 * np.eye(3)
        alone = solved_rows(part, v, 0.8, 0.8, law=law)
        both = solved_rows(J, [*v, 0, 0, -100.0], [0.8] * 2 + [0.0], [0.8] * 2 + [0.0], law=law)
        assert both.is_valid() == alone.is_valid()
        gained += alone.energy.change > 1e-9
    assert gained >= 1
