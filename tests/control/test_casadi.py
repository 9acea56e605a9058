"""Impacts and motions as functions of CasADi: values, derivatives, edges, IPOPT, bad input."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, MissingExtraError, UnknownNameError
from impulsekit.impact.derivatives import DerivativeStatus

casadi = pytest.importorskip("casadi")
pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")

EXAMPLES = Path(__file__).parents[2] / "examples"
BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
FLOOR = ik.Scene(BALL, contacts=[ik.Contact("ball", friction=0.3, restitution=0.9, name="floor")])
SOLO = ik.Robot.from_example("solo12", root="freeflyer")
LEGS = ("FL", "FR", "HL", "HR")
FEET = [ik.Contact(f"{leg}_FOOT", friction=0.8, restitution=0.3, name=leg) for leg in LEGS]
LANDING = ik.Scene(SOLO, contacts=FEET)


def state(seed=0):
    """A landing whose quaternion is not of unit length."""
    rng = np.random.default_rng(seed)
    q, v = SOLO.neutral() + 0.1 * rng.normal(size=19), rng.normal(size=18)
    v[2] -= 3.0
    return q, v


def jacobian(F, q, v):
    """∂(all outputs)/∂(q, v)."""
    x = [casadi.MX.sym("q", *q.shape), casadi.MX.sym("v", *v.shape)]
    table = casadi.jacobian(casadi.veccat(*F(*x)), casadi.veccat(*x))
    return np.array(casadi.Function("J", x, [table])(q, v))


def differences(F, q, v, step):
    """The same by Richardson's extrapolation."""
    x = np.concatenate([q, v])

    def slope(h):
        ends = [
            [np.array(casadi.veccat(*F(*np.split(x + s * h * e, [len(q)])))) for s in (1, -1)]
            for e in np.eye(len(x))
        ]
        return np.array([(a - b).ravel() / (2 * h) for a, b in ends]).T

    return (4 * slope(step) - slope(2 * step)) / 3


def test_outputs_are_those_of_solve():
    from impulsekit.casadi import impact

    q, v = state()
    after, impulses, loads = map(np.array, impact(LANDING)(q, v))
    unit = np.array(q)
    unit[3:7] /= np.linalg.norm(q[3:7])
    solved = ik.solve(LANDING, unit, v)
    np.testing.assert_allclose(after.ravel(), solved.v_after, rtol=0, atol=1e-13)
    for i, leg in enumerate(LEGS):
        np.testing.assert_allclose(impulses[:, i], solved.contacts[leg].impulse, atol=1e-13)
    for i, name in enumerate(list(SOLO.model.names)[1:]):
        own = solved.joint_loads[name]
        np.testing.assert_allclose(loads[:, i], [*own.force, *own.moment], atol=1e-13)


def test_the_jacobian_is_that_of_differences():
    from impulsekit.casadi import impact

    F, (q, v) = impact(LANDING), state()
    ours, truth = jacobian(F, q, v), differences(F, q, v, 1e-4)
    assert np.abs(ours - truth).max() < 1e-10 * np.abs(truth).max()
    assert F.statuses == {DerivativeStatus.EXISTS: 1}


def test_reverse_mode_is_the_transposed_jacobian():
    from impulsekit.casadi import impact

    F, (q, v) = impact(LANDING), state(1)
    x = [casadi.MX.sym("q", 19), casadi.MX.sym("v", 18)]
    y, z = casadi.veccat(*F(*x)), casadi.veccat(*x)
    weights = np.random.default_rng(0).normal(size=(y.numel(), 3))
    pulled = [casadi.jtimes(y, z, casadi.DM(w), True) for w in weights.T]
    found = np.array(casadi.Function("g", x, [casadi.horzcat(*pulled)])(q, v))
    wanted = jacobian(F, q, v).T @ weights
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


def test_many_states_in_one_call_are_those_of_map():
    from impulsekit.casadi import impact

    pairs = [state(seed) for seed in range(3)]
    Q, V = np.array([q for q, _ in pairs]).T, np.array([v for _, v in pairs]).T
    many, one = impact(LANDING, states=3), impact(LANDING)
    for ours, mapped in zip(many(Q, V), one.map(3)(Q, V), strict=True):
        np.testing.assert_array_equal(np.array(ours), np.array(mapped))
    np.testing.assert_array_equal(jacobian(many, Q, V), jacobian(one.map(3), Q, V))


def test_an_edge_keeps_the_derivative_of_its_mode_and_is_counted():
    from impulsekit.casadi import impact

    # No approach and no parting: the edge between a blow and none.
    F, v = impact(FLOOR, ["v_after"]), np.zeros(6)
    table = jacobian(lambda *x: [F(*x)], BALL.neutral(), v)
    assert set(F.statuses) == {DerivativeStatus.MODE_EDGE}
    # One of the two sides: it keeps its speed, or bounces.
    assert table[2, 9] in (1.0, -0.9)


def test_a_search_passes_the_edge_between_sticking_and_slipping():
    """The least |v⁺|: at the corner where slip begins, or beyond it, never a failure."""
    from impulsekit.casadi import impact

    F = impact(FLOOR, ["v_after"])
    v = casadi.MX.sym("v", 6)
    problem = {"x": v, "f": casadi.sumsqr(F(BALL.neutral(), v) - casadi.DM([0, 0, 1, 0, 0, 0]))}
    options = {
        "ipopt.hessian_approximation": "limited-memory", "ipopt.print_level": 0,
        "ipopt.sb": "yes", "print_time": False,
    }  # fmt: skip
    solver = casadi.nlpsol("reach", "ipopt", problem, options)
    found = solver(x0=[3.0, 0, -1.0, 0, 0.5, 0])
    assert solver.stats()["success"] and float(found["f"]) < 1e-12
    assert sum(F.statuses.values()) > 3


def test_the_end_of_a_motion_by_its_start():
    from impulsekit.casadi import sensitivity

    F = sensitivity(FLOOR, 0.8, rtol=1e-11, atol=1e-12)
    q, v = np.array([0, 0, 1, 0.1, 0.2, 0, 0.97]), np.array([0.1, 0, 0, 1, 2, 3.0])
    ours, truth = jacobian(F, q, v), differences(F, q, v, 1e-3)
    assert np.abs(ours - truth).max() < 1e-8
    assert F.statuses == {DerivativeStatus.EXISTS: 1}


@pytest.fixture(scope="module")
def hopper():
    return runpy.run_path(str(EXAMPLES / "hopper_to_target.py"))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_ten_impacts_reach_a_target_from_ten_starts(hopper, seed):
    start = np.random.default_rng(seed).uniform(-0.2, 0.2, 10)
    found = hopper["plan"](10, 3.0, start)
    assert found["status"] == "Solve_Succeeded" and found["off"] < 1e-8
    assert found["cost"] == pytest.approx(0.02666124837, abs=1e-8)
    feet = hopper["followed"](found["pitch"], found["time"])
    assert feet[-1] - feet[0] == pytest.approx(3.0, abs=1e-8)


def test_bad_input_is_one_sentence_each():
    from impulsekit.casadi import impact, sensitivity

    with pytest.raises(InputError, match="the scene has no contacts and no constraints"):
        impact(ik.Scene(BALL))
    with pytest.raises(UnknownNameError, match='unknown output "v_aftr"; did you mean "v_after"'):
        impact(FLOOR, ["v_aftr"])
    with pytest.raises(InputError, match="states must be"):
        impact(FLOOR, states=0)
    with pytest.raises(InputError, match="derivatives of joint loads: available where"):
        impact(FLOOR.replace(impulses=[ik.AppliedImpulse("ball", linear=[1, 0, 0])]))
    with pytest.raises(InputError, match="Scene"):
        sensitivity(BALL, 1.0)
    # What CasADi itself says of a state that is laid out in another way.
    with pytest.raises(RuntimeError, match=r"Input 0 \(q\) has mismatching shape. Got 6-by-1"):
        impact(FLOOR)(np.zeros(6), np.zeros(6))


def test_without_casadi_it_says_what_to_install(monkeypatch):
    monkeypatch.delitem(sys.modules, "impulsekit.casadi", raising=False)
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(MissingExtraError, match=r'needs casadi: pip install "\.\[casadi\]"'):
        import impulsekit.casadi  # noqa: F401
