"""A box of coefficients, poses and velocities, and its points as states of a scene."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, RangeError
from ..scene.numbers import number

if TYPE_CHECKING:
    from ..robot import Robot
    from ..scene import Scene

__all__ = ["Bounds", "Box", "bounds_of"]

# No larger friction is asked about: it holds all.
MOST_FRICTION = 1e9
# By ("restitution" or "friction", 0), or ("q" or "v", the entry that is offset).
Bounds = dict[tuple[str, int], tuple[float, float]]


def bounds_of(
    robot: Robot,
    what: str,
    restitution: Sequence[float] | None,
    friction: Sequence[float] | None,
    pose: Mapping[str, Sequence[float]],
    velocity: Mapping[str, Sequence[float]] | None = None,
) -> Bounds:
    """Return the sides of a box; ``what``: the function that a user called.

    Raises:
        UnknownNameError: no such joint. RangeError: bounds out of range or order.
        InputError: nothing is varied, or a joint has no single coordinate.
    """
    found: Bounds = {}
    if restitution is not None:
        found["restitution", 0] = _interval("restitution", restitution, 0.0, 1.0)
    if friction is not None:
        found["friction", 0] = _interval("friction", friction, 0.0, MOST_FRICTION)
    for kind, given in (("pose", pose), ("velocity", velocity or {})):
        for name, ends in given.items():
            entry = robot.model.joints[robot.joint_id(name)]
            if entry.nq != 1:
                raise InputError(f'{kind}: joint "{name}" has no single coordinate')
            key = ("q", int(entry.idx_q)) if kind == "pose" else ("v", int(entry.idx_v))
            found[key] = _interval(f'{kind}["{name}"]', ends, -math.inf, math.inf)
    if not found:
        more = "" if velocity is None else ", velocity="
        raise InputError(f"{what}: give restitution=, friction={more} or pose= to vary")
    return found


def _interval(name: str, ends: Sequence[float], least: float, most: float) -> tuple[float, float]:
    if len(ends) != 2:
        raise RangeError.of(name, ends, "two numbers, low and high")
    low, high = (number(x, name) for x in ends)
    if not least <= low <= high <= most:
        raise RangeError.of(name, (low, high), f"low <= high within {least:g} to {most:g}")
    return low, high


class Box:
    """The states of a scene at points of the unit cube that stands for the box."""

    def __init__(self, scene: Scene, q: np.ndarray, v: np.ndarray, bounds: Bounds) -> None:
        self.scene, self.q, self.v, self.bounds = scene, q, v, bounds

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
        """Return (K, nq) configurations and (K, nv) velocities at (K, n) points, coefficients."""
        count, coefficients = len(points), dict[str, Any]()
        states = {"q": np.tile(self.q, (count, 1)), "v": np.tile(self.v, (count, 1))}
        for t, ((kind, entry), (low, high)) in zip(points.T, self.bounds.items(), strict=True):
            values = low + t * (high - low)
            if kind in states:
                states[kind][:, entry] += values
            else:
                coefficients[kind] = values.tolist()
        return states["q"], states["v"], coefficients

    def by_contact(self, coefficients: Mapping[str, Any]) -> dict[str, Any]:
        """Return coefficients for each contact that has them, by name."""
        named = zip(self.scene.entry_names("contacts"), self.scene.contacts, strict=True)
        entries = dict(named)
        return {
            kind: {name: values for name, entry in entries.items() if hasattr(entry, kind)}
            for kind, values in coefficients.items()
        }
