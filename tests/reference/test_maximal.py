"""Kane's method against maximal coordinates, where no generalized speed is left."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.truths.maximal import impact_of_free_bodies
from impulsekit.reference import KaneSystem, Load

from .models import (
    EVERY_KIND,
    FOUR_BAR,
    pinocchio_model,
    random_state,
    relative,
)

"""Four equal bars; the far ends of bars 3 and 4 meet in a corner left open."""


def both(system, q, y, *rest):
    return system.impact(q, y, *rest), impact_of_free_bodies(system, q, y, *rest)


def agree(kane, maximal, bar=1e-10):
    assert relative(kane.dy, maximal.dy) < bar
    assert relative(kane.body_dv, maximal.body_dv) < bar
    assert relative(kane.body_domega, maximal.body_domega) < bar
    reactions = kane.joint_reactions()
    largest = max(np.abs(wrench).max() for wrench in reactions.values())
    for name, wrench in maximal.joint_reactions.items():
        assert np.abs(reactions[name] - wrench).max() < bar * largest, name


def four_bar_pose(crank):
    """Coordinates of the closed four-bar; its crank reaches some 2.29 rad."""
    pin_at = 0.4 * np.array([np.cos(crank), np.sin(crank)])
    reach = np.array([1.0, 0.0]) - pin_at
    span = np.linalg.norm(reach)
    corner = np.arccos((0.8**2 + span**2 - 0.5**2) / (2 * 0.8 * span))
    coupler = np.arctan2(reach[1], reach[0]) + corner
    tip = pin_at + 0.8 * np.array([np.cos(coupler), np.sin(coupler)])
    rocker = np.arctan2(tip[1], tip[0] - 1)
    return np.array([np.cos(crank), np.sin(crank), coupler - crank, np.cos(rocker), np.sin(rocker)])


@pytest.mark.parametrize("seed", range(20))
def test_a_struck_four_bar(seed):
    """The loop's three rows hold one redundant one: nothing moves out of the plane."""
    rng = np.random.default_rng(seed)
    system = KaneSystem.from_urdf(FOUR_BAR)
    q = four_bar_pose(rng.uniform(0.3, 2.2))
    at = system.kinematics(q)
    tips = [
        at.origins[k] + at.rotations[k] @ [length, 0, 0]
        for k, length in ((system.body_of_link("coupler"), 0.8),
                          (system.body_of_link("rocker"), 0.5))
    ]  # fmt: skip
    assert tips[0] == pytest.approx(tips[1], abs=1e-14)
    loop = system.rows_at_point(q, "coupler", "rocker", (0.8, 0, 0), (0.5, 0, 0))
    blow = Load("coupler", rng.normal(size=3), rng.normal(size=3), (0.5, 0.1, 0))
    kane, maximal = both(system, q, rng.normal(size=3), [blow], {"crank_pin": 0.3}, loop)
    agree(kane, maximal)
    # In the plane the pin's impulse is unique; across it the joints share as they like.
    assert relative(kane.row_impulses[:2], maximal.row_impulses[:2]) < 1e-10


@pytest.mark.parametrize("root", ["fixed", "planar", "freeflyer"])
def test_every_kind_of_joint_and_row(root):
    rng = np.random.default_rng(5)
    system = KaneSystem.from_urdf(EVERY_KIND, root)
    q, y = random_state(pinocchio_model(EVERY_KIND, root), 41)
    blows = [
        Load("tool", rng.normal(size=3), rng.normal(size=3), rng.normal(size=3)),
        Load("slider", rng.normal(size=3), (0, 0, 0), rng.normal(size=3), "local"),
    ]
    kicks = {"Beta": [0.1, -0.2, 0.3], "_fly": rng.normal(size=6), "zeta": 0.5, "alpha": -0.4}
    rows = system.stack(
        system.rows_at_point(q, "arm", "drone", (0.1, 0, 0), target=[0.1, 0.2, 0.3]),
        system.rows_on_speeds(rng.normal(size=(2, system.n)), [0.5, 0]),
    )
    kane, maximal = both(system, q, y, blows, kicks, rows)
    agree(kane, maximal, 1e-11)
    assert relative(kane.row_impulses, maximal.row_impulses) < 1e-11


@pytest.mark.parametrize("seed", range(5))
def test_rows_between_links_joined_rigidly_move_nothing(seed):
    """They are zero but for rounding, and rounding must not be taken for mobility."""
    system = KaneSystem.from_urdf(EVERY_KIND, "freeflyer")
    q, y = random_state(pinocchio_model(EVERY_KIND, "freeflyer"), 50 + seed)
    at, tree = system.kinematics(q), system
    tool, wheel = tree.body_of_link("tool"), tree.body_of_link("wheel")
    place = at.origins[tool] + at.rotations[tool] @ [0.3, 0.2, -0.4]
    on_wheel = at.rotations[wheel].T @ (place - at.origins[wheel])
    rows = system.stack(
        system.rows_at_point(q, "tool", "wheel", (0.3, 0.2, -0.4), on_wheel),
        system.rows_of_turning("tool", "wheel"),
        system.rows_at_point(q, "drone", target=[1, 2, 3]),
    )
    alone = system.impact(q, y, rows=system.rows_at_point(q, "drone", target=[1, 2, 3]))
    kane, maximal = both(system, q, y, [Load("arm", (1, 2, 3))], None, rows)
    agree(kane, maximal, bar=1e-11)
    assert np.abs(kane.row_impulses[:6]).max() < 1e-10
    assert np.abs(maximal.row_impulses[:6]).max() < 1e-10
    unstruck, _ = both(system, q, y, [], None, rows)
    assert relative(unstruck.dy, alone.dy) < 1e-11
