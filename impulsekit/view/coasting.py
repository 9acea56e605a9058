"""How an impact looks in time: a moment of coasting before it and after it.

An ``Impact`` is one instant. For the eye, the robot comes in with the velocities it had
and goes off with those it got, joint speeds constant, loops and pins that held kept shut.
Forces have no part in this; ``simulate`` is for the motion that really follows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..impact.mechanics import Mechanics
from ..measured.recording import Recording

if TYPE_CHECKING:
    from ..impact import Impact

__all__ = ["coasting"]

STEPS = 40
# The fastest joint turns this far [rad], and the fastest body goes this share of the size.
LARGEST_TURN = 0.9
LARGEST_SHARE = 0.3
LONGEST = 2.0  # [s]
# Rows that move by less than this share of the speeds are held after the impact, too.
HELD = 1e-6
# Singular values below this share of the largest are of rows that repeat others.
REDUNDANT = 1e-9
# In place of a scale of zero, where nothing moves.
TINY = 1e-300


def coasting(impact: Impact, span: float | None = None) -> Recording:
    """The motion around an impact, which is at time 0.

    Args:
        impact: the impact.
        span: how long before and after it [s]; None for what lets the eye follow.
    """
    robot = impact.scene.robot
    lasting = _fitting_span(impact) if span is None else span
    after = _path(impact, impact.v_after, lasting)
    moves_before = bool(np.any(impact.v_before))
    before = _path(impact, impact.v_before, -0.5 * lasting)[::-1] if moves_before else []
    if not moves_before:
        # It stands still for a moment, and then the blow comes.
        before = [np.array(impact.q)] * (STEPS // 2 + 1)
    t = np.concatenate(
        [np.linspace(-0.5 * lasting, 0.0, len(before)), np.linspace(0.0, lasting, len(after))[1:]]
    )
    return Recording(robot, t, np.array([*before, *after[1:]]), [(0.0, impact)])


def _fitting_span(impact: Impact) -> float:
    """How long the fastest part can be followed [s]."""
    robot = impact.scene.robot
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, impact.q)
    places = np.array([data.oMi[i].translation for i in range(1, robot.model.njoints)])
    size = max(float(np.ptp(places, axis=0).max()) if len(places) else 0.0, 0.3)
    limits = [LONGEST]
    for v in (impact.v_before, impact.v_after):
        pin.forwardKinematics(robot.model, data, impact.q, np.array(v))
        for link in robot.links:
            twist = data.v[link.joint_id]
            speed = np.linalg.norm(twist.linear + np.cross(twist.angular, link.com_in_joint))
            turn = np.linalg.norm(twist.angular)
            if speed > 0.0:
                limits.append(LARGEST_SHARE * size / float(speed))
            if turn > 0.0:
                limits.append(LARGEST_TURN / float(turn))
    return min(limits)


def _path(impact: Impact, v: np.ndarray, span: float) -> list[np.ndarray]:
    """Configurations from the impact on, for ``span`` seconds (backwards if negative)."""
    robot = impact.scene.robot
    steps = STEPS if span > 0 else STEPS // 2
    step = span / steps
    speed = _kept_shut(impact, v)
    path = [np.array(impact.q)]
    for _ in range(steps):
        # The midpoint rule: loops open by the cube of the step only.
        half = pin.integrate(robot.model, path[-1], 0.5 * step * speed(path[-1]))
        path.append(pin.integrate(robot.model, path[-1], step * speed(half)))
    return path


def _kept_shut(impact: Impact, v: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The velocity nearest to v at a configuration that keeps what v keeps at the impact."""
    v = np.array(v)
    scene = impact.scene
    if not scene.held:
        return lambda q: v
    rates = impact.mechanics.constraint_matrix @ v
    scale = max(float(np.abs(v).max()), TINY)
    held = np.abs(rates) < HELD * scale

    def speed(q: np.ndarray) -> np.ndarray:
        matrix = Mechanics(scene, q).constraint_matrix[held]
        return v - np.linalg.pinv(matrix, rcond=REDUNDANT) @ (matrix @ v)

    return speed if held.any() else lambda q: v
