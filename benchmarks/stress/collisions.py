"""Sweeps of bodies whose points of contact come from their shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from benchmarks.truths.found import Exact, Found
from benchmarks.truths.impacts import Impacts
from benchmarks.truths.residuals import Residuals
from impulsekit.robot import Robot
from impulsekit.robot.combine import combine
from impulsekit.scene import Collision, Contact, Scene

from ..urdf import one_body, solid_box
from .bodies import random_state
from .sweep import STATES, Case, Sweeps, decades

SWEEPS = Sweeps()
DEPTHS = (0.0, *decades(-15, -7, 2), 1e-6, 1e-5, 1e-4, 1e-3)

Points = Callable[[np.ndarray], list[Contact]]


def _ball(name: str, radius: float, mass: float) -> Robot:
    return one_body(name, mass, 0.4 * mass * radius * radius, f'<sphere radius="{radius!r}"/>')


class _Known:
    """The truth where the points of contact are known in closed form at each state."""

    def __init__(self, scene: Scene, points: Points) -> None:
        self._scene, self._points = scene, points

    def at(self, q: np.ndarray, v: np.ndarray) -> _Points:
        """The equations at a state."""
        contacts = self._points(q)
        turn = _rotation(q[3:7])
        places = [q[:3] + turn @ contact.at for contact in contacts]
        return _Points(Impacts(replace(self._scene, contacts=contacts)).at(q, v), places)


class _Points:
    """The equations of contacts whose order an answer does not know.

    An answer may tell the sum over the points alone. Then the impulses of the last one that told
    them stand in: where they and its Δv obey the equations, its Δv is right.
    """

    def __init__(self, state: Any, places: list[np.ndarray]) -> None:
        self._state, self._places = state, places
        self._told: tuple[np.ndarray, ...] | None = None

    def exact(self, found: Found | None = None) -> Exact | None:
        """The solution beside an answer."""
        return self._state.exact(self._sorted(found))

    def residuals(self, found: Found) -> Residuals:
        """What an answer leaves of its equations."""
        return self._state.residuals(self._sorted(found))

    def own_axes(self, found: Found) -> Any:
        """The impulses of an answer in the axes of the truth; None where they are summed up."""
        return None if self._is_summed(found) else self._state.own_axes(self._sorted(found))

    def _is_summed(self, found: Found) -> bool:
        count = len(self._places)
        return count > 1 and (found.places is None or len(found.places) != count)

    def _sorted(self, found: Found | None) -> Found | None:
        """The answer with its impulses in the order of the truth's points, if it has them."""
        if found is None or found.contacts is None or len(self._places) == 1:
            return found
        if self._is_summed(found) or found.places is None:
            return replace(found, contacts=self._told)
        given = np.array(found.places)
        order = [int(np.argmin(((given - own) ** 2).sum(axis=1))) for own in self._places]
        self._told = tuple(found.contacts[i] for i in order)
        return replace(found, contacts=self._told)


def _coefficients(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "restitution": float(rng.choice([0.0, 0.5, 1.0])),
        "friction": float(rng.choice([0.0, 0.3, 0.8])),
    }


def _rotation(quaternion: np.ndarray) -> np.ndarray:
    return pin.Quaternion(np.array(quaternion)).toRotationMatrix()


@SWEEPS.of("balls-meet", "depth [m]", DEPTHS, 30, logarithmic=False)
def balls_meet(depth: float, rng: np.random.Generator) -> Case:
    """Two balls that reach that deep into each other."""
    radii = rng.uniform(0.05, 0.5, 2)
    names = ("a", "b")
    balls = [
        _ball(n, float(r), float(rng.uniform(0.2, 3))) for n, r in zip(names, radii, strict=True)
    ]
    world = combine(a=balls[0], b=balls[1])
    laws = _coefficients(rng)
    scene = Scene(world, contacts=[Collision("a/a", "b/b", **laws)])
    q, v = random_state(world, rng, STATES)
    for state, speed in zip(q, v, strict=True):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        state[:3] = rng.uniform(-1, 1, 3)
        state[7:10] = state[:3] - (radii.sum() - depth) * direction
        turn = _rotation(state[3:7])
        # Whatever they do else, they approach.
        speed[:3] -= turn.T @ direction * (2.0 + rng.random())

    def points(state: np.ndarray) -> list[Contact]:
        between = state[:3] - state[7:10]
        far = np.linalg.norm(between)
        normal = between / far
        middle = state[:3] - normal * (radii[0] + 0.5 * (far - radii.sum()))
        first, other = (_rotation(state[i : i + 4]) for i in (3, 10))
        return [
            Contact(
                "a/a",
                at=first.T @ (middle - state[:3]),
                normal=other.T @ normal,
                against="b/b",
                **laws,
            )
        ]

    return Case(scene, q, v, _Known(scene, points))


@SWEEPS.of("ball-on-slab", "depth [m]", DEPTHS, 30, logarithmic=False)
def ball_on_floor(depth: float, rng: np.random.Generator) -> Case:
    """A ball that reaches that deep into the top of a floating slab."""
    radius, size = float(rng.uniform(0.05, 0.5)), rng.uniform(0.5, 2.0, 3)
    mass = float(rng.uniform(0.2, 3))
    world = combine(
        a=_ball("a", radius, mass), b=solid_box("b", float(rng.uniform(1, 9)), size.tolist())
    )
    laws = _coefficients(rng)
    scene = Scene(world, contacts=[Collision("a/a", "b/b", **laws)])
    q, v = random_state(world, rng, STATES)
    for state, speed in zip(q, v, strict=True):
        slab, turn = _rotation(state[10:14]), _rotation(state[3:7])
        foot = np.array([*(0.4 * size[:2] * rng.uniform(-1, 1, 2)), 0.5 * size[2] + radius - depth])
        state[:3] = state[7:10] + slab @ foot
        speed[:3] -= turn.T @ slab[:, 2] * (3.0 + rng.random())

    def points(state: np.ndarray) -> list[Contact]:
        slab, turn = _rotation(state[10:14]), _rotation(state[3:7])
        place = slab.T @ (state[:3] - state[7:10])
        gap = place[2] - radius - 0.5 * size[2]
        down = -slab[:, 2] * (radius + 0.5 * gap)
        return [Contact("a/a", at=turn.T @ down, against="b/b", **laws)]

    return Case(scene, q, v, _Known(scene, points))


@SWEEPS.of("box-on-box", "depth [m]", DEPTHS, 20, logarithmic=False)
def box_on_box(depth: float, rng: np.random.Generator) -> Case:
    """A box that reaches that deep into the top of a larger one, flat on it, at four corners."""
    size, lower = rng.uniform(0.1, 0.4, 3), rng.uniform(1.0, 2.0, 3)
    world = combine(
        a=solid_box("a", float(rng.uniform(0.2, 3)), size.tolist()),
        b=solid_box("b", float(rng.uniform(1, 9)), lower.tolist()),
    )
    laws = _coefficients(rng)
    scene = Scene(world, contacts=[Collision("a/a", "b/b", **laws)])
    q, v = random_state(world, rng, STATES)
    for state, speed in zip(q, v, strict=True):
        slab = _rotation(state[10:14])
        angle = float(rng.uniform(-3, 3))
        on_it = slab @ pin.utils.rotate("z", angle)
        state[3:7] = pin.Quaternion(on_it).coeffs()
        foot = np.array([*(0.2 * rng.uniform(-1, 1, 2)), 0.5 * (lower[2] + size[2]) - depth])
        state[:3] = state[7:10] + slab @ foot
        speed[:3] -= on_it.T @ slab[:, 2] * (3.0 + rng.random())

    def points(state: np.ndarray) -> list[Contact]:
        # Halfway between the faces.
        z = 0.5 * (depth - size[2])
        corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
        return [
            Contact("a/a", at=(x * size[0], y * size[1], z), against="b/b", **laws)
            for x, y, z in corners
        ]

    return Case(scene, q, v, _Known(scene, points))
