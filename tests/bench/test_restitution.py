"""The table of restitution in simulators: its own columns against closed forms."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

from benchmarks.restitution import (
    DROP,
    FLIGHTS,
    GRAVITY,
    RECIPES,
    STICKS,
    alone,
    bounce,
    damping_ratio,
    in_exudyn,
    peak_of_spring,
    sticking,
    tossed,
)  # fmt: skip

SOFT, _, _, _, INSIDE, _ = RECIPES


@pytest.mark.parametrize("e", [0.9, 0.25])
def test_the_ratio_is_that_of_a_damped_spring(e):
    ratio = damping_ratio(e)
    assert np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)) == pytest.approx(e, rel=1e-12)


@pytest.mark.parametrize("dt", [0.0005, 0.005])
def test_e_is_reached_inside_mujoco_and_alone(dt):
    assert bounce(INSIDE, 0.5, "elliptic", "RK4", dt).e == pytest.approx(0.5, rel=1e-8)
    assert alone(0.5)[2] == pytest.approx(0.5 * np.sqrt(2 * GRAVITY * DROP), rel=1e-9)
    soft = bounce(SOFT, 0.5, "elliptic", "RK4", dt)
    assert soft.e == pytest.approx(0.5, abs=0.03)
    # Undamped it would sink by v/√K.
    assert 0.05 < soft.depth < np.sqrt(2 * GRAVITY * DROP / 1e3)


@pytest.mark.parametrize("recipe", RECIPES[:4], ids=lambda recipe: recipe.name)
def test_recipes_are_springs_and_dampers(recipe):
    closed = peak_of_spring(recipe, 0.5)
    fine = bounce(recipe, 0.5, "elliptic", "RK4", 2e-5).force
    # Impedance rises within the first millimetre.
    assert fine == pytest.approx(closed, rel=0.005)
    omega, ratio = recipe.frequency(0.5), damping_ratio(0.5)
    t = np.linspace(0.0, np.pi / omega, 100001)
    s = omega * np.sqrt(1 - ratio**2)
    x = np.sqrt(2 * GRAVITY * DROP) / s * np.exp(-ratio * omega * t) * np.sin(s * t)
    force = omega**2 * x + 2 * ratio * omega * np.gradient(x, t)
    assert closed - GRAVITY == pytest.approx(force.max(), rel=1e-6)


def test_exudyn_reaches_e_when_it_is_stiff():
    pytest.importorskip("exudyn")
    cells = in_exudyn(1e5)
    for e, cell in zip((0.9, 0.5, 0.25), cells, strict=False):
        assert float(cell.split(" to ")[0]) == pytest.approx(e, abs=0.01)


def test_the_sphere_that_must_stick_does():
    assert sticking(INSIDE, "pyramidal", "Euler", 0.002) == pytest.approx(STICKS, rel=1e-9)
    assert alone(0.6, slide=True)[[0, 4]] == pytest.approx(STICKS, rel=1e-9)


def test_tosses_end_nearer_with_impacts():
    plain, inside, own = (float(tossed(name)[1]) for name in FLIGHTS)
    assert inside < plain
    assert own < plain
