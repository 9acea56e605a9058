"""Bodies in flight that meet: thin, fast and turning ones, drawn at random.

Each function takes what its sweep varies, and gives a ``Flight``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pinocchio as pin

from benchmarks.truths.flown import Flown, Gap, from_box, from_segment, turned
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import Collision, Contact, JointStop, Scene

from .bodies import ball, box, free_body, hung, rod, rounded_rod, slider
from .mechanisms import random_turn

# Clearances below it ask for places near the origin [m].
NEAR = 1e-6
_NONE = np.zeros(3)


@dataclass(frozen=True, eq=False)
class Flight:
    """A scene, its start, and the exact gap of its contact.

    Attributes:
        gap: at a time [m]; fastest: it closes no faster [m/s].
        duration: what is looked at [s].
        meets: when it first closes [s], infinity for never; None where ``gap`` is to tell.
    """

    scene: Scene
    q: np.ndarray
    v: np.ndarray
    gap: Gap
    fastest: float
    duration: float
    meets: float | None = None


def _power(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


def _anywhere(rng: np.random.Generator) -> pin.SE3:
    """A place in the world: the origin, or any other up to 100 m away, turned."""
    if rng.random() < 0.3:
        return pin.SE3.Identity()
    return pin.SE3(random_turn(rng), _power(rng, -1, 2) * rng.normal(size=3))


def _state(world: Robot, bodies: dict[str, Flown]) -> tuple[np.ndarray, np.ndarray]:
    """q and v of free bodies."""
    q, v = {}, {}
    for name, body in bodies.items():
        q[f"{name}/root_joint"] = [*body.at, *pin.Quaternion(body.turn).coeffs()]
        turn = body.turn.T
        v[f"{name}/root_joint"] = [*(turn @ body.velocity), *(turn @ body.spin)]
    return world.configuration(q), world.velocity(v)


def buffer(distance: float, rng: np.random.Generator) -> Flight:
    """A box on a slide runs at a plate, or one that comes along, from so far away."""
    size, thick = _power(rng, -3, 0), _power(rng, -4, 0)
    speed, other = _power(rng, -1, 3), float(rng.choice([0.0, -1.0])) * _power(rng, -1, 2)
    place = _anywhere(rng)
    far = distance + 0.5 * (size + thick)
    world = combine(
        a=slider("a", box(size, size, size)),
        b=slider("b", box(thick, 1, 1)),
        placements={"a": place, "b": place * pin.SE3(np.eye(3), np.array([far, 0.0, 0.0]))},
    )
    scene = Scene(world, contacts=[Collision("a/a", "b/b", restitution=0.5)], gravity=_NONE)
    closing = speed - other
    return Flight(
        scene,
        np.zeros(2),
        np.array([speed, other]),
        lambda t: distance - closing * t,
        closing,
        2.0 * distance / closing,
        distance / closing,
    )


def bullet(thickness: float, rng: np.random.Generator) -> Flight:
    """A small free body, spinning, flies at a plate that thick; with or without weight."""
    place = _anywhere(rng)
    speed, far = _power(rng, 0, 3), _power(rng, -0.5, 2)
    size = _power(rng, -3.5, -1)
    weight = np.array([0.0, 0.0, -9.81]) * float(rng.integers(2))
    if weight.any():
        # No arc so wide that it leads past the plate's edge.
        far = min(far, speed)
    start = place.act(np.array([-far, *rng.uniform(-0.1, 0.1, 2)]))
    way = place.rotation @ np.array([speed, 0.0, 0.0])
    spin = _power(rng, -1, 1.5) * speed / far * rng.normal(size=3)
    flown = Flown(start, way - 0.5 * far / speed * weight, random_turn(rng), spin, weight)
    if rng.random() < 0.5:
        shape, half = ball(size), _NONE
        reach = size
    else:
        half = size * rng.uniform(0.1, 1.0, 3)
        shape, reach = box(*(2.0 * half)), 0.0
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = signs * half
    normal, middle = place.rotation[:, 0], place.translation

    def gap(t: float) -> float:
        ahead = float((corners @ (flown.orientation(t).T @ normal)).max()) + reach
        return -float(normal @ (flown.centre(t) - middle)) - ahead - 0.5 * thickness

    duration = 2.0 * far / speed
    fastest = flown.speed(duration) + float(np.linalg.norm(spin) * np.linalg.norm(half))
    world = combine(
        a=free_body("a", shape),
        b=free_body("b", box(thickness, 40, 40), "fixed"),
        placements={"b": place},
    )
    scene = Scene(world, contacts=[Collision("a/a", "b/b", restitution=0.5)], gravity=weight)
    return Flight(scene, *_state(world, {"a": flown}), gap, fastest, duration)


def blade(thickness: float, rng: np.random.Generator) -> Flight:
    """A blade that thick turns about its middle, and a thin post comes slowly in."""
    place = _anywhere(rng)
    radius, rate = _power(rng, -3, -1), float(rng.choice([-1, 1])) * _power(rng, 0, 2)
    turns = _power(rng, -1, 1.3)
    far = 1.2 + radius
    speed = 1.2 / (turns * 2.0 * math.pi / abs(rate))
    angle = float(rng.uniform(-math.pi, math.pi))
    inwards = pin.SE3(pin.utils.rotate("z", angle), np.zeros(3))
    start = np.array([-far, float(rng.uniform(-0.5, 0.5)), 0.0])
    kind = str(rng.choice(["revolute", "continuous", "freeflyer"]))
    shape = box(2, thickness, 0.2)
    if kind == "freeflyer":
        one = free_body("a", shape)
    else:
        one = hung("a", shape, ("turn", kind, "0 0 1", "0 0 0"))
    post = slider("b", rod(radius, 1.0) if rng.random() < 0.5 else ball(radius))
    at = {"b": place * inwards * pin.SE3(np.eye(3), start)}
    if kind != "freeflyer":
        at["a"] = place
    world = combine(a=one, b=post, placements=at)
    if kind == "freeflyer":
        spin = place.rotation @ np.array([0.0, 0.0, rate])
        flown = Flown(place.translation, _NONE, place.rotation, spin, _NONE)
        q, v = _state(world, {"a": flown})
    else:
        q, v = world.neutral(), world.velocity({"a/turn": rate})
    v = v + world.velocity({"b/x": speed})
    half = np.array([1.0, 0.5 * thickness, 10.0])
    first, along = inwards.act(start), inwards.rotation[:, 0]

    def gap(t: float) -> float:
        turn = turned(np.array([0.0, 0.0, rate]), t)
        return from_box(turn.T @ (first + t * speed * along), half) - radius

    scene = Scene(world, contacts=[Collision("a/a", "b/b", restitution=1.0)], gravity=_NONE)
    return Flight(scene, q, v, gap, speed + abs(rate) * 2.0, 2.4 / speed)


def tip(rate: float, rng: np.random.Generator) -> Flight:
    """The tip of an arm that turns steadily comes down on a plane, turn by turn lower."""
    place = _anywhere(rng)
    kind = str(rng.choice(["revolute", "continuous", "freeflyer", "two hinges"]))
    turns = _power(rng, -1, 2)
    down = 2.0 / (turns * 2.0 * math.pi / rate)
    axis, arm = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])
    height = 2.0
    normal, origin = place.rotation[:, 2], place.translation
    contact = partial(Contact, normal=normal, origin=origin, restitution=0.5)
    if kind == "two hinges":
        # Each link about its own middle: no turning feels the other.
        second = float(rng.uniform(0.2, 0.95)) * rate * float(rng.choice([-1, 1]))
        low = float(rng.uniform(0.01, 0.3))
        lengths = np.array([1.0, 0.5])
        joints = (
            ("h1", "revolute", "1 0 0", (0, 0, 1.5 - low)),
            ("h2", "continuous", "1 0 0", "0 0 1"),
        )
        world = combine(a=hung("a", "", *joints), placements={"a": place})
        v = world.velocity({"a/h1": rate, "a/h2": second - rate})

        def two(t: float) -> float:
            return 1.5 - low + math.cos(rate * t) + 0.5 * math.cos(second * t)

        scene = Scene(world, contacts=[contact("a/a", at=(0, 0, 0.5))], gravity=_NONE)
        fastest = float(lengths @ np.abs([rate, second]))
        return Flight(scene, world.neutral(), v, two, fastest, 400.0 / rate)
    if kind == "freeflyer":
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        arm = rng.normal(size=3)
        arm /= np.linalg.norm(arm)
        world = combine(a=free_body("a", ""))
        velocity = place.rotation @ np.array([0.0, 0.0, -down])
        at = place.act(np.array([0.0, 0.0, height]))
        flown = Flown(at, velocity, place.rotation, place.rotation @ axis * rate, _NONE)
        q, v = _state(world, {"a": flown})
    else:
        down_and_round = (("z", "prismatic", "0 0 1", "0 0 0"), ("h", kind, "1 0 0", "0 0 0"))
        world = combine(a=hung("a", "", *down_and_round), placements={"a": place})
        q = world.configuration({"a/z": height})
        v = world.velocity({"a/z": -down, "a/h": rate})
    scene = Scene(world, contacts=[contact("a/a", at=arm)], gravity=_NONE)

    def gap(t: float) -> float:
        return height - down * t + float((turned(rate * axis, t) @ arm)[2])

    return Flight(scene, q, v, gap, down + rate, 2.5 * height / down)


def stop(speed: float, rng: np.random.Generator) -> Flight:
    """A slide or hinge runs into its limit that fast, under weight where it slides."""
    kind = str(rng.choice(["prismatic", "revolute"]))
    robot = hung("a", "", ("j", kind, "0 0 1", "0 0 0"))
    far = _power(rng, -3, 3)
    sign = float(rng.choice([-1, 1]))
    weight = 9.81 if kind == "prismatic" and rng.random() < 0.5 else 0.0
    # Weight that works against it must not turn it back.
    weight = min(weight, 0.4 * speed * speed / far)
    upper, lower = (far, None) if sign > 0 else (None, -far)
    struck = JointStop("j", upper=upper, lower=lower, restitution=0.5)
    scene = Scene(robot, contacts=[struck], gravity=[0, 0, -weight])
    slowed = sign * weight
    meets = 2.0 * far / (speed + math.sqrt(speed * speed - 2.0 * slowed * far))
    return Flight(
        scene,
        np.zeros(1),
        np.array([sign * speed]),
        lambda t: far - speed * t + 0.5 * slowed * t * t,
        2.0 * speed + weight,
        2.0 * meets,
        meets,
    )


def meeting(thickness: float, rng: np.random.Generator) -> Flight:
    """Two free bodies, a thin one among them, spin and meet on their ways."""
    middle, when = _anywhere(rng).translation, _power(rng, -1, 1.5)
    weight = np.array([0.0, 0.0, -9.81]) * float(rng.integers(2))
    radius = _power(rng, -3, -1)
    half = np.array([0.5, 0.5 * thickness, float(rng.choice([0.5, 0.5 * thickness]))])
    flown = []
    for spins in (1.5, 0.5):
        velocity = _power(rng, -1, 1.5) * rng.normal(size=3)
        spin = _power(rng, -1, spins) / when * rng.normal(size=3)
        flown.append(Flown(middle - when * velocity, velocity, random_turn(rng), spin, weight))
    one, two = flown
    if rng.random() < 0.5:
        thin = free_body("a", box(*(2.0 * half)))
        distance: Callable[[np.ndarray], float] = partial(from_box, half=half)
    else:
        thin = rounded_rod("a", 0.5 * thickness, 1.0)
        axis = np.array([0.0, 0.0, 1.0])
        distance = lambda point: from_segment(point, 0.5, axis) - 0.5 * thickness  # noqa: E731

    def gap(t: float) -> float:
        # Their fall is one and the same.
        apart = two.at - one.at + t * (two.velocity - one.velocity)
        return distance(one.orientation(t).T @ apart) - radius

    names = {"a": one, "b": two}
    world = combine(a=thin, b=free_body("b", ball(radius)))
    scene = Scene(world, contacts=[Collision("a/a", "b/b", restitution=0.5)], gravity=weight)
    closing = float(np.linalg.norm(one.velocity - two.velocity))
    return Flight(
        scene,
        *_state(world, names),
        gap,
        closing + float(np.linalg.norm(one.spin)) * (0.8 + radius + thickness),
        2.0 * when,
    )


def turning_plane(rate: float, rng: np.random.Generator) -> Flight:
    """A point of one spinning body meets a plane of another that spins so fast."""
    middle = _anywhere(rng).translation
    when = _power(rng, -1, 1.5) / max(1.0, 0.1 * rate)
    flown = []
    for spin in (rate, _power(rng, -1, 1.0)):
        way = rng.normal(size=3)
        velocity, axis = _power(rng, -1, 0.5) * rng.normal(size=3), way / np.linalg.norm(way)
        flown.append(
            Flown(middle - when * velocity, velocity, random_turn(rng), spin * axis, _NONE)
        )
    plane, body = flown
    normal, at = rng.normal(size=3), rng.uniform(-0.5, 0.5, 3)
    normal /= np.linalg.norm(normal)
    origin = rng.uniform(-0.3, 0.3, 3)
    # On the open side at the start.
    if normal @ (plane.turn.T @ (body.at + body.turn @ at - plane.at) - origin) < 0:
        normal = -normal

    def gap(t: float) -> float:
        point = body.at - plane.at + t * (body.velocity - plane.velocity)
        point = point + body.orientation(t) @ at
        return float(normal @ (plane.orientation(t).T @ point - origin))

    names = {"a": body, "b": plane}
    world = combine(a=free_body("a", ""), b=free_body("b", ""))
    contact = Contact("a/a", at=at, against="b/b", normal=normal, origin=origin, restitution=0.5)
    scene = Scene(world, contacts=[contact], gravity=_NONE)
    closing = float(np.linalg.norm(body.velocity - plane.velocity))
    arm = when * closing + 1.0
    fastest = closing + rate * arm + float(np.linalg.norm(body.spin)) * 0.9
    return Flight(scene, *_state(world, names), gap, fastest, when)


def graze(clearance: float, rng: np.random.Generator) -> Flight:
    """A tip that turns over a plane, or a ball that passes one, nearly touches, or just does."""
    place = _anywhere(rng)
    if abs(clearance) < NEAR and place.translation.any():
        # Elsewhere in the world rounding is as large.
        place.translation = place.translation / np.linalg.norm(place.translation)
    if rng.random() < 0.5:
        rate, start = _power(rng, -1, 2), float(rng.uniform(0.3, 6.0))
        arm = turned(np.array([start, 0.0, 0.0]), 1.0).T @ np.array([0.0, 0.0, -1.0])
        hinged = hung("a", "", ("h", "revolute", "1 0 0", "0 0 0"))
        world = combine(a=hinged, placements={"a": place})
        origin = place.act(np.array([0.0, 0.0, -1.0 - clearance]))
        contact = Contact("a/a", at=arm, normal=place.rotation[:, 2], origin=origin)
        scene = Scene(world, contacts=[contact], gravity=_NONE)
        angle = 2.0 * math.asin(math.sqrt(max(-clearance, 0.0) / 2.0))

        def over(t: float) -> float:
            return clearance + 2.0 * math.sin(0.5 * (rate * t - start)) ** 2

        meets = (start - angle) / rate if clearance < 0.0 else math.inf
        q, v = world.neutral(), world.velocity({"a/h": rate})
        return Flight(scene, q, v, over, rate, (start + 4.0) / rate, meets)
    radii = rng.uniform(0.01, 0.5, 2)
    total, speed, far = float(radii.sum()), _power(rng, -1, 2), _power(rng, 0, 1)
    beside = total + clearance
    world = combine(
        a=slider("a", ball(float(radii[0]))),
        b=free_body("b", ball(float(radii[1])), "fixed"),
        placements={
            "a": place,
            "b": place * pin.SE3(np.eye(3), np.array([far, beside, 0.0])),
        },
    )
    scene = Scene(world, contacts=[Collision("a/a", "b/b")], gravity=_NONE)

    def past(t: float) -> float:
        return math.hypot(far - speed * t, beside) - total

    before = math.sqrt(max(-clearance * (total + beside), 0.0))
    meets = (far - before) / speed if clearance < 0.0 else math.inf
    return Flight(scene, np.zeros(1), np.array([speed]), past, speed, 2.0 * far / speed, meets)
