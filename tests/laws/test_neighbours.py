"""Other answers beside a known one, for more contacts with friction than whose modes are tried."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.laws.neighbours import add_neighbours
from impulsekit.laws.workspace import workspace
from tests.lawful import left_of_the_law

FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")
E, MU = 0.2, 1.0


@pytest.fixture(scope="module")
def scene():
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    return ik.Scene(solo, contacts=[ik.Contact(f, friction=MU, restitution=E) for f in FEET])


def state(scene, seed):
    rng, robot = np.random.default_rng(seed), scene.robot
    q = pin.integrate(robot.model, robot.neutral(), rng.uniform(-1.0, 1.0, robot.nv))
    return q, rng.normal(size=robot.nv) - np.eye(robot.nv)[2]


# Of the first 400 states these have several answers by a search of all modes of each.
SEVERAL = (26, 42, 127, 138, 145, 259)


@pytest.mark.parametrize("seed", SEVERAL)
def test_of_four_feet_that_rub_another_answer_is_told(scene, seed):
    q, v = state(scene, seed)
    impact = ik.solve(scene, q, v)
    assert impact.status is ik.Status.MANY_SOLUTIONS
    for after in (impact.v_after, *impact.uniqueness.others):
        assert left_of_the_law(scene, q, v, after) < 1e-10
        energies = [pin.computeKineticEnergy(scene.robot.model, pin.Data(scene.robot.model), q, x)
                    for x in (v, after)]  # fmt: skip
        assert energies[1] <= energies[0] * (1.0 + 1e-12)
    assert np.abs(impact.uniqueness.others[0] - impact.v_after).max() > 1e-3


def test_batches_tell_as_one_by_one(scene):
    seeds = (*SEVERAL, 0, 1, 2, 3)
    q, v = map(np.array, zip(*(state(scene, seed) for seed in seeds), strict=True))
    status = ik.solve_batch(scene, q, v).status
    assert (status == ik.Status.MANY_SOLUTIONS).tolist() == [seed in SEVERAL for seed in seeds]


def test_where_none_is_beside_it_is_not_proven_that_there_is_none(scene):
    impact = ik.solve(scene, *state(scene, 0))
    assert impact.status is ik.Status.SOLVED
    assert impact.uniqueness.verdict == "not proven"
    assert "not searched" in impact.uniqueness.reason


def rods(count):
    """Painlevé's rod, count times, and each by itself: W, ξ without impulse, and friction.

    A rod of length 2 and mass 1 that leans at 1 rad, its tip on a floor and sliding up the lean.
    """
    c, s, mu = np.cos(1.0), np.sin(1.0), 1.5
    inertia = 3.0
    own = np.eye(3) * (1.0 + inertia * np.array([s * s, 0.0, c * c]))
    own[0, 2] = own[2, 0] = inertia * s * c
    W, b = np.zeros((3 * count, 3 * count)), np.zeros(3 * count)
    for i in range(count):
        at = slice(3 * i, 3 * i + 3)
        W[at, at], b[at] = own, (1.0, 0.0, 0.05)
    return W, b, np.full(count, mu)


def test_rods_that_part_could_jam_each_by_itself():
    """In closed form: ξ = b + W P = 0 with |P_t| < µ P_n, and P = 0, both obey the law."""
    W, b, mu = rods(4)
    P = -np.linalg.solve(W[:3, :3], b[:3])
    assert P[2] > 0.0 and np.hypot(*P[:2]) < mu[0] * P[2]
    work, found = workspace(4), np.zeros((8, 12))
    work.W[:], work.b[:], work.mu[:] = W, b, mu
    assert add_neighbours(work, 4, np.zeros(12), False, found, 0) == 4
    for i in range(4):
        expected = np.zeros(12)
        expected[3 * i : 3 * i + 3] = P
        assert min(np.abs(one - expected).max() for one in found[:4]) < 1e-12
    # And back: each of them let go.
    stuck = np.tile(P, 4)
    assert add_neighbours(work, 4, stuck, False, found, 0) == 4
    for one in found[:4]:
        assert sorted(one[2::3] > 0.0) == [False, True, True, True]


def test_without_friction_there_is_none():
    rng = np.random.default_rng(0)
    for _ in range(20):
        root = rng.normal(size=(4, 6))
        W, b = np.zeros((12, 12)), np.zeros(12)
        W[2::3, 2::3] = root @ root.T
        b[2::3] = -np.abs(rng.normal(size=4))
        work, found = workspace(4), np.zeros((8, 12))
        work.W[:], work.b[:] = W, b
        # Lemke's problem, by trying which contacts press.
        for chosen in range(16):
            press = [3 * i + 2 for i in range(4) if (chosen >> i) & 1]
            P = np.zeros(12)
            if press:
                P[press] = -np.linalg.solve(W[np.ix_(press, press)], b[press])
            if P.min() >= 0.0 and (W @ P + b).min() >= -1e-12:
                assert add_neighbours(work, 4, P, False, found, 0) == 0
