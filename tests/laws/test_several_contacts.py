"""Several contacts at once: known answers, contradictions, redundant rows in every writing."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik

from .rows import box_rows, solved_rows, turned

POISSON = ik.Law("poisson")
both_laws = pytest.mark.parametrize("law", [ik.Law(), POISSON], ids=lambda law: law.restitution)


def along_normals(rows):
    """(3n, nv) rows of contacts that only have normals."""
    J = np.zeros((3 * len(rows), np.shape(rows)[1]))
    J[2::3] = rows
    return J


@pytest.mark.parametrize("b", [0.1, 0.3, 0.6, 0.8, 1.2])
@both_laws
def test_housners_block(b, law):
    """ω⁺/ω⁻ = (2h² − b²)/(2(h² + b²)) for b < √2 h, and the pivot lets go; a wide one stops."""
    m, h = 2.0, 0.5
    # Corners at (∓b, −h) of a block that turns about the left one while the right one lands.
    J = np.array([row for x in (-b, b) for row in ([1.0, 0, h], [0.0, 0, 0], [0.0, 1, x])])
    unit = np.sqrt([m, m, m * (b * b + h * h) / 3])
    impact = solved_rows(J / unit, unit * [h, -b, -1.0], 0.0, 20.0, law=law)
    after = impact.v_after / unit
    if b < np.sqrt(2) * h:
        assert -after[2] == pytest.approx((2 * h * h - b * b) / (2 * (h * h + b * b)))
        assert (J @ after)[2] > 0 and np.abs(impact.contacts[0].impulse).max() < 1e-12
    else:
        assert after == pytest.approx(np.zeros(3), abs=1e-12)
    assert impact.is_valid()


def test_opposing_walls_contradict_each_other_under_newtons_law():
    assert not solved_rows(along_normals([[1.0], [-1.0]]), [-1.0], 0.5).is_valid()


def test_opposing_walls_stop_what_is_between_them_under_poissons():
    impact = solved_rows(along_normals([[1.0], [-1.0]]), [-1.0], 0.5, law=POISSON)
    assert impact.is_valid() and abs(impact.v_after[0]) < 1e-14


def test_what_no_impulse_can_stop_has_no_solution():
    """The second contact approaches by what is driven alone."""
    rows = along_normals([[1.0, 0.0], [0.0, 1.0]])
    for law in (ik.Law(), POISSON, ik.Law(order="sequential")):
        assert not solved_rows(rows, [-1.0, -0.5], law=law, kept=1).is_valid()


@pytest.mark.parametrize("seed", range(4))
@both_laws
def test_axes_units_and_order_of_redundant_contacts_are_immaterial(seed, law):
    """Fewer motions than rows, levers of all sizes: the same v⁺ in every writing."""
    rng, compared = np.random.default_rng(seed), 0
    for _ in range(8):
        n = int(rng.integers(1, 6))
        dof = int(rng.integers(1, min(3 * n, 7)))
        J, v = rng.normal(size=(3 * n, dof)), rng.normal(size=dof)
        J *= np.repeat(10.0 ** rng.uniform(-1.0, 1.0, n), 3)[:, None]
        mu, e = rng.choice([0.2, 0.6, 1.0], n), rng.choice([0.0, 0.3, 0.7], n)
        e = e if law is POISSON else np.zeros(n)
        one = solved_rows(J, v, e, mu, law=law)
        if not one.is_valid() or one.uniqueness.several:
            continue
        compared += 1
        for unit in (1.0, 30.0):
            basis = turned(rng, n)
            owner = basis[2::3, 2::3]
            other = solved_rows(unit * basis @ J, v, owner @ e, owner @ mu, law=law)
            assert np.abs(other.v_after - one.v_after).max() < 1e-9 * np.abs(v).max()
    assert compared >= 3


def test_a_gram_squeezed_between_contacts_leaves_none_out_of_touch():
    """Impulses in balance on a light body: rounding of W P is far above what counts as rest."""
    light = 1e-6
    J = along_normals([[1.0, 0, 0], [0, 1 / np.sqrt(light), -1.0], [0.7, -1 / np.sqrt(light), 0]])
    v = np.array([-1.5, 2e-5, 1.0])
    impact = solved_rows(J, v)
    after = [contact.velocity_after[2] for contact in impact.contacts]
    assert impact.is_valid() and min(after) > -1e-9


def test_rounding_of_dependent_rows_does_not_choose_between_two_answers():
    """The last contact parts unless friction wedges it, and it has two motions for three rows."""
    J = np.zeros((9, 6))
    J[0, [0, 1, 3]] = -0.625, 0.281, 3.397
    J[1, [0, 1, 3, 4]] = -0.127, 0.811, 0.268, 2.579
    J[2, [0, 1, 3, 4, 5]] = 0.934, -1.333, -0.263, -0.906, 2.052
    J[5, [2, 5]] = -13.939, 1.0
    J[6:, :2] = (16.809, 0.0), (-4.65, 4.857), (6.413, -3.411)
    v = np.zeros(6)
    v[:2] = 0.0409, -0.0861
    v[2:] = np.linalg.lstsq(J[:6, 2:], [-0.005, 1.239, 1.89, 0, 0, -0.236] - J[:6, :2] @ v[:2])[0]
    rng, shown = np.random.default_rng(84), None
    for _ in range(12):
        near = J * (1.0 + 2e-15 * rng.normal(size=J.shape))
        after = solved_rows(near, v, [1.0, 1.0, 0.0], [1.5, 0.0, 1.5]).v_after
        shown = after if shown is None else shown
        assert after == pytest.approx(shown, abs=1e-12)


def test_poissons_shares_of_unequal_corners_leave_several_velocities():
    """Where e differs, so does what comes back; Newton's law and one e leave one v⁺."""
    J, v = box_rows(), np.sqrt(2.0) * np.array([0, 0, -1.0, 0, 0, 0])
    assert not solved_rows(J, v, [0.2, 0.5, 0.5, 0.8], law=POISSON).uniqueness.proven
    assert not solved_rows(J, v, [0.5] * 4, law=POISSON).uniqueness.several
    assert not solved_rows(J, v, [0.2, 0.5, 0.5, 0.8]).uniqueness.several
