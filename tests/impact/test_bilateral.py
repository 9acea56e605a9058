"""W λ = r for bilateral rows by themselves: rows of zeros, given twice, all but dependent."""

import numpy as np
import pytest

from impulsekit.errors import ContradictionError
from impulsekit.impact import span
from impulsekit.impact.elimination import Elimination
from impulsekit.laws.spanning import span_rows


@pytest.fixture(params=["by the law", "by singular values"], autouse=True)
def by_the_law(request, monkeypatch):
    """Rows are judged by the compiled law where it is clear, and all by singular values."""
    span_rows.compile()
    if request.param != "by the law":
        monkeypatch.setattr(span_rows, "_code", None)
        monkeypatch.setattr(span_rows, "wait", lambda seconds: None)
    return request.param == "by the law"


def solution(half, right, speeds=1.0):
    m = half.shape[1]
    rows = Elimination(half, lambda: np.full(m, 1.0), [f"row {i}" for i in range(m)])
    return rows.solve(right, lambda: np.full(m, speeds))


def rows(seed, nv=6, m=3):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(nv, m)) / np.sqrt(nv), rng


@pytest.mark.parametrize("still", [[1], [0, 3], [3]])
def test_rows_of_zeros_bear_nothing_and_leave_the_others_as_they_are(
    monkeypatch, still, by_the_law
):
    half, rng = rows(0)
    right = rng.normal(size=3)
    alone = solution(half, right)
    if by_the_law:
        monkeypatch.setattr(span, "_by_values", None)
    m = 3 + len(still)
    moving = np.setdiff1d(np.arange(m), still)
    wide, wanted = np.zeros((6, m)), np.zeros(m)
    wide[:, moving], wanted[moving] = half, right
    found = solution(wide, wanted)
    np.testing.assert_array_equal(found.impulse[still], 0.0)
    np.testing.assert_allclose(found.impulse[moving], alone.impulse, rtol=1e-14)
    assert found.rank == 3 and not found.nearly
    np.testing.assert_array_equal(found.unique, ~np.isin(np.arange(m), still))


def test_rows_of_zeros_and_rows_given_twice_share_what_one_bears():
    half, rng = rows(1)
    right = rng.normal(size=3)
    wide = np.column_stack([half, np.zeros(6), half[:, 1]])
    found = solution(wide, np.array([*right, 0.0, right[1]]))
    alone = solution(half, right).impulse
    np.testing.assert_allclose(found.impulse[[0, 2]], alone[[0, 2]], rtol=1e-12)
    np.testing.assert_allclose(found.impulse[[1, 4]], 0.5 * alone[1], rtol=1e-12)
    np.testing.assert_array_equal(found.unique, [True, False, True, False, False])
    assert found.rank == 3 and not found.nearly


def test_all_rows_of_zeros_bear_nothing(capfd):
    found = solution(np.zeros((3, 2)), np.zeros(2))
    assert not found.impulse.any() and not found.unique.any() and found.rank == 0
    # LAPACK is not asked about nothing, which it would complain of.
    assert capfd.readouterr() == ("", "")


def test_a_row_of_zeros_that_shall_move_is_refused():
    half, _ = rows(2)
    wide = np.column_stack([half, np.zeros(6)])
    with pytest.raises(ContradictionError, match="row 3"):
        solution(wide, np.array([0.0, 0.0, 0.0, 1.0]))


def test_rows_all_but_dependent_are_told():
    half, rng = rows(3)
    close = half[:, 0] + 1e-9 * rng.normal(size=6)
    found = solution(np.column_stack([half, np.zeros(6), close]), np.zeros(5))
    assert found.nearly and found.rank == 3


def test_a_row_s_scale_does_not_decide_what_contacts_see():
    """A row written a billion times as small as another holds contacts off all the same."""
    half, rng = rows(3)
    contacts = rng.normal(size=(6, 4))
    basis, _ = np.linalg.qr(half)
    expected = contacts - basis @ (basis.T @ contacts)
    for factors in ([1.0, 1.0, 1.0], [1.0, 1e-12, 1e9]):
        scaled = half * np.array(factors)
        eliminated = Elimination(scaled, lambda s=scaled: (s**2).sum(axis=0), list("abc"))
        np.testing.assert_allclose(eliminated.off_the_span(contacts), expected, atol=1e-13)


def test_contacts_and_impulses_share_one_decision_of_rank():
    """A row within the tolerance of others' span is dependent for λ and for contacts alike."""
    half, rng = rows(4)
    off = np.linalg.qr(np.column_stack([half, rng.normal(size=6)]))[0][:, 3]
    for slant, rank in ((1e-9, 3), (1e-5, 4)):
        near = half @ [1.0, 1.0, 0.0] + slant * off
        eliminated = Elimination(np.column_stack([half, near]), lambda: np.ones(4), list("abcd"))
        assert eliminated.solve(np.zeros(4)).rank == rank
        left = np.linalg.norm(eliminated.off_the_span(off[:, None]))
        assert (left > 0.9) == (rank == 3)


@pytest.mark.parametrize("narrow", [1.0, 1e-2, 1e-4])
@pytest.mark.parametrize("imposed", [0.0, 1.0])
def test_contacts_between_parts_that_are_held_move_as_they_are_held(narrow, imposed):
    # A contact row Σ c_i a_i of bilateral rows a_i moves by Σ c_i times their velocities, and not
    # at all where these stand still, however nearly the rows depend on each other.
    rng = np.random.default_rng(3)
    for _ in range(20):
        held = np.linalg.qr(rng.normal(size=(6, 3)))[0]
        held[:, 2] = held[:, 1] + narrow * held[:, 2]
        shares = rng.normal(size=(3, 3))
        contact = held @ shares
        eliminated = Elimination(held, lambda: np.ones(3), list("abc"))
        speeds = imposed * rng.normal(size=3)
        left = eliminated.off_the_span(contact)
        still = eliminated.still_what_is_held(left, contact)
        assert still.all() and not left.any()
        free = eliminated.velocity_of_held(still, contact, speeds)
        assert np.abs(free - shares.T @ speeds).max() <= 1e-14 * imposed / narrow**2


def test_contacts_that_bilateral_rows_leave_free_stay_as_they_are():
    rng = np.random.default_rng(4)
    held, contact = rng.normal(size=(6, 2)), rng.normal(size=(6, 3))
    eliminated = Elimination(held, lambda: np.ones(2), list("ab"))
    left = eliminated.off_the_span(contact)
    before = left.copy()
    assert not eliminated.still_what_is_held(left, contact).any()
    np.testing.assert_array_equal(left, before)


@pytest.mark.parametrize(("slant", "rank"), [(0.0, 3), (1e-9, 3), (1e-5, 4)])
def test_rows_that_are_left_out_are_those_that_the_rank_lacks(slant, rank):
    half, rng = rows(5)
    off = np.linalg.qr(np.column_stack([half, rng.normal(size=6)]))[0][:, 3]
    near = half @ [1.0, 1.0, 0.0] + slant * off
    wide = np.column_stack([half[:, 0], np.zeros(6), near, half[:, 1:]])
    eliminated = Elimination(wide, None, ())
    left_out = eliminated.left_out()
    assert 1 in left_out and len(left_out) == 5 - rank
    kept = np.delete(wide, left_out, axis=1)
    assert np.linalg.matrix_rank(kept, 1e-7) == rank
    assert eliminated.solve(np.zeros(5)).rank == rank


def test_shares_make_up_what_lies_in_the_span():
    half, rng = rows(6)
    shares = rng.normal(size=(3, 4))
    for wide in (half, np.column_stack([half, half[:, 1]])):
        found = Elimination(wide, None, ()).shares(half @ shares)
        np.testing.assert_allclose(wide @ found, half @ shares, atol=1e-13)
    np.testing.assert_allclose(found[1], found[3], atol=1e-13)
