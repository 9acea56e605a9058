"""A scene with what is driven in time as it is at one time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from .constraints import JointLock
from .driven import Driven
from .entries import Constraint
from .functions import call, numbers_from
from .scene import Scene


def is_driven(constraint: Any) -> bool:
    """Return whether a constraint prescribes something that changes with time."""
    return isinstance(constraint, Driven) or callable(getattr(constraint, "velocity", None))


def scene_at(scene: Scene, t: float) -> Scene:
    """Return the scene with what is driven in time as at a time [s]; itself where nothing is."""
    if not any(map(is_driven, scene.constraints)):
        return scene
    names = scene.entry_names("constraints")
    return replace(
        scene,
        constraints=[
            constraint_at(entry, name, t)
            for entry, name in zip(scene.constraints, names, strict=True)
        ],
    )


def constraint_at(entry: Constraint, name: str, t: float) -> Constraint:
    """Return a constraint with the velocity that it prescribes at a time [s]."""
    if isinstance(entry, Driven):
        return JointLock(entry.joint, velocity=entry.rate(t), name=name)
    velocity = entry.velocity
    if callable(velocity):
        given = np.atleast_1d(velocity_at(velocity, name, t))
        value = float(given[0]) if given.size == 1 else tuple(given.tolist())
        return replace(entry, velocity=value, name=name)
    return entry


def at_rest(entry: Constraint) -> Constraint:
    """Return a constraint that lets nothing move."""
    if isinstance(entry, Driven):
        return JointLock(entry.joint, name=entry.name)
    return replace(entry, velocity=0.0)


def velocity_at(velocity: Callable[[float], Any], name: str, t: float) -> Any:
    """Return the velocity of a constraint by its function: one number or several."""
    what = f"{name}: velocity at t = {t:g}"
    size = np.size(call(velocity, what, t))
    return numbers_from(velocity, what, max(size, 1), t)
