"""Impulses by stored energy against springs followed in time, and against their own statement."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from impulsekit.impact.contact_law import ContactProblem, solve_contacts
from impulsekit.laws import lzb
from impulsekit.laws.lzb import Waved, strike_by_energy
from impulsekit.laws.path import follow
from impulsekit.laws.progress import path_memory
from impulsekit.laws.status import Status
from impulsekit.laws.words import STRONGE
from tests.reference.models import mass_matrix
from tests.truths.space_paths import Spatial, space_error

LZB = ik.Law(restitution="lzb")


def springs(masses, rows, v, k, exponent=1.5, end=60.0):
    """v⁺ of masses between springs F = k δ^exponent along ``rows``, in displacements and time."""
    n = len(v)
    inverse = np.linalg.inv(masses)

    def rates(t, y):
        depth = np.maximum(-(rows @ y[:n]), 0.0)
        return np.concatenate([y[n:], inverse @ (rows.T @ (k * depth**exponent))])

    way = solve_ivp(
        rates, [0, end], np.concatenate([np.zeros(n), v]), method="DOP853", rtol=1e-12, atol=1e-15
    )
    assert (rows @ way.y[:n, -1] <= 0).sum() == 0 or np.abs(rows @ way.y[n:, -1]).max() < 1e-9
    return way.y[n:, -1]


def along_normals(masses, rows, v, k, e=1.0, exponent=1.5, mu=0.0):
    """v⁺ by the law, the rows being normals."""
    n = len(rows)
    full = np.zeros((3 * n, len(v)))
    full[2::3] = rows
    W = full @ np.linalg.solve(masses, full.T)
    u = full @ v
    es, mus = np.full(n, e), np.full(n, mu)
    problem = ContactProblem(W, u, u, es, mus, np.zeros(n), np.array(k, dtype=float))
    found = solve_contacts(problem, ik.Law("lzb", exponent=exponent))
    assert found.status is ik.Status.SOLVED
    return v + np.linalg.solve(masses, full.T @ found.impulse), found


def chain(masses):
    n = len(masses)
    return np.diag(masses), np.eye(n)[1:] - np.eye(n)[:-1], np.eye(n)[0]


def packing():
    """Three discs in the plane, each on the two others, and one that falls into their midst."""
    places = np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)], [1.5, np.sqrt(0.75)]])
    rows = []
    for i in range(4):
        for j in range(i):
            way = places[i] - places[j]
            if np.linalg.norm(way) < 1.01:
                row = np.zeros(8)
                row[2 * i : 2 * i + 2], row[2 * j : 2 * j + 2] = way, -way
                rows.append(row)
    v = np.zeros(8)
    v[6:] = [-0.6, -1.0]
    return np.diag(np.repeat([1.0, 1.0, 2.0, 1.5], 2)), np.array(rows), v


def block():
    """A block that rocks from one lower corner to the other: x, y, angle about its middle."""
    rows = np.array([[0.0, 1.0, -0.5], [0.0, 1.0, 0.5]])
    return np.diag([2.0, 2.0, 0.4]), rows, np.array([0.0, -0.5, -1.0])


CASES = {
    "ten equal balls": (*chain(np.ones(10)), np.ones(9)),
    "tapered chain": (*chain(0.7 ** np.arange(6)), 1.5 ** np.arange(5)),
    "column on a wall": (
        np.diag([1.0, 0.5, 2.0]), np.array([[1, 0, 0], [-1, 1, 0], [0, -1, 1]], dtype=float),
        np.array([0.0, 0, -1]), np.array([2.0, 1.0, 0.3]),
    ),
    "packing": (*packing(), np.linspace(1.0, 2.0, 5)),
    "rocking block": (*block(), np.array([1.0, 3.0])),
}  # fmt: skip


def test_flat_followedand_units():
    """The exponent counts; the absolute stiffness, the unit of mass and of length do not."""
    masses, rows, v, k = CASES["tapered chain"]
    for exponent in (1.0, 2.5):
        after, _ = along_normals(masses, rows, v, k, exponent=exponent)
        assert np.abs(after - springs(masses, rows, v, k, exponent)).max() < 1e-8
    plain, _ = along_normals(masses, rows, v, k)
    other, _ = along_normals(1e3 * masses, rows, 1e-3 * v, 1e9 * k)
    assert np.abs(1e3 * other - plain).max() < 1e-10


def test_solo12_on_four_feet():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    feet = ["FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"]
    q = robot.configuration(root_joint=[0, 0, 0.25, 0, 0, 0, 1])
    for leg, knee in zip(("FL", "FR", "HL", "HR"), (-1.4, -1.3, 1.2, 1.5), strict=True):
        q[robot.model.idx_qs[robot.joint_id(f"{leg}_KFE")]] = knee
        q[robot.model.idx_qs[robot.joint_id(f"{leg}_HFE")]] = -0.5 * knee
    v = robot.velocity(root_joint=[0, 0, -1, 0.3, -0.2, 0])
    k = np.array([1.0, 1.2, 0.8, 1.0]) * 1e6
    contacts = [ik.Contact(f, restitution=1.0, stiffness=s) for f, s in zip(feet, k, strict=True)]
    impact = ik.solve(ik.Scene(robot, contacts=contacts, law=LZB, gap_bound=np.inf), q, v)
    assert impact.is_valid() and ik.check(impact).agrees
    model, data = robot.model, robot.model.createData()
    masses = mass_matrix(model, q)
    way = pin.LOCAL_WORLD_ALIGNED
    rows = np.array(
        [pin.computeFrameJacobian(model, data, q, model.getFrameId(f), way)[2] for f in feet]
    )
    # Time in milliseconds and length in micrometres keep the numbers near 1.
    after = springs(masses * 1e-3, rows, v, k * 1e-9, end=60.0)
    assert np.abs(impact.v_after - after).max() < 1e-8 * np.abs(v).max() * 30
    scale = 0.5 * v @ masses @ v
    assert abs(impact.energy.change) < 1e-11 * scale


@pytest.mark.parametrize("e", [0.0, 0.02, 0.5, 0.9])
def test_each_contact_regains_its_share_of_work(e):
    """Contacts that do not feel each other are Newton's; coupled ones keep u⁺ and the energies."""
    v = np.array([-1.0, -2.0])
    after, found = along_normals(np.diag([1.0, 3.0]), np.eye(2), v, [1.0, 5.0], e)
    assert np.abs(after + e * v).max() < 1e-10
    assert found.normal_work == pytest.approx(-0.5 * np.array([1.0, 12.0]) * (1 - e * e))
    masses, rows, v, k = CASES["packing"]
    after, found = along_normals(masses, rows, v, k, e)
    change = 0.5 * after @ masses @ after - 0.5 * v @ masses @ v
    assert found.normal_work.sum() == pytest.approx(change, rel=1e-9)
    assert (rows @ after > -1e-9).all() and (found.normal_work <= 0).all()


def test_losses_follow_two_stiffnesses():
    """Loading along F = k δ^1.5, unloading along a stiffer curve."""
    masses, rows, v, k = CASES["column on a wall"]
    e, n = 0.7, 3

    def rates(t, y):
        depth = y[n:]
        u = rows @ y[:n]
        force = k * np.maximum(depth, 0.0) ** 1.5
        regains = (u > 0) & (depth > 0)
        return np.concatenate(
            [np.linalg.solve(masses, rows.T @ force), -u * np.where(regains, 1 / e**2, 1.0)]
        )

    way = solve_ivp(
        rates, [0, 40], np.concatenate([v, np.zeros(n)]), method="RK45", rtol=1e-9, atol=1e-11
    )
    after, _ = along_normals(masses, rows, v, k, e)
    assert np.abs(after - way.y[:n, -1]).max() < 1e-6


def test_one_contact_with_friction_is_stronges():
    rng = np.random.default_rng(4)
    for _ in range(8):
        root = rng.normal(size=(3, 4))
        W, u = root @ root.T, rng.normal(size=3)
        u[2] = -abs(u[2])
        e, mu = rng.uniform(0.1, 1.0, 2)
        memory = path_memory()
        block = W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2]
        assert follow(block, u[2], tuple(u), e, mu, STRONGE, memory) in (0, 3)
        # Twice the same, that do not feel each other.
        zero = np.zeros((3, 3))
        both = np.block([[W, zero], [zero, W]])
        two = np.ones(2)
        found = strike_by_energy(both, np.tile(u, 2), e * two, mu * two, two, 1.5)
        after = W @ memory.now[3:6] + u
        assert found[0] == 0
        assert np.abs(found[3] - np.tile(after, 2)).max() < 1e-9 * np.abs(u).max()


def test_a_slip_that_turns_aside_as_it_ends_ends():
    """Its direction was kept below 1e-9, and it went back and forth: 603 steps, or no answer."""
    W = np.array(
        [
            [2.1366897885304414, 0.011631718604952254, 0.25246535543689974],
            [0.011631718604952254, 0.2308082962491068, 0.08689133942844333],
            [0.25246535543689974, 0.08689133942844333, 1.0780433217434724],
        ]
    )
    u = np.array([0.16895899451257218, -0.04062888177872317, -0.5127947934357485])
    one, memory = np.ones(1), path_memory()
    found = strike_by_energy(W, u, 0.5 * one, 0.7 * one, one, 1.5)
    block = W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2]
    assert follow(block, u[2], tuple(u), 0.5, 0.7, STRONGE, memory) in (0, 3)
    assert found[0] == 0 and found[6] < 200
    assert np.abs(found[3] - W @ memory.now[3:6] - u).max() < 1e-9


@pytest.mark.parametrize("seed", [196, 103])
def test_slip_that_begins_from_rest_turns_as_springs_have_it(seed):
    """Friction was against the acceleration for a whole step: off by 1e-6, energies to 1e-13."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(6, 7)).round(2)
    W, u, half = J @ J.T, rng.normal(size=6).round(2), np.full(2, 0.5)
    u[2::3] = -abs(u[2::3])
    found = strike_by_energy(W, u, half, half, np.ones(2), 1.5)
    assert found[0] == 0
    speed = np.abs(u).max()
    followed = Spatial(W / W.diagonal().max(), u / speed, half, np.ones(2), half, 1.5)
    assert space_error(followed, found[3] / speed) < 1e-8


def test_random_contacts_obey_cone_and_energy():
    """Slip that creeps past zero and starts again is among them."""
    rng = np.random.default_rng(7)
    for _ in range(16):
        n = int(rng.integers(2, 4))
        root = rng.normal(size=(3 * n, int(rng.integers(3 * n, 3 * n + 4))))
        W, u = root @ root.T, rng.normal(size=3 * n)
        e, mu = rng.uniform(0.2, 1, n), rng.choice([0.0, 0.3, 0.8], n)
        found = lzb.strike_by_energy.py_func(W, u, e, mu, rng.uniform(0.1, 10, n), 1.5)
        code, residual, P, after, normal, friction, _ = found
        assert code == 0 and residual < 1e-9
        assert (after[2::3] > -1e-9).all() and (P[2::3] >= 0).all()
        sideways = np.hypot(P[0::3], P[1::3])
        assert (sideways <= mu * P[2::3] * (1 + 1e-9) + 1e-12).all()
        assert (normal <= 1e-12).all() and (friction <= 1e-12).all()


def test_bad_input_is_one_clear_error():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    with pytest.raises(ik.errors.InputError, match="stiffness of every contact"):
        ik.Scene(ball, contacts=[ik.Contact("ball")], law=LZB)
    with pytest.raises(ik.errors.RangeError, match="stiffness must be above 0"):
        ik.Contact("ball", stiffness=0.0)
    with pytest.raises(ik.errors.NotFiniteError, match="stiffness"):
        ik.Contact("ball", stiffness=float("nan"))
    with pytest.raises(ik.errors.RangeError, match="exponent must be 1 to 10"):
        ik.Law("lzb", exponent=0.5)
    with pytest.raises(ik.errors.InputError, match="act at once"):
        ik.Law("lzb", order="sequential")
    with pytest.raises(ik.errors.InputError, match="infinite stiffness"):
        along_normals(np.eye(2) + 0.1, np.eye(2), -np.ones(2), [1.0, np.inf])
    floor = ik.Contact("ball", stiffness=1.0, friction=0.1, tangential_restitution=0.5)
    with pytest.raises(ik.errors.InputError, match="tangential restitution"):
        ik.Scene(ball, contacts=[floor], law=LZB)
    two = [ik.Contact("ball", stiffness=1.0), ik.Contact("ball", at=[0, 0.1, 0], stiffness=2.0)]
    scene = ik.Scene(ball, contacts=two, law=LZB)
    fall = ball.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    impact = ik.solve(scene, ball.neutral(), fall)
    with pytest.raises(ik.errors.InputError, match="derivatives"):
        ik.derivatives(impact)
    rigid = ik.Scene(ball, contacts=[two[0], replace(two[1], stiffness=np.inf)], law=LZB)
    with pytest.raises(ik.errors.InputError, match="infinite stiffness"):
        ik.solve(rigid, ball.neutral(), fall)
    assert ik.solve_batch(rigid, ball.neutral()[None], fall).status[0] == ik.Status.REFUSED


def three_balls(mu, root="freeflyer"):
    """A scene of balls in a row, the last one at a wall, and what varies from row to row."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root=root)
    robot = ik.combine(a=ball, b=ball, c=ball)
    ways = {"restitution": 0.8, "friction": mu}
    contacts = [
        ik.Contact(f"{one}/ball", at=[-0.1, 0, 0], normal=[1, 0, 0], origin=[0.1, 0, 0],
                   against=f"{other}/ball", stiffness=k, **ways)
        for one, other, k in (("b", "a", 1e6), ("c", "b", 3e6))
    ]  # fmt: skip
    wall = ik.Contact(
        "c/ball", at=[0.1, 0, 0], normal=[-1, 0, 0], origin=[0.5, 0, 0], stiffness=2e6, **ways
    )
    rng = np.random.default_rng(3)
    v = rng.normal(size=(12, robot.nv))
    return ik.Scene(robot, contacts=[*contacts, wall], law=LZB, gap_bound=np.inf), robot, v


def test_a_change_that_ends_within_a_step_is_not_passed_over():
    """A soft contact beside one 50 times as stiff: its works and velocities were 2e-6 apart."""
    across = -1.3792870147130296
    W = np.zeros((6, 6))
    W[2, 2], W[5, 5], W[2, 5], W[5, 2] = 0.9835042374499396, 4.03373955332052, across, across
    free = np.array([0.0, 0.0, -1.5323331430196192, 0.0, 0.0, -1.1786071582628566])
    stiffness = np.array([19614.97486184975, 956608.1009101571])
    e = np.full(2, 0.5)
    code, residual, P, after, work, _, _ = strike_by_energy(W, free, e, np.zeros(2), stiffness, 1.0)
    assert code == ik.Status.SOLVED
    assert residual < 1e-12
    assert after == pytest.approx(free + W @ P, abs=1e-14)
    assert work.sum() == pytest.approx(0.5 * P @ (free + after), abs=1e-12)


def test_a_support_that_parts_and_is_met_again_is_refused():
    """The spring at one end turns the box until the other end, which parted, comes down."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    spring = ik.Contact("box", at=[-0.2, 0, -0.1], stiffness=1.0, restitution=0.5)
    support = ik.Contact("box", at=[0.2, 0, -0.1], stiffness=np.inf, restitution=0.5)
    scene = ik.Scene(box, contacts=[spring, support], law=LZB)
    v = np.array([0, 0, -0.23, 0, -3.7, 0])
    with pytest.raises(ik.errors.InputError, match=r"contact 1 .* met again at .* m/s"):
        ik.solve(scene, box.neutral(), v)
    assert ik.solve_batch(scene, box.neutral(), v[None]).status[0] == ik.Status.REFUSED


def on_hinges(ways, speeds, coupling=0.0):
    """W and u_free of points on hinges of unit inertia, each moved along its own line (k, 3)."""
    J = np.zeros((3 * len(ways), len(ways)))
    for i, way in enumerate(ways):
        J[3 * i : 3 * i + 3, i] = way
    M = np.eye(len(ways)) + coupling * (1.0 - np.eye(len(ways)))
    return J @ np.linalg.solve(M, J.T), J @ np.asarray(speeds)


@pytest.mark.parametrize("coupling", [0.0, 1e-7])
def test_what_friction_wedges_without_restitution_ends_where_it_stops(coupling):
    """P_n = |θ̇|/(j_n + µ |j_t|) as slip stops; from there its force would stay for ever."""
    ways, mu = np.array(((0.8, 0.0, 0.6), (-0.3, 0.4, 1.0))), np.array((1.0, 3.0))
    W, free = on_hinges(ways, (-1.0, -2.0), coupling)
    none, ones = np.zeros(2), np.ones(2)
    struck = Waved(*strike_by_energy(W, free, none, mu, np.array((1.0, 0.3)), 1.5))
    assert struck.status is Status.SOLVED
    across = np.linalg.norm(ways[:, :2], axis=1)
    expected = np.array((1.0, 2.0)) / (ways[:, 2] + mu * across)
    assert struck.impulse[2::3] == pytest.approx(expected, rel=1e-9 + 3.0 * coupling)
    assert np.abs(struck.after).max() < 1e-9
    half = Waved(*strike_by_energy(W, free, 0.5 * ones, mu, np.array((1.0, 0.3)), 1.5))
    assert half.status is Status.NO_SOLUTION
    # Out of the cone it is thrown back.
    slippery = Waved(*strike_by_energy(W, free, 0.5 * ones, 0.1 * mu, np.array((1.0, 0.3)), 1.5))
    assert slippery.status is Status.SOLVED
    assert (slippery.after[2::3] > 0.1).all()


def test_of_two_that_are_wedged_the_one_without_restitution_ends():
    ways, mu = np.array(((0.8, 0.0, 0.6), (-0.3, 0.4, 1.0))), np.array((1.0, 3.0))
    W, free = on_hinges(ways, (-1.0, -2.0))
    hit = Waved(*strike_by_energy(W, free, np.array((0.0, 0.5)), mu, np.ones(2), 1.5))
    assert hit.status is Status.NO_SOLUTION
    assert hit.steps < 600


@pytest.mark.parametrize("name", CASES)
def test_without_loss_it_is_the_motion_of_hertz_springs(name):
    masses, rows, v, k = CASES[name]
    after, found = along_normals(masses, rows, v, k)
    assert np.abs(after - springs(masses, rows, v, k)).max() < 1e-8
    kinetic = 0.5 * v @ masses @ v
    assert abs(0.5 * after @ masses @ after - kinetic) < 1e-10 * kinetic
    assert (rows @ after > -1e-9).all() and (found.impulse[2::3] >= 0).all()
