"""Motions in long numbers: Kane's equations, integrated by extrapolation.

Each step is Gragg's modified midpoint rule with 2, 4, 6, … parts, extrapolated in the square
of their length (Bulirsch & Stoer 1966) until two columns agree, so the order grows as far as
the digits ask for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from impulsekit.checking.system import ReferenceRobot, reference_robot
from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Arithmetic
from impulsekit.scene import Scene

from .digits import velocity_after

MOST_COLUMNS = 24


def state_after_flight(
    scene: Scene,
    q: np.ndarray,
    v: np.ndarray,
    duration: float,
    *,
    steps: int,
    digits: int = 40,
    accuracy: str = "1e-25",
) -> Any:
    """(nq + nv,) q and v after the scene's known impulses and a free motion under gravity.

    Args:
        steps: of equal length.
        accuracy: of each step, relative to the state.

    Raises:
        ArithmeticError: a step is too long to converge.
    """
    reference = reference_robot(scene.robot, Arithmetic.mpmath(digits))
    numbers = reference.system.arithmetic
    start = numbers.array(v)
    if scene.impulses:
        start = velocity_after(scene, q, v, digits)
    y = np.concatenate([numbers.array(q), start])
    size = len(q)
    gravity = numbers.array(scene.gravity)

    def rates(y: Any) -> Any:
        # Within a step the rule leaves the circle and the sphere.
        q, v = _units(reference, y[:size]), y[size:]
        speeds = _configuration_rates(reference, q, v)
        return np.concatenate([speeds, reference.system.accelerations(q, v, gravity)])

    step = numbers.number(duration) / steps
    for _ in range(steps):
        y = extrapolated(rates, y, step, numbers.number(accuracy))
        y[:size] = _units(reference, y[:size])
    return y


def extrapolated(rates: Callable[[Any], Any], y: Any, step: Any, accuracy: Any) -> Any:
    """The state after one step of y' = rates(y).

    Raises:
        ArithmeticError: the columns do not come to agree.
    """
    first = rates(y)
    scale = max(abs(entry) for entry in y)
    table: list[Any] = []
    for column in range(1, MOST_COLUMNS + 1):
        parts = 2 * column
        row = [_midpoint(rates, y, first, step, parts)]
        for k, before in enumerate(table):
            ratio = (step * 0 + parts) ** 2 / (2 * (column - 1 - k)) ** 2
            row.append(row[k] + (row[k] - before) / (ratio - 1))
        if table and max(abs(d) for d in row[-1] - row[-2]) <= accuracy * scale:
            return row[-1]
        table = row
    raise ArithmeticError("the step is too long")


def _midpoint(rates: Callable[[Any], Any], y: Any, first: Any, step: Any, parts: int) -> Any:
    """Gragg's rule."""
    h = step / parts
    before, now = y, y + h * first
    for _ in range(parts - 1):
        before, now = now, before + 2 * h * rates(now)
    return (before + now + h * rates(now)) / 2


def _configuration_rates(reference: ReferenceRobot, q: Any, v: Any) -> Any:
    """(nq,) q' of speeds v (nv,)."""
    numbers = reference.system.arithmetic
    out = numbers.zeros(len(q))
    for kind, c, s in _joints(reference):
        if kind in ("revolute", "prismatic"):
            out[c] = v[s]
        elif kind == "continuous":
            out[c], out[c + 1] = -q[c + 1] * v[s], q[c] * v[s]
        elif kind == "planar":
            cosine, sine = q[c + 2], q[c + 3]
            out[c], out[c + 1] = cosine * v[s] - sine * v[s + 1], sine * v[s] + cosine * v[s + 1]
            out[c + 2], out[c + 3] = -sine * v[s + 2], cosine * v[s + 2]
        else:
            unit = q[c + 3 : c + 7]
            out[c : c + 3] = rotation.of_quaternion(unit, numbers) @ v[s : s + 3]
            out[c + 3 : c + 7] = _quaternion_rate(numbers, unit, v[s + 3 : s + 6])
    return out


def _quaternion_rate(numbers: Arithmetic, unit: Any, spin: Any) -> Any:
    """½ unit ∘ (spin, 0), x, y, z, w; spin in body axes."""
    vector, scalar = unit[:3], unit[3]
    turned = np.cross(vector, spin) + scalar * spin
    half = numbers.number(1) / 2
    return np.array([*(half * turned), -half * (vector @ spin)], dtype=object)


def _units(reference: ReferenceRobot, q: Any) -> Any:
    """Unit vectors and quaternions back at length one."""
    out, numbers = q.copy(), reference.system.arithmetic
    for kind, c, _ in _joints(reference):
        at = {"continuous": (c, c + 2), "planar": (c + 2, c + 4), "free": (c + 3, c + 7)}.get(kind)
        if at is not None:
            out[slice(*at)] = q[slice(*at)] / numbers.norm(q[slice(*at)])
    return out


def _joints(reference: ReferenceRobot) -> Iterable[tuple[str, int, int]]:
    """Kind, first coordinate and first speed of each joint that moves."""
    for body in reference.system.bodies:
        joint = body.joint
        if len(joint.linear) and not joint.mimics:
            known = ("revolute", "prismatic", "continuous", "planar")
            kind = joint.kind if joint.kind in known else "free"
            yield kind, joint.first_coordinate, joint.first_speed
