"""The path law, interpreted and compiled, against closed planar solutions and its own rules."""

import numpy as np
import pytest

from impulsekit.laws.path import follow
from impulsekit.laws.progress import P1, P2, RESIDUAL, U1, U2, UN, P, path_memory
from impulsekit.laws.status import Status

from ..impact.contact_space.problems import planar_velocity, rod

LAWS = ("newton", "poisson", "stronge")
BOTH = [np.errstate(all="ignore")(follow.py_func), lambda *args: follow.compile()(*args)]
both = pytest.mark.parametrize("run", BOTH, ids=["interpreted", "compiled"])


def block_of(W):
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = np.asarray(W).tolist()
    return t11, t12, t22, n1, n2, nn


@both
def test_a_rod_in_the_plane(run):
    rng = np.random.default_rng(5)
    memory = path_memory()
    for _ in range(20):
        W = rod(rng.uniform(0.1, 1.5), rng.uniform(0.1, 5))
        u = np.array([rng.normal(), 0.0, -rng.uniform(0.1, 2)])
        e, mu = rng.uniform(0.05, 1), rng.uniform(0.05, 2)
        for number, law in enumerate(LAWS):
            after = planar_velocity(W, u, e, mu, law)
            run(block_of(W), u[2], tuple(u), e, mu, number, memory)
            np.testing.assert_allclose(memory.now[[U1, UN]], after, atol=1e-10 * np.abs(u).max())


@both
@pytest.mark.parametrize("size", [1e-300, 1e-200, 1e-3, 1e200])
def test_velocities_of_any_size(run, size):
    """Impulses grow as velocities do, from far below the doubles' squares to far above."""
    W = [[3.0, 0.4, 0.5], [0.4, 2.0, -0.6], [0.5, -0.6, 1.0]]
    u = (0.3, -1.0, -0.7)
    memory, found = path_memory(), []
    for factor in (1.0, size):
        start = tuple(factor * x for x in u)
        code = run(block_of(W), start[2], start, 0.5, 0.3, 2, memory)
        assert Status(code) is Status.SOLVED
        found.append(memory.now[[P1, P2, P]] / factor)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-13)


@both
@pytest.mark.parametrize("angle", np.linspace(0.0, 3.0, 13))
def test_slip_begins_again_where_one_direction_hardly_moves(run, angle):
    """W_tt of a long thin link, wherever its tangents point: slip stops and starts again."""
    W = np.array(
        [
            [0.0018998673375131775, 0.47723990764817609, 0.21037345692150156],
            [0.47723990764817609, 127.63129413934428, 56.006199408175995],
            [0.21037345692150156, 56.006199408175995, 24.584116466318282],
        ]
    )
    u = np.array([-0.01758120382579193, -3.434783838578993, -1.5464305085552275])
    turn = np.eye(3)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    memory = path_memory()
    code = run(block_of(turn @ W @ turn.T), u[2], tuple(turn @ u), 1.0, 1.5, 2, memory)
    assert Status(code) is Status.SOLVED
    # The work of the compression comes back, and friction takes what slip leaves.
    after = turn.T @ memory.now[[U1, U2, UN]]
    np.testing.assert_allclose(after, [0.0041626, 0.0012564, 0.0349572], atol=2e-7)


@pytest.mark.parametrize("number", range(3), ids=LAWS)
def test_compiled_and_interpreted_are_one_on_blocks_of_any_rank(number):
    """Of any rank, with slip that is nothing or far faster than the approach."""
    rng = np.random.default_rng(3)
    compiled = follow.compile()
    ours, theirs = path_memory(), path_memory()
    for _ in range(60):
        dof = rng.integers(1, 7)
        rows = rng.normal(size=(3, dof)) * np.exp(0.5 * rng.normal(size=(3, 1)))
        rows[1] *= rng.choice([0.0, 1.0], p=[0.2, 0.8])
        u = rows @ rng.normal(size=dof)
        if dof > 2:
            u[:2] *= rng.choice([0.0, 1e-3, 1.0, 10.0])
        u *= -np.sign(u[2])
        e, mu = float(rng.choice([0.0, 1.0, rng.uniform()])), float(10 ** rng.uniform(-2, 1))
        given = block_of(rows @ rows.T), float(u[2]), tuple(u.tolist()), e, mu, number
        with np.errstate(all="ignore"):
            code = follow.py_func(*given, ours)
        assert code == compiled(*given, theirs)
        if Status(code).valid:
            assert ours.now[RESIDUAL] < 1e-9
            assert ours.now[P] >= 0.0
            slip = np.hypot(ours.now[P1], ours.now[P2])
            assert slip <= mu * ours.now[P] * (1.0 + 1e-12)
            apart = (rows @ rows.T) @ (ours.now[[P1, P2, P]] - theirs.now[[P1, P2, P]])
            assert np.abs(apart).max() <= 1e-11 * np.abs(u).max()


def test_a_contact_that_moves_no_inertia_has_no_answer():
    memory = path_memory()
    code = follow.py_func(
        (1.0, 0.0, 1.0, 0.0, 0.0, 0.0), -1.0, (0.5, 0.0, -1.0), 0.5, 0.3, 0, memory
    )
    assert Status(code) is Status.NO_SOLUTION


@both
@pytest.mark.parametrize("number", range(3), ids=LAWS)
@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("slip", [-1.0, 0.0, 1.0])
def test_what_wedges_while_it_approaches_has_no_answer(run, slip, e, number):
    """One speed s moves the contact by (1, 0, 0.1) s; the rest of its approach is driven.

    Once friction holds the slip, nothing changes u_n = -1, however large the impulse.
    """
    way, memory = np.array([1.0, 0.0, 0.1]), path_memory()
    start = slip * way - [0.0, 0.0, 1.0]
    code = run(block_of(np.outer(way, way)), start[2], tuple(start), e, 0.6, number, memory)
    assert Status(code) is Status.NO_SOLUTION
