"""Worlds of a few chains of links as plain numbers, so that they can be written in other ways."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import AppliedImpulse, Contact, JointLock, Law, PointAnchor, Scene

from ..urdf import joint_text, link_text, robot_text

Array = np.ndarray
# Limits of joints [rad, m]: nothing gets there.
FAR = 1e9
Place = tuple[int, int]
"""Which chain, and which of its links."""


@dataclass(frozen=True, eq=False)
class Link:
    """A link behind its joint, at the joint's frame.

    Attributes:
        mass, com, inertia: [kg], (3,) [m], (3, 3) about the centre of mass [kg m²].
        turn, at: (3, 3), (3,) of the joint's frame in the parent link.
        axis: (3,) of the joint; slides: whether it is prismatic.
        angle, rate: of the joint; both unused of a free chain's first link.
        extra: what of the link hangs on it by a fixed joint: mass, com and inertia.
    """

    mass: float
    com: Array
    inertia: Array
    turn: Array
    at: Array
    axis: Array
    slides: bool
    angle: float
    rate: float
    extra: tuple[float, Array, Array] | None = None


@dataclass(frozen=True, eq=False)
class Chain:
    """Links in a row, free or on the ground.

    Attributes:
        links: of which the first is the base of a free chain.
        free: whether nothing holds it.
        turn, at: (3, 3), (3,) where the world has its root.
        base_turn, base_at, base_velocity: (3, 3), (3,), (6,) of the first link where it is free.
    """

    links: tuple[Link, ...]
    free: bool
    turn: Array
    at: Array
    base_turn: Array
    base_at: Array
    base_velocity: Array


@dataclass(frozen=True, eq=False)
class Touch:
    """A contact: ``other`` None is the world."""

    link: Place
    at: Array
    normal: Array
    origin: Array
    other: Place | None
    restitution: float
    friction: float
    swapped: bool = False


@dataclass(frozen=True, eq=False)
class Blow:
    """An impulse from outside, in world axes."""

    link: Place
    at: Array
    linear: Array
    angular: Array


@dataclass(frozen=True, eq=False)
class Pin:
    """A point of a link that goes with a point of another, or of the world."""

    link: Place
    at: Array
    other: Place | None
    other_at: Array


@dataclass(frozen=True, eq=False)
class World:
    """Chains, and what strikes, holds and touches them; ``locks`` are joints by their link."""

    chains: tuple[Chain, ...]
    blows: tuple[Blow, ...]
    pins: tuple[Pin, ...]
    locks: tuple[Place, ...]
    touches: tuple[Touch, ...]
    law: Law


def chain_sizes(world: World) -> list[int]:
    """nv of each chain."""
    return [len(chain.links) + (5 if chain.free else 0) for chain in world.chains]


def built(world: World) -> tuple[Scene, Array, Array]:
    """Scene, q, v of a world."""
    robots, placements, q, v = {}, {}, [], []
    for c, chain in enumerate(world.chains):
        robots[f"c{c}"] = Robot.from_urdf(_text(chain), root="freeflyer" if chain.free else "fixed")
        placements[f"c{c}"] = pin.SE3(chain.turn, chain.at)
        joints = chain.links
        if chain.free:
            q += [*chain.base_at, *pin.Quaternion(chain.base_turn).normalized().coeffs()]
            v += list(chain.base_velocity)
            joints = joints[1:]
        q += [link.angle for link in joints]
        v += [link.rate for link in joints]
    scene = Scene(
        combine(robots, placements=placements),
        [
            AppliedImpulse(_name(blow.link), linear=blow.linear, angular=blow.angular, at=blow.at)
            for blow in world.blows
        ],
        [
            *(
                PointAnchor(_name(p.link), _name(p.other), at=p.at, other_at=p.other_at)
                for p in world.pins
            ),
            *(JointLock(f"c{c}/j{k}") for c, k in world.locks),
        ],
        [
            Contact(
                _name(touch.link),
                at=touch.at,
                normal=touch.normal,
                origin=touch.origin,
                against=_name(touch.other),
                restitution=touch.restitution,
                friction=touch.friction,
            )
            for touch in world.touches
        ],
        law=world.law,
    )
    return scene, np.array(q), np.array(v)


def _name(place: Place | None) -> str:
    return "world" if place is None else f"c{place[0]}/l{place[1]}"


def _text(chain: Chain) -> str:
    parts = [] if chain.free else [link_text("ground")]
    for k, link in enumerate(chain.links):
        parts.append(_link(f"l{k}", link.mass, link.com, link.inertia))
        if link.extra is not None:
            parts.append(_link(f"x{k}", *link.extra))
            parts.append(joint_text(f"f{k}", "fixed", f"l{k}", f"x{k}"))
        if k or not chain.free:
            kind = "prismatic" if link.slides else "revolute"
            parent, roll = f"l{k - 1}" if k else "ground", pin.rpy.matrixToRpy(link.turn)
            parts.append(
                joint_text(
                    f"j{k}", kind, parent, f"l{k}", link.axis, at=link.at, turn=roll, far=FAR
                )
            )
    return robot_text("c", *parts)


def _link(name: str, mass: float, com: Array, inertia: Array) -> str:
    return link_text(name, mass, inertia[np.triu_indices(3)].tolist(), at=com)


def random_turn(rng: np.random.Generator) -> Array:
    """A rotation."""
    x, y, z, w = rng.normal(size=4)
    return pin.Quaternion(w, x, y, z).normalized().matrix()


def unit(x: Array) -> Array:
    """A direction."""
    return x / np.linalg.norm(x)


def _random_link(rng: np.random.Generator) -> Link:
    mass = float(10.0 ** rng.uniform(-2, 0))
    # Of some points, so that it is the inertia of a body.
    points = 0.3 * rng.normal(size=(5, 3))
    points -= points.mean(axis=0)
    inertia = mass / 5 * (np.sum(points**2) * np.eye(3) - points.T @ points)
    return Link(
        mass, 0.2 * rng.normal(size=3), inertia, random_turn(rng), 0.5 * rng.normal(size=3),
        unit(rng.normal(size=3)), bool(rng.random() < 0.25), float(rng.uniform(-1, 1)),
        float(rng.normal()),
    )  # fmt: skip


def random_world(count: int, rng: np.random.Generator) -> World:
    """One to three chains with that many contacts, at times blows, a pin or a lock."""
    chains = tuple(
        Chain(
            tuple(_random_link(rng) for _ in range(int(rng.integers(1, 4)))),
            bool(rng.random() < 0.6), random_turn(rng), rng.normal(size=3),
            random_turn(rng), rng.normal(size=3), rng.normal(size=6),
        )
        for _ in range(int(rng.integers(1, 4)))
    )  # fmt: skip
    places = [(c, k) for c, chain in enumerate(chains) for k in range(len(chain.links))]

    def place() -> Place:
        return places[int(rng.integers(len(places)))]

    def other_than(own: Place, share: float) -> Place | None:
        others = [one for one in places if one != own]
        if not others or rng.random() < share:
            return None
        return others[int(rng.integers(len(others)))]

    touches = []
    ground = 0.0 if all(chain.free for chain in chains) and rng.random() < 0.5 else 0.4
    for _ in range(count):
        link = place()
        other = other_than(link, ground)
        touches.append(
            Touch(
                link, 0.3 * rng.normal(size=3), unit(rng.normal(size=3)), rng.normal(size=3),
                other, float(rng.choice([0.0, 0.3, 0.7, 1.0])),
                float(rng.choice([0.0, 0.2, 0.6, 1.5])),
            )
        )  # fmt: skip
    blows = tuple(
        Blow(place(), 0.2 * rng.normal(size=3), rng.normal(size=3), 0.1 * rng.normal(size=3))
        for _ in range(int(rng.integers(0, 2)))
    )
    pins, locks = [], []
    if rng.random() < 0.2:
        link = place()
        pins.append(
            Pin(link, 0.3 * rng.normal(size=3), other_than(link, ground), rng.normal(size=3))
        )
    jointed = [(c, k) for c, k in places if k or not chains[c].free]
    if jointed and rng.random() < 0.2:
        locks.append(jointed[int(rng.integers(len(jointed)))])
    laws = [Law("newton", "end", "simultaneous"), Law("poisson", "end", "simultaneous"),
            Law("newton", "end", "sequential"), Law("poisson", "end", "sequential"),
            Law("newton", "path", "sequential"), Law("poisson", "path", "sequential"),
            Law("stronge", "path", "sequential")]  # fmt: skip
    law = laws[int(rng.integers(len(laws)))]
    return World(chains, blows, tuple(pins), tuple(locks), tuple(touches), law)


def split(link: Link, rng: np.random.Generator) -> Link:
    """The same link, a part of it behind a fixed joint, as near as leaves the rest an inertia."""
    share = float(rng.uniform(0.05, 0.5))
    away = 0.03 * rng.normal(size=3)
    found = _parted(link, share, away)
    while np.linalg.eigvalsh(found.inertia)[0] <= 0.0:
        away = 0.5 * away
        found = _parted(link, share, away)
    return found


def _parted(link: Link, share: float, away: np.ndarray) -> Link:
    mass, centre = share * link.mass, link.com + away
    rest = link.mass - mass
    other = (link.mass * link.com - mass * centre) / rest
    inertia, left = share * link.inertia, (1.0 - share) * link.inertia
    for part, at in ((mass, centre), (rest, other)):
        d = at - link.com
        left = left - part * (float(d @ d) * np.eye(3) - np.outer(d, d))
    return replace(link, mass=rest, com=other, inertia=left, extra=(mass, centre, inertia))
