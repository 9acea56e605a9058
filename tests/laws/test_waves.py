"""Contacts that act through their stiffness: springs followed in time, work regained, wedges."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from benchmarks.stress.bodies import Link, robot_of
from tests.conformance.waves import waves

from .rows import in_own_rows, solved_rows
from .test_several_contacts import along_normals

LZB = ik.Law("lzb")


def springs(rows, v, k, exponent=1.5, e=1.0, end=60.0):
    """v⁺ of unit masses between springs F = k δ^exponent, which unload 1/e² as fast."""
    n, m = len(v), len(k)

    def rates(_, y):
        u, depth = rows @ y[:n], y[n:]
        regains = (u > 0) & (depth > 0)
        force = k * np.maximum(depth, 0.0) ** exponent
        return np.concatenate([rows.T @ force, -u * np.where(regains, 1.0 / e**2, 1.0)])

    exact = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-15}
    rough = {"method": "RK45", "rtol": 1e-9, "atol": 1e-11}
    start = np.concatenate([v, np.zeros(m)])
    return solve_ivp(rates, [0, end], start, **(exact if e == 1.0 else rough)).y[:n, -1]


def chain(masses):
    """Rows and velocities of masses in a row, the first of which comes at 1 m/s."""
    unit, n = np.sqrt(masses), len(masses)
    return (np.eye(n)[1:] - np.eye(n)[:-1]) / unit, np.eye(n)[0] * unit


def packing():
    """Three discs in the plane, each on the two others, and one that falls into their midst."""
    places = np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)], [1.5, np.sqrt(0.75)]])
    rows = []
    for i in range(4):
        for j in range(i):
            way = places[i] - places[j]
            if np.linalg.norm(way) < 1.01:
                rows.append(np.zeros(8))
                rows[-1][2 * i : 2 * i + 2], rows[-1][2 * j : 2 * j + 2] = way, -way
    unit = np.sqrt(np.repeat([1.0, 1.0, 2.0, 1.5], 2))
    return np.array(rows) / unit, unit * [0, 0, 0, 0, 0, 0, -0.6, -1.0]


CASES = {
    "ten equal balls": (*chain(np.ones(10)), np.ones(9)),
    "tapered chain": (*chain(0.7 ** np.arange(6)), 1.5 ** np.arange(5)),
    "packing": (*packing(), np.linspace(1.0, 2.0, 5)),
    "rocking block": (
        np.array([[0.0, 1.0, -0.5], [0.0, 1.0, 0.5]]) / np.sqrt([2.0, 2.0, 0.4]),
        np.array([0.0, -0.5, -1.0]) * np.sqrt([2.0, 2.0, 0.4]), np.array([1.0, 3.0]),
    ),
}  # fmt: skip


@pytest.mark.parametrize("exponent", [1.5, 1.0])
@pytest.mark.parametrize("name", CASES)
def test_without_loss_it_is_the_motion_of_springs(name, exponent):
    rows, v, k = CASES[name]
    law = ik.Law("lzb", exponent=exponent)
    impact = solved_rows(along_normals(rows), v, 1.0, law=law, stiffness=k)
    assert impact.v_after == pytest.approx(springs(rows, v, k, exponent), abs=1e-8)
    assert abs(impact.energy.change) < 1e-10 * impact.energy.before
    assert (rows @ impact.v_after > -1e-9).all() and (in_own_rows(impact) >= 0).all()


def test_losses_follow_two_stiffnesses_and_units_do_not_matter():
    rows, v, k = CASES["packing"]
    impact = solved_rows(along_normals(rows), v, 0.7, law=LZB, stiffness=k)
    assert impact.v_after == pytest.approx(springs(rows, v, k, e=0.7), abs=1e-6)
    other = solved_rows(along_normals(rows), 1e-3 * v, 0.7, law=LZB, stiffness=1e9 * k)
    assert 1e3 * other.v_after == pytest.approx(impact.v_after, abs=1e-10)


@pytest.mark.parametrize("seed", range(3))
def test_several_that_rub_are_as_integrated(seed):
    """Slip that creeps past zero and starts again is among them."""
    rng = np.random.default_rng(seed)
    n = 2
    J, v = rng.normal(size=(3 * n, 3 * n + 2)), rng.normal(size=3 * n + 2)
    J[2::3] *= -np.sign(J[2::3] @ v)[:, None]
    e, mu, k = rng.uniform(0.3, 0.9, n), np.array([0.3, 0.8]), rng.uniform(0.1, 10, n)
    impact = solved_rows(J, v, e, mu, law=LZB, stiffness=k)
    truth = waves(J @ J.T, J @ v, e, mu, k)
    assert in_own_rows(impact) == pytest.approx(truth, abs=1e-8 * np.abs(truth).max())
    assert impact.energy.change < 0.0


@pytest.mark.parametrize("apart", [1e-4, 1e-6])
def test_a_body_that_spins_about_two_near_points_is_followed_to_the_end(apart):
    """Friction that is stiff beside the impact."""
    J = np.vstack(
        [np.hstack([np.eye(3), np.cross(np.eye(3), [x, 0, -0.1])]) for x in (apart / 2, -apart / 2)]
    ) * np.sqrt([1.0, 1.0, 1.0, 150.0, 120.0, 200.0])
    v = np.array([0.03, 0.01, -1.0, 0.1, -0.2, 5.0]) / np.sqrt([1, 1, 1, 150.0, 120, 200])
    impact = solved_rows(J, v, 0.5, 0.7, law=LZB)
    truth = waves(J @ J.T, J @ v, np.full(2, 0.5), np.full(2, 0.7), np.ones(2))
    assert impact.is_valid()
    assert impact.v_after == pytest.approx(v + J.T @ truth, abs=1e-8)


@pytest.mark.parametrize("coupling", [0.0, 1e-7])
def test_what_friction_wedges_without_restitution_ends_where_it_stops(coupling):
    """P_n = |θ̇|/(j_n + µ |j_t|) as slip stops; with restitution its force would stay for ever."""
    ways = np.array([[0.8, 0.0, 0.6], [-0.3, 0.4, 1.0]])
    J, mu, k = np.zeros((6, 2)), np.array([1.0, 3.0]), np.array([1.0, 0.3])
    J[:3, 0], J[3:, 1] = ways
    J[:3, 1] = coupling * ways[0]
    stops = solved_rows(J, [-1.0, -2.0], 0.0, mu, law=LZB, stiffness=k)
    across = np.linalg.norm(ways[:, :2], axis=1)
    expected = np.array([1.0, 2.0]) / (ways[:, 2] + mu * across)
    assert stops.is_valid() and np.abs(stops.v_after).max() < 1e-9 + coupling
    assert in_own_rows(stops)[2::3] == pytest.approx(expected, rel=1e-9 + 3.0 * coupling)
    for e in ([0.5, 0.5], [0.0, 0.5]):
        assert not solved_rows(J, [-1.0, -2.0], e, mu, law=LZB, stiffness=k).is_valid()
    # Out of the cone it is thrown back.
    slippery = solved_rows(J, [-1.0, -2.0], 0.5, 0.1 * mu, law=LZB, stiffness=k)
    assert slippery.is_valid() and ((J @ slippery.v_after)[2::3] > 0.1).all()


def test_a_support_that_parts_and_is_met_again_is_refused():
    """The spring at one end turns the box until the other end, which parted, comes down."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    spring = ik.Contact("box", at=[-0.2, 0, -0.1], stiffness=1.0, restitution=0.5)
    support = ik.Contact("box", at=[0.2, 0, -0.1], stiffness=np.inf, restitution=0.5)
    scene = ik.Scene(box, contacts=[spring, support], law=LZB)
    v = np.array([0, 0, -0.23, 0, -3.7, 0])
    with pytest.raises(ik.errors.InputError, match=r"contact 1 .* met again at .* m/s"):
        ik.solve(scene, box.neutral(), v)
    assert not ik.solve_batch(scene, box.neutral()[None], v).valid[0]


def test_a_change_between_neighbouring_times_ends_its_search():
    """Steps of a wave may come down to two neighbouring doubles; their middle is one of them."""
    rng = np.random.default_rng(18)
    size, mass = rng.uniform(0.1, 1.0, 3), 10.0 ** rng.uniform(-1.0, 1.0)
    box = robot_of([Link(-1, mass, tuple(size))], "freeflyer")

    def contact():
        corner = [*(rng.choice([-0.5, 0.5], 2) * size[:2]), -0.5 * size[2]]
        at = corner if rng.random() < 0.5 else rng.uniform(-0.5, 0.5, 3) * size
        normal = [0, 0, 1] if rng.random() < 0.7 else rng.normal(size=3)
        e, mu = rng.choice([0, 0.3, 0.5, 0.8, 1]), rng.choice([0, 0.2, 0.5, 1, 2.0])
        return ik.Contact(
            "link_0", at=list(at), normal=list(normal), restitution=float(e), friction=float(mu),
            stiffness=float(10.0 ** rng.uniform(2.0, 6.0)),
        )  # fmt: skip

    contacts = [contact() for _ in range(rng.choice([2, 3, 4, 6]))]
    v = rng.normal(size=6)
    v[2] = -abs(v[2])
    impact = ik.solve(ik.Scene(box, contacts=contacts, law=LZB), box.neutral(), v)
    assert impact.status in (ik.Status.SOLVED, ik.Status.NOT_CONVERGED)
    assert impact.residuals.momentum < 1e-12
