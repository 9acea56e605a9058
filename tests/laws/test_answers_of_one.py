"""One contact: its answers against a scan of all directions of slip, and what is said of them."""

import numpy as np
import pytest
from scipy.optimize import brentq

import impulsekit as ik
from impulsekit.bench.stress.bodies import Link, robot_of
from impulsekit.impact.contact_space import ContactProblem, solve_contacts
from impulsekit.impact.contact_space.others import find_others
from impulsekit.laws.answers_of_one import answers_of_one

VERDICTS = ("proven", "not proven", "several")


def scanned(W, b, mu, floor):
    """P of every answer: at the floor, sticking, and sliding by sign changes around the circle."""
    found = []

    def slide(angle):
        s = np.array([np.cos(angle), np.sin(angle)])
        press = W[2, 2] - mu * W[2, :2] @ s
        P = -b[2] / press * np.array([-mu * s[0], -mu * s[1], 1.0])
        return P, (W @ P + b)[:2], s

    def across(angle):
        P, slip, s = slide(angle)
        # Times W_nn − µ w·s, which has a pole where P_n changes its sign.
        return (slip[0] * s[1] - slip[1] * s[0]) * (-b[2] / P[2])

    angles = np.linspace(-np.pi, np.pi, 4001)
    values = [across(angle) for angle in angles]
    for low, high, left, right in zip(angles, angles[1:], values, values[1:], strict=False):
        if left * right < 0.0:
            P, slip, s = slide(brentq(across, low, high, xtol=1e-14))
            if P[2] > floor and slip @ s > 0.0:
                found.append(P)
    stick = np.linalg.lstsq(W, -b, rcond=1e-12)[0]
    holds = np.abs(W @ stick + b).max() < 1e-10 and np.hypot(*stick[:2]) <= mu * stick[2]
    if holds and stick[2] > floor:
        found.append(stick)
    if floor == 0.0 and b[2] >= 0.0:
        found.append(np.zeros(3))
    return found


@pytest.mark.parametrize("floor", [0.0, 0.4])
@pytest.mark.parametrize("mu", [0.3, 0.9, 2.0])
def test_all_answers_are_found(mu, floor):
    """Of regular W; with a floor, those above it (on it friction is a convex problem)."""
    rng = np.random.default_rng(int(10 * mu))
    several = 0
    for _ in range(150):
        J = rng.normal(size=(3, 3)) * (1.0, 1.0, 0.3)
        W, b = J @ J.T + 1e-3 * np.eye(3), rng.normal(size=3)
        room = np.zeros((8, 3))
        count, is_all = answers_of_one.py_func(W, b, mu, floor, np.abs(b).max(), room)
        assert is_all
        expected = scanned(W, b, mu, floor)
        shown = [P for P in room[:count] if P[2] > floor or floor == 0.0]
        assert len(shown) == len(expected)
        for P in expected:
            assert min(np.abs(P - one).max() for one in shown) < 1e-8 * (1.0 + np.abs(P).max())
        several += count > 1
    assert several > 0


def test_on_the_floor_nothing_is_drawn_in():
    rng = np.random.default_rng(4)
    for _ in range(100):
        J = rng.normal(size=(3, 3))
        W, b, mu, floor = J @ J.T, rng.normal(size=3), 0.5, 0.7
        room = np.zeros((8, 3))
        count, _ = answers_of_one.py_func(W, b, mu, floor, 1.0, room)
        for P in room[:count]:
            xi = W @ P + b
            assert xi[2] * (P[2] - floor) == pytest.approx(0.0, abs=1e-9)
            assert np.hypot(*P[:2]) <= mu * P[2] * (1.0 + 1e-9)
            turned = xi[0] * P[1] - xi[1] * P[0]
            assert turned == pytest.approx(0.0, abs=1e-7 * (1.0 + np.abs(P).max()))
            assert P[:2] @ xi[:2] <= 1e-9


def test_what_is_restored_to_one_velocity_is_one_answer():
    """The compression may stick or slide, and the expansion stops both: v⁺ is the same.

    W has rank two. It was told as MANY_SOLUTIONS, with no other v⁺ to be shown.
    """
    found = 0
    for seed in range(1000):
        rng = np.random.default_rng(seed)
        J = rng.normal(size=(3, 2))
        u, one = J @ rng.normal(size=2), np.ones(1)
        problem = ContactProblem(J @ J.T, u, u, 0.9 * one, 2.0 * one, 0.0 * one)
        law = ik.Law("poisson")
        solution = solve_contacts(problem, law)
        finding = find_others(problem, law, solution)
        if solution.status is ik.Status.MANY_SOLUTIONS:
            found += 1
            for P in finding.impulses:
                assert P @ (u + 0.5 * problem.delassus @ P) <= 1e-12
                apart = np.abs(problem.delassus @ (P - solution.impulse)).max()
                assert apart > 1e-6 * np.abs(u).max()
            assert finding.impulses
    assert found > 10


@pytest.mark.slow
@pytest.mark.parametrize("restitution", ["newton", "poisson"])
@pytest.mark.parametrize("joints", [1, 2, 3, 4])
def test_rows_of_batches_are_told_as_by_solve(joints, restitution):
    rng = np.random.default_rng(joints)
    told = set()
    for _ in range(25):
        links = [
            Link(i - 1, rng.uniform(0.3, 3.0), joint=kind, axis=tuple(rng.normal(size=3)))
            for i, kind in enumerate(rng.choice(["revolute", "prismatic"], joints))
        ]
        robot = robot_of(links, "fixed")
        contact = ik.Contact(
            f"link_{joints - 1}", at=rng.normal(size=3), normal=rng.normal(size=3),
            friction=rng.choice([0.3, 0.8, 2.0]), restitution=rng.choice([0.0, 0.5, 0.9]),
        )  # fmt: skip
        scene = ik.Scene(robot, contacts=[contact], law=ik.Law(restitution))
        V = rng.normal(size=(6, robot.nv))
        batch = ik.solve_batch(scene, robot.neutral(), V)
        for row, v in enumerate(V):
            impact = ik.solve(scene, robot.neutral(), v)
            assert impact.status == batch.status[row]
            if impact.status.obeys_law and impact.status is not ik.Status.ENERGY_GAIN:
                assert VERDICTS[batch.uniqueness[row]] == impact.uniqueness.verdict
                told.add(impact.uniqueness.verdict)
                many = impact.status is ik.Status.MANY_SOLUTIONS
                assert not many or impact.uniqueness.others
    assert "proven" in told
