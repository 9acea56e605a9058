"""Bilateral rows in one call, held against the equations of Δv and λ together."""

import mpmath
import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact import ImpactSolver, factor
from impulsekit.impact.warm import compile_laws
from impulsekit.laws.holding import BY_ALL, BY_SOME, UNSOLVED, hold


def factored(nv, rng):
    """M (nv, nv), and Uᵀ and D of M = U D Uᵀ."""
    half = rng.normal(size=(nv, nv))
    mass = half @ half.T + np.eye(nv)
    lower = np.linalg.cholesky(mass[::-1, ::-1])[::-1, ::-1]
    roots = np.diagonal(lower)
    return mass, np.ascontiguousarray((lower / roots).T), roots**2


def problem(nv, m, rng):
    mass, lower, pivots = factored(nv, rng)
    rows, impulse, v, asked = (rng.normal(size=s) for s in ((m, nv), nv, nv, m))
    return mass, (lower, pivots, rows, impulse, v, asked, np.arange(m))


@pytest.mark.parametrize("by_row", [False, True])
@pytest.mark.parametrize(("nv", "m"), [(3, 1), (6, 6), (12, 5)])
def test_rows_are_met_and_momentum_balances(nv, m, by_row):
    mass, given = problem(nv, m, np.random.default_rng(nv))
    _, _, rows, impulse, _, asked, _ = given
    whole = np.block([[mass, -rows.T], [rows, np.zeros((m, m))]])
    truth = np.linalg.solve(whole, np.concatenate([impulse, asked]))
    solved, dv, multipliers, moves = hold(*given, by_row)
    assert moves.all() and np.abs(np.concatenate([dv, multipliers]) - truth).max() < 1e-11
    assert solved == BY_ALL or by_row or m == nv


def test_rows_of_zeros_take_nothing_and_others_go_on():
    mass, (lower, pivots, rows, impulse, v, asked, own) = problem(6, 4, np.random.default_rng(1))
    rows[2], asked[2] = 0.0, 0.0
    solved, dv, multipliers, moves = hold(lower, pivots, rows, impulse, v, asked, own, False)
    assert solved == BY_SOME and moves.tolist() == [True, True, False, True]
    assert multipliers[2] == 0.0
    assert np.abs(mass @ dv - impulse - rows.T @ multipliers).max() < 1e-13
    asked[2] = 1.0
    assert hold(lower, pivots, rows, impulse, v, asked, own, False)[0] == UNSOLVED


def of_least_norm(mass, rows, wanted, independent):
    """λ of least norm, in units of the rows, with A M⁻¹ Aᵀ λ as wanted."""
    with mpmath.workdps(50):
        inverse = mpmath.matrix(mass.tolist()) ** -1
        A = mpmath.matrix(rows.tolist())
        W = A * inverse * A.T
        scale = mpmath.diag([1 / mpmath.sqrt(W[i, i]) for i in range(len(rows))])
        W = scale * W * scale
        # W x = r in those that are independent; x = Wᵀ y is of least norm.
        own = mpmath.matrix([[W[i, j] for j in range(len(rows))] for i in independent])
        right = mpmath.matrix([scale[i, i] * mpmath.mpf(wanted[i]) for i in independent])
        x = scale * (own.T * mpmath.lu_solve(own * own.T, right))
        return np.array([float(value) for value in x])


def test_dependent_rows_share_by_least_norm():
    mass, given = problem(8, 5, np.random.default_rng(2))
    _, _, rows, impulse, _, asked, _ = given
    # Exact in doubles: the fourth row is half the sum of the first two.
    rows[:], asked[:] = np.round(64.0 * rows) / 64.0, np.round(64.0 * asked) / 64.0
    rows[3], asked[3] = 0.5 * (rows[0] + rows[1]), 0.5 * (asked[0] + asked[1])
    solved, dv, multipliers, unique = hold(*given, False)
    assert solved == BY_SOME and unique.tolist() == [False, False, True, False, True]
    wanted = asked - rows @ np.linalg.solve(mass, impulse)
    truth = of_least_norm(mass, rows, wanted, [0, 1, 2, 4])
    assert np.abs(multipliers - truth).max() < 1e-13 * np.abs(truth).max()
    assert np.abs(rows @ dv - asked).max() < 1e-14 * np.abs(rows).sum(axis=1).max()
    # Rows that contradict each other, or nearly depend on each other, are left.
    asked[3] += 1e-9
    assert hold(*given, False)[0] == UNSOLVED
    asked[3] -= 1e-9
    rows[3, 0] += 1e-9
    assert hold(*given, False)[0] == UNSOLVED


def test_an_axis_short_beside_others_of_its_vector_is_left_where_rows_depend():
    _, given = problem(8, 5, np.random.default_rng(4))
    _, _, rows, _, _, asked, own = given
    rows[3], asked[3] = 0.5 * (rows[0] + rows[1]), 0.5 * (asked[0] + asked[1])
    rows[4] *= 1e-2
    asked[4] *= 1e-2
    assert hold(*given, False)[0] == BY_SOME
    own[4] = own[2]
    assert hold(*given, False)[0] == UNSOLVED


def test_solve_calls_it_once_and_agrees_with_the_long_way(monkeypatch):
    robot = ik.Robot.from_example("talos", root="freeflyer")
    held = [ik.FrameAnchor("leg_left_6_link"), ik.PointAnchor("leg_right_6_link")]
    blow = ik.AppliedImpulse("gripper_left_base_link", linear=[0.3, -0.2, 1.0])
    scene = ik.Scene(robot, [blow], held)
    compile_laws(scene)
    calls = []

    class Counted:
        is_compiled = True

        def __call__(self, *args):
            calls.append(1)
            return hold(*args)

        def wait(self, seconds):
            pass

    counted = Counted()
    monkeypatch.setattr(factor, "hold", counted)
    solver, rng = ImpactSolver(scene), np.random.default_rng(3)
    for _ in range(5):
        q = pin.integrate(robot.model, robot.neutral(), 0.3 * rng.normal(size=robot.nv))
        v = rng.normal(size=robot.nv)
        counted.is_compiled = True
        impact = solver.solve(q, v)
        counted.is_compiled = False
        slow = solver.solve(q, v)
        assert impact.is_valid()
        assert np.abs(impact.dv - slow.dv).max() < 1e-12 * np.abs(slow.dv).max()
        for one, other in zip(impact.constraints, slow.constraints, strict=True):
            assert np.abs(one.impulse - other.impulse).max() < 1e-11
    assert len(calls) == 5
