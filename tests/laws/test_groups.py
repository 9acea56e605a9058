"""Contacts that W does not couple are groups, each solved as if the others were not there."""

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.sparse.csgraph import connected_components

from impulsekit.laws.at_once import Struck, hit_contacts
from impulsekit.laws.groups import (
    UNCOUPLED,
    few_of,
    find_groups,
    line_of,
    members_of,
    square_of,
    worse,
)
from impulsekit.laws.single import Hit, hit_contact
from impulsekit.laws.status import Status
from impulsekit.laws.words import NEWTON, POISSON


def groups(W, mu):
    n = len(mu)
    group, queue = np.zeros(n, np.int64), np.zeros(n, np.int64)
    count = find_groups.py_func(W, np.asarray(mu, float), n, group, queue)
    return count, group.tolist()


def coupled(rng, n):
    """A body of its own: W and the velocities of n of its contacts, most of which approach."""
    J = rng.normal(size=(3 * n, 3 * n + 2))
    velocity = rng.normal(size=3 * n)
    velocity[2::3] -= 1.0
    return J @ J.T, velocity


@pytest.mark.parametrize("seed", range(30))
def test_groups_are_the_connected_parts_of_the_coupling(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    links = np.triu(rng.random((n, n)) < 1.0 / n, 1)
    links = links | links.T
    W = np.kron(links * 0.01, np.eye(3)) + np.eye(3 * n)
    count, group = groups(W, rng.random(n))
    expected, labels = connected_components(links)
    assert count == expected
    assert group == labels.tolist()


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_rounding_couples_nothing(share):
    W = np.diag([4.0, 4.0, 4.0, 9.0, 9.0, 9.0])
    W[2, 5] = W[5, 2] = share * UNCOUPLED * 6.0
    assert groups(W, [0.3, 0.3])[0] == (1 if share > 1.0 else 2)


def test_tangents_couple_only_where_they_rub():
    W = np.eye(6)
    W[0, 5] = W[5, 0] = 0.5
    assert groups(W, [0.0, 0.0])[0] == 2
    assert groups(W, [0.0, 0.3])[0] == 2
    assert groups(W, [0.3, 0.0])[0] == 1


def test_parts_are_those_of_the_contacts_chosen():
    rng = np.random.default_rng(3)
    W, u, few = rng.normal(size=(9, 9)), rng.normal(size=9), rng.normal(size=3)
    chosen = np.zeros(3, np.int64)
    count = members_of(np.array([0, 1, 0]), 3, 0, chosen)
    assert (count, chosen[:2].tolist()) == (2, [0, 2])
    rows = [0, 1, 2, 6, 7, 8]
    np.testing.assert_array_equal(square_of(W, chosen, 2), W[np.ix_(rows, rows)])
    np.testing.assert_array_equal(line_of(u, chosen, 2), u[rows])
    np.testing.assert_array_equal(few_of(few, chosen, 2), few[[0, 2]])


def test_of_all_the_worst_status_is_told():
    order = [Status.SOLVED, Status.NOT_UNIQUE, Status.PAINLEVE_JAM, Status.MANY_SOLUTIONS]
    order += [Status.ENERGY_GAIN, Status.NOT_CONVERGED, Status.NO_SOLUTION, Status.REFUSED]
    for k, better in enumerate(order):
        for other in order[k:]:
            assert worse(int(better), int(other)) == worse(int(other), int(better)) == other


@pytest.mark.parametrize("restitution", [NEWTON, POISSON])
@pytest.mark.parametrize("seed", range(20))
def test_a_contact_does_what_it_does_alone(seed, restitution):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 4, size=int(rng.integers(2, 5)))
    parts = [coupled(rng, int(n)) for n in sizes]
    mu, e = rng.choice([0.0, 0.4, 1.0], size=sizes.sum()), rng.random(sizes.sum())
    order = rng.permutation(sizes.sum())
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    W = block_diag(*(part[0] for part in parts))[np.ix_(rows, rows)]
    u = np.concatenate([part[1] for part in parts])[rows]
    none = np.zeros(len(mu))
    hit = Struck(*hit_contacts(W, u, u, mu[order], e[order], none, restitution))
    first, codes = 0, []
    for (W_own, u_own), n in zip(parts, sizes, strict=True):
        own = slice(first, first + n)
        # In the order in which the scene has them.
        there = order[(order >= first) & (order < first + n)]
        local = (3 * (there - first)[:, None] + np.arange(3)).ravel()
        lone = Struck(
            *hit_contacts(
                W_own[np.ix_(local, local)], u_own[local], u_own[local], mu[there], e[there],
                np.zeros(n), restitution,
            )
        )  # fmt: skip
        places = np.flatnonzero((order >= first) & (order < first + n))
        shown = (3 * places[:, None] + np.arange(3)).ravel()
        np.testing.assert_array_equal(hit.impulse[shown], lone.impulse)
        np.testing.assert_allclose(hit.after[shown], lone.after, rtol=0, atol=1e-14)
        np.testing.assert_array_equal(hit.normal_work[places], lone.normal_work)
        np.testing.assert_array_equal(hit.unique[places], lone.unique)
        codes.append(lone.status)
        first = own.stop
    assert hit.status in codes


def test_a_lone_contact_has_its_closed_form():
    W = np.eye(6)
    u = np.array([1.0, 0.0, -1.0, 0.3, 0.4, -2.0])
    mu, e = np.array([0.3, 0.8]), np.array([0.5, 0.2])
    hit = Struck(*hit_contacts(W, u, u, mu, e, np.zeros(2), NEWTON))
    for i in range(2):
        own = slice(3 * i, 3 * i + 3)
        alone = Hit(
            *hit_contact(
                (1.0, 0.0, 1.0, 0.0, 0.0, 1.0), tuple(u[own]), tuple(u[own]), e[i], mu[i], 0.0,
                NEWTON,
            )
        )  # fmt: skip
        assert hit.impulse[own].tolist() == list(alone.impulse)
        assert hit.after[own].tolist() == list(alone.after)


def test_a_tangent_without_friction_is_moved_by_another_groups_normal():
    """Two smooth walls at right angles: what one pushes is the other's slip."""
    W = np.eye(6)
    W[0, 5] = W[5, 0] = 1.0  # the first one's tangent is the second one's normal
    W[2, 3] = W[3, 2] = 1.0
    u = np.array([-2.0, 0.0, -1.0, -1.0, 0.0, -2.0])
    none = np.zeros(2)
    hit = Struck(*hit_contacts(W, u, u, none, none, none, NEWTON))
    assert hit.status is Status.SOLVED
    np.testing.assert_array_equal(hit.impulse, [0, 0, 1, 0, 0, 2])
    np.testing.assert_array_equal(hit.after, np.zeros(6))
