"""Contacts without friction: known answers, every active set, redundant contacts."""

import numpy as np
import pytest

from impulsekit.laws.frictionless import frictionless
from impulsekit.laws.modes import DEPENDENT
from impulsekit.laws.status import Status
from impulsekit.laws.workspace import workspace
from impulsekit.scene.law import Law

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


def test_a_contact_that_parts_gets_nothing():
    W, u = normals(np.array([[2.0, -1], [-1, 2]]), [-1.0, 0.5])
    answer = solved(W, u, 1.0)
    np.testing.assert_allclose(answer.velocity_after[2::3], [1.0, 0.0], atol=1e-15)
    W, u = normals(np.array([[2.0, 1], [1, 2]]), [-1.0, 0.5])
    answer = solved(W, u, 1.0)
    assert answer.impulse[5] == 0


def test_a_sequence_without_end():
    """Between two walls, both touching and both elastic, the blows never end."""
    W, u = normals(np.array([[1.0, -1], [-1, 1]]), [-1.0, 1.0])
    endless = solved(W, u, 1.0, law=Law(order="sequential"))
    assert endless.status is Status.NOT_CONVERGED and not endless.status.valid
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
        assert answer.status in (Status.SOLVED, Status.NOT_CONVERGED)


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


def test_a_box_on_four_corners_without_friction():
    J, inverse = box()
    W = J @ inverse @ J.T
    answer = solved(W, np.tile([0.4, 0, -1.0], 4), 0.5)
    np.testing.assert_allclose(answer.impulse[2::3], 2.0 * 1.5 / 4, rtol=1e-9)
    assert answer.status is Status.SOLVED
    assert not answer.unique.any()
