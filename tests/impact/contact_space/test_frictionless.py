"""Contacts without friction: known answers, every active set, redundant contacts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from impulsekit.laws.frictionless import frictionless
from impulsekit.laws.modes import DEPENDENT
from impulsekit.laws.status import Status
from impulsekit.laws.workspace import workspace
from impulsekit.scene.law import Law
from tests.lawful import enumerated_normals

from .problems import box, normals, rod, solved


def pushed(A, c, scale):
    """P of 0 ≤ P ⊥ A P + c ≥ 0, and the code."""
    n = len(c)
    work, (W, b) = workspace(n), normals(A, c)
    code, _ = frictionless(work, W, b, n, scale, 0.0, DEPENDENT, False)
    return work.P[2::3], code


@pytest.mark.parametrize("e", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("theta", np.linspace(0.01, 1.57, 9))
@pytest.mark.parametrize(
    "law", [Law(), Law("poisson")], ids=lambda law: f"{law.restitution}-{law.slip}"
)
def test_a_falling_rod(e, theta, law):
    """P = (1 + e) m v / (1 + 3 cos²θ)."""
    m, v = 1.3, 2.1
    answer = solved(rod(theta, m), [0, 0, -v], e, law=law)
    expected = (1 + e) * m * v / (1 + 3 * np.cos(theta) ** 2)
    assert abs(answer.impulse[2] / expected - 1) < 1e-13
    assert answer.status is Status.SOLVED


def test_three_balls():
    J = np.array([[-1.0, 1, 0], [0, -1, 1]])
    v = np.array([1.0, 0, 0])
    W, u = normals(J @ J.T, J @ v)
    together = solved(W, u, 1.0)
    np.testing.assert_allclose(v + J.T @ together.impulse[2::3], [-1 / 3, 2 / 3, 2 / 3], atol=1e-15)
    in_turn = solved(W, u, 1.0, law=Law(order="sequential"))
    np.testing.assert_allclose(v + J.T @ in_turn.impulse[2::3], [0, 0, 1], atol=1e-15)


def test_a_box_on_four_corners_without_friction():
    J, inverse = box()
    W = J @ inverse @ J.T
    answer = solved(W, np.tile([0.4, 0, -1.0], 4), 0.5)
    np.testing.assert_allclose(answer.impulse[2::3], 2.0 * 1.5 / 4, rtol=1e-13)
    assert answer.status is Status.NOT_UNIQUE
    assert not answer.unique.any()


def test_a_contact_that_parts_gets_nothing():
    W, u = normals(np.array([[2.0, -1], [-1, 2]]), [-1.0, 0.5])
    answer = solved(W, u, 1.0)
    np.testing.assert_allclose(answer.velocity_after[2::3], [1.0, 0.0], atol=1e-15)
    W, u = normals(np.array([[2.0, 1], [1, 2]]), [-1.0, 0.5])
    answer = solved(W, u, 1.0)
    assert answer.impulse[5] == 0


def test_opposing_contacts_that_contradict_each_other():
    """Between two walls, both touching, Newton has no answer; Poisson has one."""
    W, u = normals(np.array([[1.0, -1], [-1, 1]]), [-1.0, 1.0])
    assert solved(W, u, 0.5).status is Status.NO_SOLUTION
    poisson = solved(W, u, 0.5, law=Law("poisson"))
    assert poisson.status.valid
    np.testing.assert_allclose(poisson.velocity_after, 0, atol=1e-15)


def test_a_sequence_without_end():
    """Between two walls, both touching and both elastic, the blows never end."""
    W, u = normals(np.array([[1.0, -1], [-1, 1]]), [-1.0, 1.0])
    endless = solved(W, u, 1.0, law=Law(order="sequential"))
    assert endless.status is Status.SEQUENCE_TOO_LONG and not endless.status.valid
    lossy = solved(W, u, 0.5, law=Law(order="sequential"))
    assert lossy.status is Status.SOLVED
    np.testing.assert_allclose(lossy.velocity_after, 0, atol=1e-12)


@pytest.mark.parametrize("n", [3, 5])
def test_newtons_cradle(n):
    J = np.eye(n - 1, n, 1) - np.eye(n - 1, n)
    v = np.zeros(n)
    v[0] = 1.0
    W, u = normals(J @ J.T, J @ v)
    answer = solved(W, u, 1.0, law=Law(order="sequential"))
    np.testing.assert_allclose((v + J.T @ answer.impulse[2::3])[-1], 1.0, atol=1e-15)
    together = solved(W, u, 1.0)
    assert together.normal_work.sum() == pytest.approx(0, abs=1e-14)
    assert together.status is Status.SOLVED


@pytest.mark.parametrize("restitution", ["newton", "poisson"])
def test_elastic_hits_one_after_the_other_gain_nothing_by_rounding(restitution):
    rng = np.random.default_rng(2)
    for _ in range(60):
        J = rng.normal(size=(3, 4))
        W, u = normals(J @ J.T, -rng.uniform(0.1, 1, 3))
        answer = solved(W, u, 1.0, law=Law(restitution, order="sequential"))
        assert answer.status in (Status.SOLVED, Status.SEQUENCE_TOO_LONG)


@pytest.mark.slow
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 7))
@settings(max_examples=300, deadline=None)
def test_against_every_active_set(seed, n, dof):
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(n, dof))
    if n > 2 and seed % 2:
        J[1] = J[0]
    W = J @ J.T
    un = J @ rng.normal(size=dof)
    b = un + (0.5 * np.minimum(un, 0) if dof > n + 1 and not (n > 2 and seed % 2) else 0)
    found, code = pushed(W, b, np.abs(b).max())
    truth = enumerated_normals(W, b)
    assert code in (Status.SOLVED, Status.NOT_UNIQUE)
    size = np.abs(b).max() + (np.diag(W) * found).max()
    np.testing.assert_allclose(W @ found, W @ truth, atol=1e-8 * size)
    xi = W @ found + b
    assert found.min() >= 0
    assert np.abs(np.minimum(xi, np.diag(W) * found)).max() <= 1e-10 * size
    # The order of contacts is immaterial.
    order = rng.permutation(n)
    other, _ = pushed(W[np.ix_(order, order)], b[order], np.abs(b).max())
    np.testing.assert_allclose(other, found[order], atol=1e-6 * (1e-300 + found.max()))


def test_a_gram_squeezed_between_contacts_leaves_no_contact_out_of_touch():
    # Impulses in balance on a light body: rounding of W P is far above what counts as rest.
    delassus = np.array(
        [
            [2.5576205908960388, 1.822562982048173, -1.1241144223447022],
            [1.822562982048173, 17751037.678722646, -257495910.7026574],
            [-1.1241144223447022, -257495910.7026574, 3735226664.4309716],
        ]
    )
    shifted = np.array([-1.488014349127791, -2.1898569569983253, 0.48976119914600336])
    impulse, code = pushed(delassus, shifted, 1.488014349127791)
    assert code != Status.NO_SOLUTION
    assert (impulse >= 0.0).all()
    velocity = delassus @ impulse + shifted
    shares = np.abs(delassus) @ impulse
    assert (velocity >= -1e-14 * shares - 1e-12).all()
    pushing = impulse > 0.0
    assert (np.abs(velocity[pushing]) <= 1e-14 * shares[pushing] + 1e-12).all()


def test_four_feet_of_a_table_share_the_least_there_is_to_share():
    """Four feet of a rigid table have three velocities between them."""
    J = np.array([[1.0, x, y] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    # Straight down: every foot a quarter.
    P, code = pushed(J @ J.T, J @ np.array([-4.0, 0.0, 0.0]), 4.0)
    np.testing.assert_allclose(P, 1.0, rtol=1e-13)
    assert code == Status.NOT_UNIQUE
    # All load on one diagonal is the same motion as all load on the other: the least is even.
    W, b = normals(J @ J.T, -J @ J.T @ np.array([0.0, 2.0, 2.0, 0.0]))
    answer = solved(W, b, 0.0)
    np.testing.assert_allclose(answer.impulse[2::3], 1.0, rtol=1e-13)
    assert answer.status is Status.NOT_UNIQUE and not answer.unique.any()
    # On one foot alone nothing can be shifted, however many touch.
    W, b = normals(J @ J.T, -J @ J.T @ np.array([3.0, 0.0, 0.0, 0.0]))
    answer = solved(W, b, 0.0)
    np.testing.assert_allclose(answer.impulse[2::3], [3.0, 0.0, 0.0, 0.0], atol=1e-13)
    assert answer.status is Status.SOLVED
    # On one edge: two feet on a line, which the others would turn.
    W, b = normals(J @ J.T, -J @ J.T @ np.array([3.0, 1.0, 0.0, 0.0]))
    answer = solved(W, b, 0.0)
    np.testing.assert_allclose(answer.impulse[2::3], [3.0, 1.0, 0.0, 0.0], atol=1e-13)
    assert answer.status is Status.SOLVED


@pytest.mark.parametrize("seed", range(25))
def test_redundant_contacts_share_the_least_and_who_can_carry_more_is_told(seed):
    """Against scipy: least distance by nonnegative least squares, and linear programs."""
    from scipy.optimize import linprog, nnls

    rng = np.random.default_rng(seed)
    n, dof = int(rng.integers(3, 7)), int(rng.integers(1, 3))
    J = np.abs(rng.normal(size=(n, dof)))
    load = rng.uniform(0.1, 1.0, n) * (rng.uniform(size=n) < 0.5)
    load[0] = 1.0
    W, b = normals(J @ J.T, -J @ J.T @ load)
    answer = solved(W, b, 0.0)
    target, size = J.T @ load, np.abs(J).max()
    # min |P| over P ≥ 0 with Jᵀ P = target, as a penalty made stiff.
    rows = np.vstack([J.T * 1e7, np.eye(n)])
    least, _ = nnls(rows, np.r_[target * 1e7, np.zeros(n)])
    np.testing.assert_allclose(answer.impulse[2::3], least, atol=1e-6 * size)
    spread = []
    for i in range(n):
        cost = np.eye(n)[i]
        low = linprog(cost, A_eq=J.T, b_eq=target).fun
        spread.append(-linprog(-cost, A_eq=J.T, b_eq=target).fun - low)
    free = np.array(spread) > 1e-7
    assert (answer.status is Status.NOT_UNIQUE) == free.any()
    if free.any():
        np.testing.assert_array_equal(answer.unique, ~free)
