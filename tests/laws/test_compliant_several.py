"""Several contacts with springs along their normals and their tangents."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.impact.contact_law import ContactProblem, solve_contacts

from ..robots import one_body
from .springs import spring_impulses
from .test_compliant import COMPLIANT, struck

FEET = [(x, y, -0.05) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]


def drawn(seed, n):
    """W (3n, 3n), u⁻, e, µ, k and κ of contacts that all approach."""
    rng = np.random.default_rng(seed)
    J, v = rng.normal(size=(3 * n, 3 * n + 2)), rng.normal(size=3 * n + 2)
    J[2::3] *= -np.sign(J[2::3] @ v)[:, None]
    low, high = [0.3, 0.1, 0.1, 0.3], [0.9, 1.2, 10.0, 2.0]
    return J @ J.T, J @ v, *rng.uniform(np.full((n, 4), low), high).T


def solved(W, u, e, mu, k, ratio, damping=None, law=COMPLIANT):
    problem = ContactProblem(
        W, u, u, e, mu, 0 * mu, stiffness=k, stiffness_ratio=ratio, tangential_damping=damping
    )
    return solve_contacts(problem, law)


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("seeds", [range(6), pytest.param(range(6, 40), marks=pytest.mark.sweep)])
def test_in_space_they_are_as_integrated(n, seeds):
    for seed in seeds:
        W, u, *coefficients = drawn(seed, n)
        found = solved(W, u, *coefficients)
        assert found.status is ik.Status.SOLVED
        after = u + W @ spring_impulses(W, u, *coefficients)
        assert found.velocity_after == pytest.approx(after, abs=1e-9 * np.abs(u).max())


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2, 3])
def test_damped_springs_give_back_less_of_their_work(n):
    for seed in range(4):
        W, u, *coefficients = drawn(seed, n)
        damping = np.random.default_rng(seed).uniform(0.0, 0.8, n)
        found = solved(W, u, *coefficients, damping)
        assert found.status is ik.Status.SOLVED
        after = u + W @ spring_impulses(W, u, *coefficients, damping)
        assert found.velocity_after == pytest.approx(after, abs=1e-9 * np.abs(u).max())


@pytest.mark.parametrize("damping", [0.0, 0.5, 0.9])
def test_half_a_swing_gives_back_its_share(damping):
    """A spring that sticks from rest to rest: u_t⁺² = (1 − D) u_t⁻²."""
    kept = 1.0 - damping
    # Its loading takes a quarter of a period, its release √(1 − D) of one: both end with F_n.
    half = 0.5 * np.pi * (1.0 + np.sqrt(kept))
    u, W = np.array([0.03, 0.0, -1.0]), np.diag([3.5, 3.5, 1.0])
    ratio, one = (half / np.pi) ** 2 / 3.5, np.ones(1)
    found = solved(W, u, one, 30.0 * one, one, ratio * one, damping * one)
    assert found.velocity_after == pytest.approx([-0.03 * np.sqrt(kept), 0.0, 1.0], abs=1e-9)


def test_contacts_that_hardly_act_on_each_other_are_each_as_alone():
    for seed in range(20):
        W, u, e, mu, k, ratio = drawn(seed, 2)
        own = [slice(0, 3), slice(3, 6)]
        W[own[0], own[1]] *= 1e-12
        W[own[1], own[0]] *= 1e-12
        found = solved(W, u, e, mu, k, ratio).velocity_after
        for i, rows in enumerate(own):
            alone = struck(W[rows, rows], u[rows], e[i], mu[i], ratio[i]).velocity_after
            assert found[rows] == pytest.approx(alone, abs=3e-9 * np.abs(u).max())


def test_energy_never_rises_and_friction_stays_in_its_cones():
    for seed in range(200):
        W, u, e, mu, k, ratio = drawn(seed, 2 + seed % 3)
        found = solved(W, u, e if seed % 2 else 0 * e, mu, k, ratio)
        assert found.status is ik.Status.SOLVED
        P = found.impulse.reshape(-1, 3)
        assert 0.5 * found.impulse @ (u + found.velocity_after) < 0.0
        assert (np.hypot(P[:, 0], P[:, 1]) <= mu * P[:, 2] * (1.0 + 1e-9)).all()
        assert (found.velocity_after[2::3] >= -1e-9 * np.abs(u).max()).all()


def test_rigid_along_tangents_they_are_waves_with_coulombs_friction():
    waves, off = ik.Law("lzb", exponent=1.0), {np.inf: [], 1e2: [], 1e3: []}
    for seed in range(20):
        W, u, e, mu, k, _ = drawn(seed, 2)
        rigid = solved(W, u, e, mu, k, np.ones(2), law=waves).velocity_after
        for ratio, own in off.items():
            here = solved(W, u, e, mu, k, np.full(2, ratio)).velocity_after
            own.append(np.abs(here - rigid).max() / np.abs(u).max())
    assert max(off[np.inf]) == 0.0
    assert np.median(off[1e2]) < 5e-3 and np.median(off[1e3]) < 5e-4


@pytest.fixture
def box():
    return one_body("box", 2.0, 0.05)


def rubber_feet(box, **given):
    contacts = [
        ik.Contact("box", at=at, restitution=0.6, friction=0.8, stiffness_ratio=0.7, **given)
        for at in FEET
    ]
    return ik.Scene(box, contacts=contacts, law=COMPLIANT, gravity=[0, 0, -9.81])


def test_a_box_on_rubber_feet_turns_back_in_every_way_of_solving(box):
    scene = rubber_feet(box)
    q, v = box.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1]), np.array([0.4, 0, -2.0, 0, 0, 0])
    impact = ik.solve(scene, q, v)
    assert impact.is_valid() and impact.energy.change < 0.0
    # Its feet slip at first, then their springs throw them back.
    assert impact.velocity_at("box", FEET[0]).after[2] > 0.0
    assert impact.velocity_at("box", FEET[0]).after[0] < 0.1
    equal = ik.solve(rubber_feet(box, stiffness=3.0), q, v)
    assert equal.v_after == pytest.approx(impact.v_after, abs=1e-12)
    batch = ik.solve_batch(scene, q[None], v[None])
    assert batch.v_after[0] == pytest.approx(impact.v_after, abs=1e-12)
    assert ik.contact_problem(scene, q, v).solve().v_after == pytest.approx(impact.v_after)
    lossy = ik.solve(rubber_feet(box, tangential_damping=0.5), q, v)
    assert lossy.energy.change < impact.energy.change
    pair = ik.MaterialPair("rubber", "floor", stiffness_ratio=0.7, tangential_damping=0.5)
    assert pair.tangential_damping == 0.5
    above = box.configuration(root_joint=[0, 0, 0.3, 0, 0, 0, 1])
    motion = ik.simulate(scene, above, [0.2, 0, 0, 0.1, 0.2, 0], 4.0)
    assert motion.status.finished and len(motion.impacts) > 1
    assert motion.energy().total[-1] < motion.energy().total[0]
    assert np.abs(motion.v[-1]).max() < 1e-6


def test_stiffnesses_are_of_all_or_of_none(box):
    scene = rubber_feet(box)
    stiff = ik.Contact("box", at=FEET[0], friction=0.5, stiffness_ratio=1.0, stiffness=2.0)
    mixed = ik.Scene(box, contacts=[stiff, *scene.contacts[1:]], law=COMPLIANT)
    q = box.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1])
    for damping in (-0.1, 1.0):
        with pytest.raises(ik.errors.RangeError, match="tangential_damping"):
            ik.Contact("box", tangential_damping=damping)
    with pytest.raises(ik.errors.InputError, match=r"of every contact .* or of none"):
        ik.solve(mixed, q, [0, 0, -1, 0, 0, 0])
