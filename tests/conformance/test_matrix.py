"""Law × slip × order × scene × way of solving, each against the law as it is written down."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import impulsekit as ik

from .differences import assert_true
from .laws import left_of_law, true_impulse
from .mechanics import mechanics_of
from .scenes import SCENES

LAWS = {
    "newton": ik.Law(),
    "poisson": ik.Law("poisson"),
    "newton-path": ik.Law("newton", "path"),
    "poisson-path": ik.Law("poisson", "path"),
    "stronge": ik.Law("stronge", "path"),
    "lzb": ik.Law("lzb"),
    "newton-sequence": ik.Law("newton", "end", "sequential"),
    "poisson-sequence": ik.Law("poisson", "end", "sequential"),
    "newton-path-sequence": ik.Law("newton", "path", "sequential"),
    "poisson-path-sequence": ik.Law("poisson", "path", "sequential"),
    "stronge-sequence": ik.Law("stronge", "path", "sequential"),
}
# Velocities, relative; impulses that are determined; momentum, constraints and the law's residual.
SPEED, RESIDUAL = 1e-9, 1e-11
# Of impulses that a truth integrates; the step of differences.
INTEGRATED, STEP = 1e-9, 1e-4


def defined(law: str, scene: str) -> bool | None:
    """Whether a law with slip along the path takes the scene without friction; None for not at all.

    Along the path one contact is followed at a time.
    """
    chosen, case = LAWS[law], SCENES[scene]()
    if chosen.order == "sequential" or chosen.slip == "end" or case.islands:
        return False
    if chosen.restitution == "lzb":
        # Of several that rub at once the truth takes long.
        return scene != "two"
    return None if chosen.restitution == "stronge" else True


PAIRS = [
    pytest.param(law, scene, id=f"{law}-{scene}")
    for law in LAWS
    for scene in SCENES
    if defined(law, scene) is not None
]


@cache
def posed(law, scene):
    """The scene under the law, its case, its mechanics and the coefficients of its contacts."""
    case = SCENES[scene]()
    own = case.under(LAWS[law], smooth=defined(law, scene))
    coefficients = tuple(
        np.array([getattr(c, name) for c in own.contacts])
        for name in ("restitution", "friction", "stiffness")
    )
    # In a sequence corners that fall equally fast would leave it open which is hit first.
    tilted = own.law.order == "sequential" and not case.shares
    v = case.v + 0.1 * np.array([0, 0, 0, 1.0, 2.0, 0]) if tilted else case.v
    return own, case, mechanics_of(own, case.q, v), coefficients


@cache
def varied(law, scene):
    """Rows of a batch, (mechanics, coefficients): as it is, slower, and with others' e and µ."""
    _, _, m, (e, mu, stiffness) = posed(law, scene)
    slower = replace(m, v=0.8 * m.v)
    return (
        (m, (e, mu, stiffness)),
        (slower, (e, 0.9 * mu, stiffness)),
        (m, (e[::-1], mu[::-1], stiffness)),
    )


@cache
def truth(law, scene, row):
    m, coefficients = varied(law, scene)[row]
    return m.after(true_impulse(LAWS[law], m, coefficients))


def check(law, scene, row, v_after, impulses, held):
    """Hold an answer against momentum, constraints and the law."""
    chosen, case, (m, coefficients) = LAWS[law], SCENES[scene](), varied(law, scene)[row]
    P = m.in_own_axes(impulses)
    assert m.left_of_momentum(v_after, P, held) < RESIDUAL
    speed = np.abs([v_after, m.v, m.v_free]).max()
    if len(m.A):
        assert np.abs(m.A @ v_after - m.aim).max() < RESIDUAL * speed
    np.testing.assert_allclose(v_after, m.after(P), rtol=0, atol=SPEED * speed)
    at_end = (chosen.slip, chosen.order) == ("end", "simultaneous")
    if case.shares or (at_end and chosen.restitution == "newton"):
        left = left_of_law(chosen, m, coefficients, P)
        assert left < (RESIDUAL if at_end else INTEGRATED)
    if scene != "turning":
        # Where slips differ load can be shifted, and v⁺ with it.
        np.testing.assert_allclose(v_after, truth(law, scene, row), rtol=0, atol=SPEED * speed)


@pytest.mark.parametrize(("law", "scene"), PAIRS)
def test_solve(law, scene):
    own, case, m, _ = posed(law, scene)
    impact = ik.solve(own, case.q, m.v)
    held = np.concatenate([np.zeros(0), *(c.impulse for c in impact.constraints)])
    check(law, scene, 0, impact.v_after, [c.impulse for c in impact.contacts], held)
    assert impact.residuals.largest < (INTEGRATED if law == "lzb" else RESIDUAL)


@pytest.mark.parametrize(("law", "scene"), PAIRS)
def test_solve_batch(law, scene):
    own, case, _, _ = posed(law, scene)
    rows = varied(law, scene)
    batch = ik.solve_batch(
        own,
        case.q,
        [m.v for m, _ in rows],
        restitution=[e for _, (e, _, _) in rows],
        friction=[mu for _, (_, mu, _) in rows],
        outputs=("v_after", "contact_impulses", "constraint_impulses", "energy_change"),
    )
    for i, (m, _) in enumerate(rows):
        v = batch.v_after[i]
        check(law, scene, i, v, batch.contact_impulses[i], batch.constraint_impulses[i])
        change = 0.5 * (v + m.v) @ m.M @ (v - m.v)
        size = 0.5 * v @ m.M @ v + 0.5 * m.v @ m.M @ m.v
        assert abs(batch.energy_change[i] - change) < SPEED * size


@pytest.mark.parametrize(("law", "scene"), PAIRS)
def test_simulate(law, scene):
    """All that touches and approaches at the start is struck there."""
    own, case, m, _ = posed(law, scene)
    motion = ik.simulate(own, case.q, m.v, duration=0.0)
    assert motion.status.finished
    ((_, impact),) = motion.impacts
    held = np.concatenate([np.zeros(0), *(c.impulse for c in impact.constraints)])
    check(law, scene, 0, impact.v_after, [c.impulse for c in impact.contacts], held)
    np.testing.assert_array_equal(motion.v[-1], impact.v_after)


@pytest.mark.parametrize(
    ("law", "scene"), [pair for pair in PAIRS if LAWS[pair.values[0]].restitution != "lzb"]
)
def test_derivatives(law, scene):
    """By q, v, blows, each e and each µ, against differences of ``solve``."""
    own, case, m, _ = posed(law, scene)
    found = ik.derivatives(ik.solve(own, case.q, m.v))
    if not found.status.exists:
        # Redundant contacts, and what is struck at rest, are on the edge of a mode.
        assert scene in ("flat", "sliding", "turning", "struck")
        return
    assert_true(own, case.q, m.v, step=STEP, shares=case.shares)
