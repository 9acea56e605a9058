"""One contact in closed form, interpreted and compiled, against all answers in 50 digits."""

import numpy as np
import pytest

from impulsekit.laws.coulomb import bounded_friction, can_press
from impulsekit.laws.quartic import slides
from impulsekit.laws.single import Hit, hit_contact
from impulsekit.laws.status import Status
from impulsekit.laws.words import NEWTON, POISSON
from tests.lawful import all_answers

pytestmark = pytest.mark.filterwarnings("ignore:Descending:DeprecationWarning")
BOTH = [
    lambda *args: Hit(*hit_contact.py_func(*args)),
    lambda *args: Hit(*hit_contact.compile()(*args)),
]
both = pytest.mark.parametrize("run", BOTH, ids=["interpreted", "compiled"])


def block_of(W):
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = np.asarray(W).tolist()
    return t11, t12, t22, n1, n2, nn


def random_problem(rng):
    """W of rank three, stretched along its axes, and u that approaches."""
    rows = rng.normal(size=(3, rng.integers(3, 7))) * np.exp(rng.normal(size=(3, 1)))
    u = rng.normal(size=3) * rng.choice([0.1, 1.0, 10.0], size=3)
    u[2] = -abs(u[2])
    return rows @ rows.T, u, float(10 ** rng.uniform(-1.5, 0.7))


@both
def test_newton_with_one_answer_or_many(run):
    rng = np.random.default_rng(11)
    seen = set()
    for _ in range(120):
        W, u, mu = random_problem(rng)
        e = float(rng.uniform())
        every = np.array(all_answers(W, [u[0], u[1], (1.0 + e) * u[2]], mu)).reshape(-1, 3)
        hit = run(block_of(W), tuple(u), tuple(u), e, mu, 0.0, NEWTON)
        seen.add(len(every))
        assert (hit.status is Status.NO_SOLUTION) == (len(every) == 0)
        assert (hit.status is Status.MANY_SOLUTIONS) == (len(every) > 1)
        if len(every):
            rounding = 1e-13 * np.linalg.cond(W) * np.abs(every).max()
            assert np.abs(every - hit.impulse).max(axis=1).min() <= rounding
            np.testing.assert_allclose(hit.after, u + W @ hit.impulse, atol=1e-12)
            assert hit.residual < 1e-14 + 1e-15 * np.linalg.cond(W)
    assert {1, 3} <= seen


@both
def test_poisson_gives_back_e_times_the_compression_at_least(run):
    rng = np.random.default_rng(12)
    for _ in range(60):
        W, u, mu = random_problem(rng)
        e = float(rng.uniform())
        first = np.array(all_answers(W, u, mu)).reshape(-1, 3)
        hit = run(block_of(W), tuple(u), tuple(u), e, mu, 0.0, POISSON)
        if len(first) != 1 or not hit.status.valid:
            continue
        pressed = first[0]
        back = hit.impulse - pressed
        assert back[2] >= e * pressed[2] * (1.0 - 1e-9)
        assert np.hypot(*back[:2]) <= mu * back[2] * (1.0 + 1e-9)
        after = u + W @ hit.impulse
        slip = np.hypot(*after[:2])
        if slip > 1e-9 * np.abs(u).max():
            np.testing.assert_allclose(
                back[:2], -mu * back[2] * after[:2] / slip, atol=1e-8 * np.abs(hit.impulse).max()
            )
        assert after[2] >= -1e-12 * np.abs(u).max()
        lifted = after[2] > 1e-9 * np.abs(u).max()
        assert not lifted or back[2] == pytest.approx(e * pressed[2], rel=1e-9)


def test_a_contact_that_parts_may_be_drawn_in():
    """All answers with P_n > 0 of a contact that moves away, in 50 digits."""
    rng = np.random.default_rng(13)
    seen = set()
    for _ in range(150):
        W, b, mu = random_problem(rng)
        b, mu = np.array([b[0], b[1], -b[2]]), 4.0 * mu
        every = all_answers(W, b, mu)
        seen.add(len(every) > 0)
        assert can_press(block_of(W), *b.tolist(), mu, float(np.abs(b).max())) == (len(every) > 0)
    assert seen == {True, False}


def test_a_root_at_the_end_of_its_range_is_found():
    """In the plane and with isotropic inertia, the direction of slip is known beforehand."""
    for mu in (0.1, 0.5):
        count, first, *_ = slides((2.0, 0.0, 2.0, 0.0, 0.0, 1.0), 3.0, 4.0, -1.0, mu)
        assert count == 1
        np.testing.assert_allclose(first, (0.6, 0.8), atol=1e-15)
        count, first, *_ = slides((1e5, 0.0, 0.0, -1e3, 0.0, 50.0), 1e4, 0.0, -1.0, mu)
        assert count == 1
        np.testing.assert_allclose(first, (1.0, 0.0), atol=1e-12)


@pytest.mark.parametrize("restitution", [NEWTON, POISSON])
@pytest.mark.parametrize("size", [1e-100, 1e-130, 1e-160, 1e-200, 1e-290])
def test_the_law_knows_no_unit_of_velocity(size, restitution):
    """It is homogeneous: squares of small velocities underflow, and rods stuck that slide."""
    rng = np.random.default_rng(7)
    for k in range(60):
        J = rng.normal(size=(3, 3))
        if k % 2:
            # In a plane.
            J[1] = 0.0
        W = J @ J.T
        block = (W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2])
        u = rng.normal(size=3) * (1.0, 0.0 if k % 2 else 1.0, 1.0)
        u[2] = -abs(u[2])
        e, mu = rng.choice([0.0, 0.5, 1.0]), rng.choice([0.3, 0.8])
        whole, small = (
            Hit(*hit_contact.py_func(block, tuple(v), tuple(v), e, mu, 0.0, restitution))
            for v in (u, size * u)
        )
        assert whole.status is small.status
        np.testing.assert_allclose(np.array(small.impulse) / size, whole.impulse, rtol=1e-9)


@pytest.mark.parametrize("mu", [0.3, 5.0, 1e3, 1e4])
@both
def test_of_a_contact_with_one_way_to_go_on_a_belt_the_slip_is_known(run, mu):
    """W = j jᵀ and slip that j cannot stop: ξ = b − j b_n/j_n, and P_n j·(−µ s, 1) = −b_n/j_n.

    Where that has no P_n > 0, a slip across j would need one of which W P is rounding alone.
    """
    rng = np.random.default_rng(5)
    solved = 0
    for _ in range(300):
        j, b = rng.normal(size=3), rng.normal(size=3)
        b[2] = -abs(b[2])
        xi = b - j * b[2] / j[2]
        s = xi[:2] / np.linalg.norm(xi[:2])
        normal = -b[2] / j[2] / (j[2] - mu * j[:2] @ s)
        W = np.outer(j, j)
        hit = run(block_of(W), tuple(b), tuple(b), 0.0, mu, 0.0, NEWTON)
        if normal > 0.0:
            solved += 1
            assert hit.status in (Status.SOLVED, Status.PAINLEVE_JAM)
            assert hit.impulse == pytest.approx((*(-mu * normal * s), normal), rel=1e-6)
        else:
            assert hit.status is Status.NO_SOLUTION
    assert 50 < solved < 290


@pytest.mark.parametrize("off", [0.0, 1e-3, 1.0])
def test_friction_that_stops_one_way_alone_opposes_other_slip_with_all_it_has(off):
    """Least ½ P_tᵀ W_tt P_t + P_t·b_t within |P_t| ≤ µ P_n, W_tt of rank one: against a scan."""
    rng = np.random.default_rng(6)
    for _ in range(100):
        j, pn = rng.normal(size=3), rng.uniform(0.1, 2.0)
        W = np.outer(j, j)
        b = rng.normal() * j[:2] + off * rng.normal() * np.array((-j[1], j[0]))
        P = np.array(bounded_friction(block_of(W), b[0], b[1], pn, 0.8))
        angles = np.linspace(0.0, 2.0 * np.pi, 20_001)
        edge = 0.8 * pn * np.stack((np.cos(angles), np.sin(angles)))
        c = b + W[:2, 2] * pn

        def cost(p, j=j, c=c):
            return 0.5 * (j[:2] @ p) ** 2 + c @ p

        assert np.linalg.norm(P) <= 0.8 * pn * (1.0 + 1e-12)
        assert cost(P) <= cost(edge).min() + 1e-12
        if off > 0.0:
            assert np.linalg.norm(P) == pytest.approx(0.8 * pn)
