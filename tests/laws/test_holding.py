"""Bilateral rows in one call, held against the equations of Δv and λ together."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact import ImpactSolver, constrained
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
    return mass, (lower, pivots, rows, impulse, v, asked)


@pytest.mark.parametrize("by_row", [False, True])
@pytest.mark.parametrize(("nv", "m"), [(3, 1), (6, 6), (12, 5)])
def test_rows_are_met_and_momentum_balances(nv, m, by_row):
    mass, given = problem(nv, m, np.random.default_rng(nv))
    _, _, rows, impulse, _, asked = given
    whole = np.block([[mass, -rows.T], [rows, np.zeros((m, m))]])
    truth = np.linalg.solve(whole, np.concatenate([impulse, asked]))
    solved, dv, multipliers, moves = hold(*given, by_row)
    assert moves.all() and np.abs(np.concatenate([dv, multipliers]) - truth).max() < 1e-11
    assert solved == BY_ALL or by_row or m == nv


def test_rows_of_zeros_take_nothing_and_others_go_on():
    mass, (lower, pivots, rows, impulse, v, asked) = problem(6, 4, np.random.default_rng(1))
    rows[2], asked[2] = 0.0, 0.0
    solved, dv, multipliers, moves = hold(lower, pivots, rows, impulse, v, asked, False)
    assert solved == BY_SOME and moves.tolist() == [True, True, False, True]
    assert multipliers[2] == 0.0
    assert np.abs(mass @ dv - impulse - rows.T @ multipliers).max() < 1e-13
    asked[2] = 1.0
    assert hold(lower, pivots, rows, impulse, v, asked, False)[0] == UNSOLVED


def test_dependent_rows_are_left():
    _, (lower, pivots, rows, impulse, v, asked) = problem(6, 3, np.random.default_rng(2))
    rows[2] = rows[0] - 2.0 * rows[1]
    asked[2] = asked[0] - 2.0 * asked[1]
    assert hold(lower, pivots, rows, impulse, v, asked, False)[0] == UNSOLVED


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
    monkeypatch.setattr(constrained, "hold", counted)
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
