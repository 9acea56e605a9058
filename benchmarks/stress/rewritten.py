"""The same scene written in other ways: the answer is the same, and so is what it is called.

Worlds moved and turned, mirrored, boosted, in other units, entries in another order, a link split
by a fixed joint, ``frame`` and ``against`` swapped; and one scene solved by ``solve``, by
``solve_batch`` and by a solver that has solved before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from benchmarks.truths.numbers import EPS
from impulsekit.impact import ImpactSolver, solve
from impulsekit.scene import Scene

from .mechanisms import (
    Blow,
    Chain,
    Link,
    Place,
    Touch,
    World,
    built,
    chain_sizes,
    random_turn,
    random_world,
)
from .mechanisms import split as split_link
from .methods import Told, told, told_by_batch
from .sweep import Point, Sweeps, seen

SWEEPS = Sweeps()

# [of all speeds] Velocities nearer than this are the same, whatever the condition.
SAME = 1e-9
# Changes of the state by which an answer's own condition is found, and how often it may grow:
# masses and places are rewritten, too, and are not among the changes.
NUDGE, ALLOWED = 1e-8, 1e4
# Conditions above it are told as this.
LARGEST = 1e300


@dataclass(frozen=True, eq=False)
class Rewritten:
    """A world in other words, and v' = ratio · v + shift, speed by speed."""

    world: World
    ratio: np.ndarray
    shift: np.ndarray


def _per_speed(world: World, linear: np.ndarray, angular: np.ndarray, slide: float, turn: float):
    """(nv,) of factors: of the base's speeds, and of joints."""
    parts = []
    for chain in world.chains:
        if chain.free:
            parts += [*linear, *angular]
        joints = chain.links[1:] if chain.free else chain.links
        parts += [slide if link.slides else turn for link in joints]
    return np.array(parts)


def moved(world: World, rng: np.random.Generator) -> Rewritten:
    """The world elsewhere, and turned."""
    Q, t = random_turn(rng), rng.normal(size=3) * 10.0 ** rng.uniform(-1, 1)
    there = lambda x: Q @ x + t  # noqa: E731
    chains = tuple(replace(c, turn=Q @ c.turn, at=there(c.at)) for c in world.chains)
    blows = tuple(replace(b, linear=Q @ b.linear, angular=Q @ b.angular) for b in world.blows)
    pins = tuple(
        p if p.other is not None else replace(p, other_at=there(p.other_at)) for p in world.pins
    )
    touches = tuple(
        x if x.other is not None else replace(x, normal=Q @ x.normal, origin=there(x.origin))
        for x in world.touches
    )
    n = sum(chain_sizes(world))
    changed = replace(world, chains=chains, blows=blows, pins=pins, touches=touches)
    return Rewritten(changed, np.ones(n), np.zeros(n))


def mirrored(world: World, rng: np.random.Generator) -> Rewritten:
    """Its image in a mirror."""
    signs = np.where(np.arange(3) == rng.integers(3), -1.0, 1.0)
    S = np.diag(signs)

    def link_of(link: Link) -> Link:
        axis = signs * link.axis if link.slides else -signs * link.axis
        return replace(
            link, com=signs * link.com, inertia=S @ link.inertia @ S, turn=S @ link.turn @ S,
            at=signs * link.at, axis=axis,
        )  # fmt: skip

    def chain_of(chain: Chain) -> Chain:
        twice = np.concatenate([signs, -signs])
        return Chain(
            tuple(map(link_of, chain.links)), chain.free, S @ chain.turn @ S, signs * chain.at,
            S @ chain.base_turn @ S, signs * chain.base_at, twice * chain.base_velocity,
        )  # fmt: skip

    changed = replace(
        world,
        chains=tuple(map(chain_of, world.chains)),
        blows=tuple(
            replace(b, at=signs * b.at, linear=signs * b.linear, angular=-signs * b.angular)
            for b in world.blows
        ),
        pins=tuple(replace(p, at=signs * p.at, other_at=signs * p.other_at) for p in world.pins),
        touches=tuple(
            replace(x, at=signs * x.at, normal=signs * x.normal, origin=signs * x.origin)
            for x in world.touches
        ),
    )
    ratio = _per_speed(world, signs, -signs, 1.0, 1.0)
    return Rewritten(changed, ratio, np.zeros(len(ratio)))


def boosted(world: World, rng: np.random.Generator) -> Rewritten | None:
    """All of it at another speed; None where something stands on the ground."""
    grounded = [x.other for x in world.touches] + [p.other for p in world.pins]
    if None in grounded or not all(chain.free for chain in world.chains):
        return None
    V = rng.normal(size=3)
    shift, chains = [], []
    for chain in world.chains:
        own = (chain.turn @ chain.base_turn).T @ V
        shift += [*own, 0.0, 0.0, 0.0, *[0.0] * (len(chain.links) - 1)]
        base = chain.base_velocity + np.concatenate([own, np.zeros(3)])
        chains.append(replace(chain, base_velocity=base))
    return Rewritten(replace(world, chains=tuple(chains)), np.ones(len(shift)), np.array(shift))


def in_other_units(world: World, rng: np.random.Generator) -> Rewritten:
    """Lengths, masses and times in other units."""
    L, M, T = 10.0 ** rng.uniform(-3, 3, 3)

    def link_of(link: Link) -> Link:
        slide = L if link.slides else 1.0
        return replace(
            link, mass=M * link.mass, com=L * link.com, inertia=M * L * L * link.inertia,
            at=L * link.at, angle=slide * link.angle, rate=slide / T * link.rate,
        )  # fmt: skip

    speeds = np.array([L / T] * 3 + [1.0 / T] * 3)
    changed = replace(
        world,
        chains=tuple(
            replace(
                c, links=tuple(map(link_of, c.links)), at=L * c.at, base_at=L * c.base_at,
                base_velocity=speeds * c.base_velocity,
            )
            for c in world.chains
        ),
        blows=tuple(
            replace(b, at=L * b.at, linear=M * L / T * b.linear, angular=M * L * L / T * b.angular)
            for b in world.blows
        ),
        pins=tuple(replace(p, at=L * p.at, other_at=L * p.other_at) for p in world.pins),
        touches=tuple(replace(x, at=L * x.at, origin=L * x.origin) for x in world.touches),
    )  # fmt: skip
    ratio = _per_speed(world, speeds[:3], speeds[3:], L / T, 1.0 / T)
    return Rewritten(changed, ratio, np.zeros(len(ratio)))


def shuffled(world: World, rng: np.random.Generator) -> Rewritten:
    """Its entries in another order."""
    n = sum(chain_sizes(world))
    orders: dict[str, Any] = {
        name: tuple(entries[i] for i in rng.permutation(len(entries)))
        for name in ("blows", "pins", "locks", "touches")
        if (entries := getattr(world, name)) is not None
    }
    return Rewritten(replace(world, **orders), np.ones(n), np.zeros(n))


def with_split_links(world: World, rng: np.random.Generator) -> Rewritten:
    """Each link in two parts, held together by a fixed joint."""
    chains = tuple(
        replace(c, links=tuple(split_link(link, rng) for link in c.links)) for c in world.chains
    )
    n = sum(chain_sizes(world))
    return Rewritten(replace(world, chains=chains), np.ones(n), np.zeros(n))


def swapped(world: World, rng: np.random.Generator) -> Rewritten | None:
    """Contacts seen from the other body; None where there is none between two."""
    if not any(touch.other is not None for touch in world.touches):
        return None
    scene, q, _ = built(world)
    robot = scene.robot
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)

    def pose(place: Place) -> pin.SE3:
        return data.oMf[robot.frame_id(f"c{place[0]}/l{place[1]}")]

    def touch_of(touch: Touch) -> Touch:
        if touch.other is None:
            return touch
        own, other = pose(touch.link), pose(touch.other)
        return replace(
            touch, link=touch.other, other=touch.link, at=other.actInv(own.act(touch.at)),
            normal=-own.rotation.T @ (other.rotation @ touch.normal), origin=touch.at,
        )  # fmt: skip

    n = sum(chain_sizes(world))
    changed = replace(world, touches=tuple(map(touch_of, world.touches)))
    return Rewritten(changed, np.ones(n), np.zeros(n))


REWRITTEN: dict[str, Callable[[World, np.random.Generator], Rewritten | None]] = {
    "moved": moved,
    "mirrored": mirrored,
    "boosted": boosted,
    "units": in_other_units,
    "order": shuffled,
    "split": with_split_links,
    "swapped": swapped,
}


def _by_solver(world: World) -> Told:
    scene, q, v = built(world)
    solver = ImpactSolver(scene)
    solver.solve(q, -v)
    return told(lambda: solver.solve(q, v))


def judged(
    first: Told, other: Told, back: np.ndarray | None, scale: float, bar: float
) -> tuple[str, str, float]:
    """Status, verdict and error of another way, whose v⁺ is ``back`` in the first one's words."""
    error = math.nan
    if first.lawful and other.lawful and first.after is not None and back is not None:
        error = float(np.abs(back - first.after).max()) / scale
    if not (first.valid and other.valid) or "several" in (first.others, other.others):
        # One of them says that it has no answer, or that it has others.
        return other.status, "said so", error
    if not error > bar:
        return other.status, "right", error
    return other.status + " moved", "wrong", error


def condition_of(
    scene: Scene, q: np.ndarray, v: np.ndarray, first: Told, rng: np.random.Generator
) -> float:
    """By how much small changes of the state are amplified."""
    if first.after is None:
        return 1.0
    model = scene.robot.model
    largest = 1.0
    scale = max(float(np.abs(v).max()), float(np.abs(first.after).max()))
    for _ in range(3):
        near = pin.integrate(model, q, NUDGE * rng.normal(size=model.nv))
        speeds = v + NUDGE * scale * rng.normal(size=model.nv)
        other = told(lambda q=near, v=speeds: solve(scene, q, v))  # type: ignore[misc]
        if other.after is None or other.status != first.status:
            return math.inf
        largest = max(largest, float(np.abs(other.after - first.after).max()) / (NUDGE * scale))
    return largest


def points_of(
    first: Told,
    found: Sequence[tuple[str, Told, np.ndarray | None]],
    condition: float,
    speeds: Sequence[np.ndarray],
) -> list[Point]:
    """The points of other ways, by name, whose v⁺ is the last in the first one's words.

    Args:
        speeds: besides the answer's those that errors are relative to.
    """
    bar = max(SAME, ALLOWED * condition * EPS)
    scale = max(float(np.abs(one).max()) for one in (*speeds, first.after) if one is not None)
    points = []
    for name, one, back in found:
        status, verdict, error = judged(first, one, back, scale, bar)
        share = error / (condition * EPS)
        condition_told = min(condition, LARGEST)
        points.append(
            seen(0, name, status, verdict, one.seconds, error=error, condition=condition_told,
                 share=share)
        )  # fmt: skip
    return points


@SWEEPS.of("rewritten", "contacts", (1.0, 2.0, 3.0, 4.0), 2500, logarithmic=False)
def rewritten_points(value: float, rng: np.random.Generator) -> list[Point]:
    """Chains with so many contacts, all laws: however it is written, v⁺ is the same."""
    world = random_world(int(value), rng)
    scene, q, v = built(world)
    first = told(lambda: solve(scene, q, v), others=True)
    found: list[tuple[str, Told, np.ndarray | None]] = []
    for name, rewrite in REWRITTEN.items():
        other = rewrite(world, rng)
        if other is None:
            continue
        one = told(lambda other=other: solve(*built(other.world)))  # type: ignore[misc]
        back = None if one.after is None else (one.after - other.shift) / other.ratio
        found.append((name, one, back))
    (one,) = told_by_batch(scene, q[None], v[None])
    found.append(("batch", one, one.after))
    one = _by_solver(world)
    found.append(("solver", one, one.after))
    return points_of(first, found, condition_of(scene, q, v, first, rng), [v])


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
    first = told(lambda: solve(scene, q, v), others=True)
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
