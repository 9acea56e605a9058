"""Several contacts with friction at once."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from impulsekit.errors import InputError
from impulsekit.laws.approach import sweep
from impulsekit.laws.status import Status
from impulsekit.scene.law import Law

from .posed import posed
from .problems import box, rod, solved

POISSON = Law(restitution="poisson")


@pytest.mark.parametrize("b", [0.1, 0.3, 0.6, 0.8, 1.2])
@pytest.mark.parametrize("law", [Law(), POISSON], ids=lambda law: law.restitution)
def test_housners_block(b, law):
    """ω⁺/ω⁻ = (2h² − b²)/(2(h² + b²)) for b < √2 h, and the pivot lets go; a wide one stops."""
    m, h = 2.0, 0.5
    # Corners at (∓b, −h) of a block that turns about the left one while the right one lands.
    J = np.array([row for x in (-b, b) for row in ([1.0, 0, h], [0.0, 0, 0], [0.0, 1, x])])
    M = np.diag([m, m, m * (b * b + h * h) / 3])
    v = np.array([h, -b, -1.0])
    answer = solved(J @ np.linalg.solve(M, J.T), J @ v, 0.0, 20.0, law=law)
    after = v + np.linalg.solve(M, J.T @ answer.impulse)
    if b < np.sqrt(2) * h:
        assert after[2] / v[2] == pytest.approx((2 * h * h - b * b) / (2 * (h * h + b * b)))
        assert (J @ after)[2] > 0
        assert np.abs(answer.impulse[:3]).max() < 1e-12
    else:
        np.testing.assert_allclose(after, 0, atol=1e-12)
    assert answer.status.valid and answer.residual <= 1e-10


@pytest.mark.parametrize("law", [Law(), POISSON], ids=lambda law: law.restitution)
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_box_on_four_corners(law, e):
    """12 rows of rank 6: the resultant is unique, the corners are not."""
    m = 2.0
    J, inverse = box(m=m)
    W = J @ inverse @ J.T
    assert np.linalg.matrix_rank(W) == 6
    v = np.array([0.3, 0.0, -1.0, 0, 0, 0])
    for mu in (0.05, 0.9):
        answer = solved(W, J @ v, e, mu, law=law)
        assert answer.status is Status.SOLVED and not answer.unique.any()
        assert answer.residual <= 1e-10
        P = answer.impulse.reshape(4, 3)
        after = v + inverse @ J.T @ answer.impulse
        # Corners in front and at the back, left and right: mirrored.
        np.testing.assert_allclose(P[[0, 2], 0], P[[1, 3], 0], atol=1e-6)
        np.testing.assert_allclose(P[[0, 2], 2], P[[1, 3], 2], atol=1e-6)
        np.testing.assert_allclose(after[[1, 3, 5]], 0, atol=1e-10)
        if mu < 0.1:
            np.testing.assert_allclose(P[:, 0], -mu * P[:, 2], atol=1e-10)
    straight = solved(W, np.tile([0.0, 0, -1], 4), e, 0.5, law=law)
    after = inverse @ J.T @ straight.impulse
    np.testing.assert_allclose(after, [0, 0, (1 + e) * 1.0, 0, 0, 0], atol=1e-10)


def test_each_contact_has_its_own_restitution():
    """Two spheres side by side know nothing of each other."""
    W = np.kron(np.eye(2), np.diag([3.5, 3.5, 1.0]))
    answer = solved(W, [1, 0, -1, 0, 1, -2], [0.2, 0.9], [0.1, 0.9])
    np.testing.assert_allclose(answer.velocity_after[2::3], [0.2, 1.8], atol=1e-12)
    np.testing.assert_allclose(answer.velocity_after[[0, 3, 4]], [1 - 0.42, 0, 0], atol=1e-12)
    assert answer.status is Status.SOLVED


def test_joint_stops_among_frictional_contacts():
    """Tangent rows without friction are not used, whatever stands in them."""
    W = np.zeros((6, 6))
    W[:3, :3] = rod(0.6)
    W[5, 5] = 2.0
    W[5, 2] = W[2, 5] = 0.3
    u = np.array([1.0, 0, -1, 7, 7, -1])
    clean = solved(W, u, 0.4, [0.3, 0.0])
    W[3, 3], W[3, 0], W[0, 3] = 5.0, 1.0, 1.0
    dirty = solved(W, u, 0.4, [0.3, 0.0])
    np.testing.assert_allclose(dirty.impulse, clean.impulse, atol=1e-14)
    assert not dirty.impulse[3:5].any()


def modes_in_plane(W, b, mu):
    """All P of planar contacts, by trying parting, sticking and both slips everywhere."""
    n = len(b) // 2
    found = []
    for modes in product(["part", "stick", "left", "right"], repeat=n):
        A, r = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
        for i, mode in enumerate(modes):
            t, k = 2 * i, 2 * i + 1
            if mode == "part":
                A[t, t] = A[k, k] = 1
                continue
            A[k], r[k] = W[k], -b[k]
            if mode == "stick":
                A[t], r[t] = W[t], -b[t]
            else:
                A[t, t], A[t, k] = 1, -mu[i] if mode == "left" else mu[i]
        try:
            P = np.linalg.solve(A, r)
        except np.linalg.LinAlgError:
            continue
        xi = W @ P + b
        fits = (P[1::2] >= -1e-10).all() and (xi[1::2] >= -1e-10).all()
        for i, mode in enumerate(modes):
            t = 2 * i
            fits &= abs(P[t]) <= mu[i] * P[t + 1] + 1e-10
            fits &= not (mode == "left" and xi[t] > 1e-10)
            fits &= not (mode == "right" and xi[t] < -1e-10)
        if fits:
            found.append(P)
    return found


@pytest.mark.slow
@given(st.integers(0, 10**6), st.integers(2, 4))
@settings(max_examples=150, deadline=None)
def test_against_every_mode_in_the_plane(seed, n):
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(2 * n, 2 * n + 1))
    mu, e = rng.uniform(0, 0.8, size=n), rng.uniform(size=n)
    u = J @ rng.normal(size=2 * n + 1)
    b = u.copy()
    b[1::2] += e * np.minimum(u[1::2], 0)
    rows = np.sort(np.r_[3 * np.arange(n), 3 * np.arange(n) + 2])
    W, before = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    W[np.ix_(rows, rows)], before[rows] = J @ J.T, u
    answer = solved(W, before, e, mu)
    truths = modes_in_plane(J @ J.T, b, mu)
    assert truths
    if answer.status is Status.NOT_CONVERGED:
        pytest.fail("not converged")
    size = 1 + np.abs(answer.impulse).max()
    assert min(np.abs(answer.impulse[rows] - P).max() for P in truths) < 1e-7 * size


@pytest.mark.slow
@given(st.integers(0, 10**6), st.integers(2, 6))
@settings(max_examples=150, deadline=None)
def test_order_and_scale_are_immaterial(seed, n):
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(3 * n, 3 * n + 2))
    u, mu, e = J @ rng.normal(size=3 * n + 2), rng.uniform(0, 0.5, size=n), rng.uniform(size=n)
    W = J @ J.T
    answer = solved(W, u, e, mu)
    order = rng.permutation(n)
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    other = solved(W[np.ix_(rows, rows)], u[rows], e[order], mu[order])
    size = np.abs(answer.impulse).max(initial=1e-300)
    np.testing.assert_allclose(other.impulse, answer.impulse[rows], atol=1e-7 * size)
    faster = solved(W, 100 * u, e, mu)
    np.testing.assert_allclose(faster.impulse, 100 * answer.impulse, atol=1e-5 * size)
    heavier = solved(W / 1e4, u, e, mu)
    np.testing.assert_allclose(heavier.impulse, 1e4 * answer.impulse, atol=1e-3 * size)


def test_contact_after_contact_comes_to_the_same():
    rng = np.random.default_rng(5)
    J = rng.normal(size=(9, 12))
    u = J @ rng.normal(size=12)
    mu = np.array([0.2, 0.5, 0.0])
    answer = solved(J @ J.T, u, 0.0, mu)
    work, n, _ = posed(J @ J.T, u, mu)
    sweep(work, n, 1.0, 1000)
    np.testing.assert_allclose(work.P, answer.impulse, atol=1e-9)


def test_frictional_contacts_that_act_on_each_other_are_refused_along_the_path():
    W = np.kron([[1.0, 0.1], [0.1, 1.0]], np.diag([3.5, 3.5, 1.0]))
    for restitution in ("newton", "poisson", "stronge"):
        law = Law(restitution, "path")
        with pytest.raises(InputError, match='order="sequential"'):
            solved(W, [1, 0, -1, 0, 1, -2], 0.2, 0.3, law=law)
        alone = solved(W, [1, 0, -1, 0, 1, 2], 0.2, 0.3, law=law)
        assert alone.status is Status.SOLVED and not alone.impulse[3:].any()
    smooth = solved(W, [1, 0, -1, 0, 1, -2], 0.2, law=Law("newton", "path"))
    np.testing.assert_allclose(smooth.velocity_after[2::3], [0.2, 0.4], atol=1e-15)
    with pytest.raises(InputError, match="tangential"):
        solved(W, [1, 0, -1, 0, 1, -2], 0.2, 0.3, 0.5, law=POISSON)
