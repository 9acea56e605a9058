"""Controlled joints that run into their own stop: there the stop is the stiffer of the two."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..geometry.gaps import before_limit, is_closed
from ..scene import JointStop, Scene

__all__ = ["YieldingControls", "own_stops"]


class _OwnStop(NamedTuple):
    """A stop of a controlled joint: its place among the contacts, where it acts, its limits."""

    entry: int
    joint: str
    at_q: int
    at_v: int
    limits: tuple[float, float]


def own_stops(scene: Scene) -> tuple[_OwnStop, ...]:
    """The stops of a scene's controlled joints."""
    model, found = scene.robot.model, []
    for index, entry in enumerate(scene.contacts):
        if isinstance(entry, JointStop) and entry.joint in scene.controlled:
            joint = model.joints[scene.robot.joint_id(entry.joint)]
            limits = entry.limits(scene.robot)
            found.append(_OwnStop(index, entry.joint, joint.idx_q, joint.idx_v, limits))
    return tuple(found)


class YieldingControls:
    """Which controlled joints run into their stop, and the scene in which they are free.

    A joint whose control keeps its velocity and whose stop turns it back has no solution; a
    motor and its gear give way before a stop does.
    """

    def __init__(self, stops: tuple[_OwnStop, ...]) -> None:
        self._stops = stops

    def scene(
        self, scene: Scene, q: np.ndarray, v: np.ndarray, touching: Container[int] | None = None
    ) -> Scene:
        """The scene without the control of joints that approach a stop they touch.

        Args:
            q, v: (nq,), (nv,) configuration, and velocity before the impact.
            touching: the contacts that take part, each stop at its nearer limit; None for all
                that are at a limit or past it.
        """
        pressed = {stop.joint for stop in self._stops if _is_pressed(stop, q, v, touching)}
        if not pressed:
            return scene
        return replace(
            scene, controlled=tuple(name for name in scene.controlled if name not in pressed)
        )


def _is_pressed(
    stop: _OwnStop, q: np.ndarray, v: np.ndarray, touching: Container[int] | None
) -> bool:
    at, speed = float(q[stop.at_q]), float(v[stop.at_v])
    sides = list(zip(stop.limits, (1.0, -1.0), strict=True))
    if touching is not None:
        if stop.entry not in touching:
            return False
        sides = [min(sides, key=lambda side: before_limit(at, *side))]
    else:
        sides = [
            (limit, sign)
            for limit, sign in sides
            if is_closed(before_limit(at, limit, sign), limit)
        ]
    return any(sign * speed < 0.0 for _, sign in sides)
