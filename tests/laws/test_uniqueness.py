"""Whether other v⁺ obey the law is told: all modes in a plane, neighbours in space, no answer."""

from __future__ import annotations

import json
import pickle
from itertools import product

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from tests.conformance.end_laws import left_of_coulomb, newton_shift
from tests.conformance.mechanics import mechanics_of

from .rows import solved_rows


def modes_in_plane(W, b, mu):
    """All P of planar contacts, by trying parting, sticking and both slips everywhere."""
    n, found = len(b) // 2, []
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
        if np.linalg.cond(A) > 1e12:
            continue
        P = np.linalg.solve(A, r)
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


def planar(seed, frictions, most=3):
    """Rows, v⁻, e, µ of two or three contacts of one or two bodies in a plane."""
    rng = np.random.default_rng(seed)
    n, bodies = int(rng.integers(2, most + 1)), int(rng.integers(1, 3))
    unit = np.sqrt(np.repeat(10.0 ** rng.uniform(-1, 0, bodies), 3))
    unit *= np.tile([1, 1, np.sqrt(rng.uniform(0.05, 1))], bodies)
    J = np.zeros((3 * n, 3 * bodies))
    for i in range(n):
        one, angle = int(rng.integers(bodies)), rng.uniform(0, 2 * np.pi)
        c, s = np.cos(angle), np.sin(angle)
        for body, sign in ((one, 1), (int(rng.integers(bodies)), -1)):
            if sign < 0 and (body == one or rng.random() < 0.5):
                continue
            x, y = rng.uniform(-1, 1, 2)
            own = np.array([[c, s, x * s - y * c], [0, 0, 0], [-s, c, x * c + y * s]])
            J[3 * i : 3 * i + 3, 3 * body : 3 * body + 3] = sign * own
    v = rng.normal(size=3 * bodies) * unit
    e, mu = rng.choice([0.0, 0.5, 1.0], n), rng.choice(frictions, n)
    return J / unit, v, e, mu


def truths(J, v, e, mu):
    """Every v⁺ with its gain of energy."""
    rows = np.array([3 * i + k for i in range(len(e)) for k in (0, 2)])
    J, u = J[rows], J[rows] @ v
    b = u.copy()
    b[1::2] += e * np.minimum(u[1::2], 0.0)
    found = []
    for P in modes_in_plane(J @ J.T, b, mu):
        after = v + J.T @ P
        if not any(np.abs(after - one).max() < 1e-8 for one, _ in found):
            found.append((after, after @ after - v @ v > 1e-9 * (v @ v)))
    return found


@pytest.mark.parametrize("frictions", [(0.0, 0.3, 1.0, 3.0), (0.0, 1.0, 3.0, 10.0)], ids=str)
def test_in_a_plane_it_is_as_all_modes_say(frictions):
    counts = {"several": 0, "one": 0}
    for seed in range(70):
        J, v, e, mu = planar(seed, frictions)
        every = truths(J, v, e, mu)
        lawful = [after for after, gains in every if not gains]
        impact = solved_rows(J, v, e, mu)
        size = np.abs(v).max()
        if not impact.is_valid():
            # An answer that gains energy may be shown beside one that does not.
            assert not lawful or impact.uniqueness.several
        elif lawful:
            counts["several" if len(lawful) > 1 else "one"] += 1
            assert min(np.abs(impact.v_after - after).max() for after in lawful) < 1e-7 * size
            assert impact.uniqueness.several or len(lawful) == 1
            assert not impact.uniqueness.proven or len(lawful) == 1
            for after in lawful:
                told = (impact.v_after, *impact.uniqueness.others)
                assert min(np.abs(other - after).max() for other in told) < 1e-7 * size
    assert counts["several"] >= 2 and counts["one"] >= 10


def test_in_a_plane_an_answer_is_found_or_proven_absent():
    counts = {True: 0, False: 0}
    for seed in range(200):
        J, v, e, mu = planar(seed, (1.0, 3.0, 10.0), most=4)
        every = truths(J, v, e, mu)
        impact = solved_rows(J, v, e, mu)
        if not every:
            assert impact.status is ik.Status.NO_SOLUTION, seed
        elif any(not gains for _, gains in every):
            assert impact.status.obeys_law, seed
        counts[bool(every)] += 1
    assert counts[True] >= 100 and counts[False] >= 20


@pytest.mark.parametrize("friction", [0.0, 0.02])
def test_small_friction_is_proven_unique(friction):
    rng = np.random.default_rng(0)
    J = rng.normal(size=(9, 12))
    impact = solved_rows(J, -J[2] - J[5] - J[8], 0.5, friction)
    assert impact.uniqueness.proven and not impact.uniqueness.others
    told = json.loads(json.dumps(impact.to_dict()))["uniqueness"]
    assert told["verdict"] == "proven"


# Of the first 400 states these have several answers by a search of all modes of each.
SEVERAL = (26, 42, 127)


@pytest.mark.parametrize("seed", SEVERAL)
def test_of_four_feet_that_rub_another_answer_is_told(seed):
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    feet = [
        ik.Contact(foot, friction=1.0, restitution=0.2)
        for foot in ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")
    ]
    scene, rng = ik.Scene(solo, contacts=feet, gap_bound=np.inf), np.random.default_rng(seed)
    q = pin.integrate(solo.model, solo.neutral(), rng.uniform(-1.0, 1.0, solo.nv))
    v = rng.normal(size=solo.nv) - np.eye(solo.nv)[2]
    impact = ik.solve(scene, q, v)
    m = mechanics_of(scene, q, v)
    b = m.J @ v + newton_shift(0.2, m.J @ v)
    assert impact.uniqueness.several
    for after in (impact.v_after, *impact.uniqueness.others):
        P = np.linalg.lstsq(m.J.T, m.M @ (after - v), rcond=None)[0]
        assert left_of_coulomb(m.W, b, np.ones(4), P) < 1e-9
        assert after @ m.M @ after <= v @ m.M @ v * (1.0 + 1e-12)
    assert np.abs(impact.uniqueness.others[0] - impact.v_after).max() > 1e-3
    again = pickle.loads(pickle.dumps(impact))
    assert again.uniqueness.several and "several" in ik.report(again)
