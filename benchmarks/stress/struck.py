"""A blow is the velocity that it leaves: what is struck, and what moves so, end alike.

Half of the worlds are at rest before, where velocities before say nothing of the energies in play.
Newton's restitution goes by the velocity before the blow where contacts act at once: it is 0 there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from impulsekit.impact import solve

from .mechanisms import Blow, World, built, random_world
from .rewritten import condition_of, points_of
from .sweep import Point, Sweeps
from .told import told, told_by_batch

__all__ = ["SWEEPS"]

SWEEPS = Sweeps()

# Of the velocities without constraints: with less, what is struck is held, and rounding is left.
HELD = 1e-9


@SWEEPS.of("struck", "contacts", (1.0, 2.0, 3.0, 4.0), 900, logarithmic=False)
def struck_points(value: float, rng: np.random.Generator) -> list[Point]:
    """Chains with so many contacts that are struck, all laws, by ``solve`` and ``solve_batch``."""
    world = _struck_world(int(value), rng)
    scene, q, v = built(world)
    if rng.random() < 0.5:
        v = np.zeros_like(v)
    blows_alone = told(lambda: solve(replace(scene, contacts=()), q, v))
    free = blows_alone.after
    if free is None or not blows_alone.valid:
        return []
    unheld = solve(replace(scene, contacts=(), constraints=()), q, v).v_after
    if not np.abs(free).max() > HELD * np.abs(unheld).max():
        return []
    moving = replace(scene, impulses=())
    first = told(lambda: solve(scene, q, v))
    alone = told(lambda: solve(moving, q, free))
    (struck,), (batch,) = (
        told_by_batch(each, q[None], speed[None]) for each, speed in ((scene, v), (moving, free))
    )
    ways = {"velocity": alone, "batch": struck, "velocity in a batch": batch}
    found = [(name, one, one.after) for name, one in ways.items()]
    return points_of(first, found, condition_of(moving, q, free, alone, rng), [v, free])


def _struck_world(count: int, rng: np.random.Generator) -> World:
    world = random_world(count, rng)
    places = [(c, k) for c, chain in enumerate(world.chains) for k in range(len(chain.links))]
    place = places[int(rng.integers(len(places)))]
    size = 10.0 ** rng.uniform(-3, 2)
    blow = Blow(place, 0.2 * rng.normal(size=3), size * rng.normal(size=3), np.zeros(3))
    touches = world.touches
    if world.law.restitution == "newton" and world.law.order == "simultaneous":
        touches = tuple(replace(touch, restitution=0.0) for touch in touches)
    return replace(world, blows=(*world.blows, blow), touches=touches)
