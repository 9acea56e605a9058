"""Derivatives of batches: those of one impact, row by row, and their products with weights."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.impact.derivatives import DerivativeStatus
from tests.conformance.entries import ENTRIES
from tests.impact.test_derivatives import CASES, blow, contacts, on_arm

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
LAWS = {
    f"{law.restitution}-{law.slip}-{law.order}, {mu}": lambda law=law, mu=mu: on_arm(
        law=law,
        impulses=[blow("fore", 7)],
        contacts=contacts(1 if law.slip == "path" and law.order == "simultaneous" else 2, mu, 0.6),
    )
    for law in (
        ik.Law(),
        ik.Law("poisson"),
        ik.Law("newton", "path"),
        ik.Law("stronge", "path"),
        ik.Law(order="sequential"),
        ik.Law("poisson", order="sequential"),
        ik.Law("stronge", "path", "sequential"),
    )
    for mu in (0.1, 3.0)
}
HELD = {
    name: lambda e=ENTRIES[name]: (e.near or e.scene, e.q, e.v)
    for name in ("JointImpulse", "PointAnchor-moving", "DistanceAnchor", "JointLock-kept",
                 "JointCoupling", "JointStop", "Rope-between", "Contact-between", "friction-slides")
}  # fmt: skip
SCENES = {**CASES, **LAWS, **HELD}
BY = ("q", "v", "impulses", "restitution", "friction", "at", "normal", "strike")


def states(scene, q, v, count=11):
    """Rows about a state, few of them in other modes."""
    rng, model = np.random.default_rng(0), scene.robot.model
    Q = np.array([pin.integrate(model, q, 1e-3 * rng.normal(size=len(v))) for _ in range(count)])
    return Q, v + 1e-2 * rng.normal(size=(count, len(v)))


def of_one(found, scene, by):
    """(nv, …) the derivatives of v⁺ of one impact as a batch has them."""
    contacts, blows = scene.entry_names("contacts"), scene.entry_names("impulses")
    table = found["v_after", by if by != "strike" else "at"]
    nv = len(found.impact.v_before)
    if by in ("q", "v"):
        return table
    if by == "impulses":
        return np.hstack([np.zeros((nv, 0)), *table.values()])
    if by == "strike":
        return np.array([table[n] for n in blows if n in table]).reshape(-1, nv, 3).swapaxes(0, 1)
    shape = (nv, 3) if by in ("at", "normal") else (nv,)
    parts = [table.get(name, np.zeros(shape)) for name in contacts]
    return np.array(parts).reshape(len(contacts), *shape).swapaxes(0, 1)


@pytest.mark.parametrize("name", SCENES)
def test_each_row_is_that_of_one_impact(name):
    scene, q, v = SCENES[name]()
    Q, V = states(scene, q, v)
    found = ik.derivatives_batch(scene, Q, V, by=BY)
    weights = np.random.default_rng(1).normal(size=V.shape)
    pulled = ik.vjp(scene, Q, V, weights, by=BY)
    np.testing.assert_array_equal(pulled.codes, found.codes)
    assert found.exists.sum() > 5
    for i in np.flatnonzero(found.exists):
        one = ik.derivatives(ik.solve(scene, Q[i], V[i]))
        for by in BY:
            wanted, ours = of_one(one, scene, by), found["v_after", by][i]
            size = max(np.abs(wanted).max(initial=0.0), 1.0)
            np.testing.assert_allclose(ours, wanted, rtol=0, atol=1e-9 * size)
            product = np.tensordot(weights[i], ours, 1)
            np.testing.assert_allclose(pulled[by][i], product, rtol=0, atol=1e-9 * size)


def test_contact_impulses_and_masses_against_differences():
    panda = ik.Robot.from_example("panda")
    touch = ik.Contact("panda_hand", restitution=0.3, friction=0.2, name="touch")
    scene = ik.Scene(panda, contacts=[touch])
    rng = np.random.default_rng(3)
    Q, V = rng.uniform(-0.5, 0.5, (20, 9)), rng.normal(size=(20, 9))
    of, by = ("v_after", "contact_impulses"), ("v", "q", "mass", "restitution")
    masses = {"panda_hand": 1.7, "panda_link4": 0.6}
    found = ik.derivatives_batch(scene, Q, V, of=of, by=by, masses=masses)

    def told(V=V, Q=Q, masses=masses, **changed):
        batch = ik.solve_batch(scene, Q, V, outputs=of, masses=masses, **changed)
        return batch.v_after, batch.contact_impulses

    d, h = rng.normal(size=9), 1e-5
    up = dict(zip(found.links, rng.normal(size=len(found.links)), strict=True))
    ways = {
        "v": (d, lambda h: told(V + h * d)),
        "q": (d, lambda h: told(Q=Q + h * d)),
        "mass": (
            np.array(list(up.values())),
            lambda h: told(masses={name: masses.get(name, 1.0) + h * x for name, x in up.items()}),
        ),
        "restitution": (np.ones(1), lambda h: told(restitution=0.3 + h)),
    }
    for kind, (way, change) in ways.items():
        for name, ahead, behind in zip(of, change(h), change(-h), strict=True):
            wanted, ours = (ahead - behind) / (2 * h), found[name, kind] @ way
            off = np.abs(ours - wanted)[found.exists]
            assert off.max() < 1e-7 * max(1.0, np.abs(wanted).max())


def test_rows_without_derivatives_are_flagged_with_the_reason():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5, friction=0.5)])
    V = np.array([[0, 0, -1, 0, 0, 0], [0.1, 0, 0, 0, 0, 0], [np.nan, 0, 0, 0, 0, 0]], dtype=float)
    found = ik.vjp(scene, ball.neutral(), V, np.eye(6)[2])
    names = [tuple(DerivativeStatus)[code].name for code in found.codes]
    assert names == ["EXISTS", "MODE_EDGE", "NO_IMPACT"]
    assert np.isnan(found["v"][2]).all() and np.isfinite(found["v"][:2]).all()
    # Bent ever so little the second row of a stretched arm's tip stops it.
    rods = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    held = ik.Scene(rods, [], [ik.PointAnchor("link_2", at=[0, 0, -1])])
    jumps = ik.derivatives_batch(held, [[0.0, 0.0], [0.0, 0.1]], [1.0, -1.0])
    assert jumps.exists.tolist() == [False, True] and np.isnan(jumps["v_after", "q"][0]).any()


def test_weights_of_impulses_and_bad_names():
    scene, q, v = SCENES["newton-end-simultaneous, 0.1"]()
    Q, V = states(scene, q, v, 3)
    w = np.random.default_rng(0).normal(size=(3, 2, 3))
    found = ik.derivatives_batch(scene, Q, V, of="contact_impulses", by="q")
    pulled = ik.vjp(scene, Q, V, {"contact_impulses": w}, by="q")
    wanted = np.einsum("bcx,bcxq->bq", w, found["contact_impulses", "q"])
    np.testing.assert_allclose(pulled["q"], wanted, rtol=1e-10, atol=1e-10)
    with pytest.raises(ik.errors.UnknownNameError):
        ik.vjp(scene, Q, V, {"impulse": w})
    with pytest.raises(ik.errors.UnknownNameError):
        ik.derivatives_batch(scene, Q, V, by="mu")
    with pytest.raises(ik.errors.ShapeError):
        ik.vjp(scene, Q, V, w[:, 0])
    with pytest.raises(ik.errors.NotFiniteError, match="cotangent of contact_impulses"):
        ik.vjp(scene, Q, V, {"contact_impulses": np.nan * w})


def test_a_series_without_end_is_not_taken_for_its_first_hits():
    """A ball in a narrow wedge hits its walls in turn for ever."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    walls = [ik.Contact("ball", normal=[x, 0, 0.1], restitution=0.5) for x in (-1.0, 1.0)]
    scene = ik.Scene(ball, contacts=walls, law=ik.Law(order="sequential"))
    V = np.array([[0.3, 0.0, -1.0, 0.1, 0.2, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    found = ik.vjp(scene, ball.neutral(), V, np.ones(6))
    names = [tuple(DerivativeStatus)[code].name for code in found.codes]
    assert names == ["NOT_AVAILABLE", "EXISTS"]
