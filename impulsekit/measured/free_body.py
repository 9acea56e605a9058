"""One free body in flight as compiled code, for recordings that take thousands of flights.

    I ω̇ = I ω × ω  (Euler),  Ṙ = R ω̂,  the mass centre on a parabola

ω by the classical rule of Runge and Kutta, R by Magnus' series of fourth order (Iserles & Nørsett
1999), both in steps of a small turn.
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.vectors import Vector, along, cross
from ..laws.borrowed import borrowing
from ..laws.compiled import entry
from ..motion.tree.coordinates import rotated, rotated_by, turn_by
from ..scene import Scene

__all__ = ["fly_all", "fly_along", "free_body_of"]

# No step turns a body, or turns or moves a joint, by more [rad, m]: the error of Runge and Kutta's
# rule is then below 1e-8 of a turn and 1e-6 of a step of joints, far below any noise.
LONGEST_TURN = 0.1


def free_body_of(scene: Scene) -> np.ndarray | None:
    """(24,) I about the mass centre [kg m²], I⁻¹, mass centre [m], gravity [m/s²], joint's axes.

    None unless the scene is one free body under its weight alone.
    """
    model = scene.robot.model
    if scene.forces or scene.constraints or model.njoints != 2:
        return None
    if model.joints[1].shortname() != "JointModelFreeFlyer" or np.any(model.armature):
        return None
    own = model.inertias[1]
    if not (own.mass > 0.0 and np.linalg.eigvalsh(own.inertia)[0] > 0.0):
        return None
    gravity = model.jointPlacements[1].rotation.T @ np.array(scene.gravity)
    matrices = np.array(own.inertia), np.linalg.inv(own.inertia)
    return np.concatenate([*(each.reshape(-1) for each in matrices), own.lever, gravity])


@borrowing
def _times(numbers: np.ndarray, at: int, x: Vector) -> Vector:
    """A matrix of the body times x."""
    return (
        numbers[at] * x[0] + numbers[at + 1] * x[1] + numbers[at + 2] * x[2],
        numbers[at + 3] * x[0] + numbers[at + 4] * x[1] + numbers[at + 5] * x[2],
        numbers[at + 6] * x[0] + numbers[at + 7] * x[1] + numbers[at + 8] * x[2],
    )


@borrowing
def _euler(numbers: np.ndarray, w: Vector) -> Vector:
    """ω̇ = I⁻¹ (I ω × ω)."""
    return _times(numbers, 9, cross(_times(numbers, 0, w), w))


@borrowing
def _fly(numbers: np.ndarray, dt: float, q: np.ndarray, v: np.ndarray) -> None:
    """Move a state (7,), (6,) by dt."""
    lever = (numbers[18], numbers[19], numbers[20])
    w = (v[3], v[4], v[5])
    speed = rotated(q, 3, along((v[0], v[1], v[2]), 1.0, cross(w, lever)))
    arm = rotated(q, 3, lever)
    for k in range(3):
        q[k] += speed[k] * dt + 0.5 * numbers[21 + k] * dt * dt + arm[k]
    speed = along(speed, dt, (numbers[21], numbers[22], numbers[23]))
    turn = abs(dt) * math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    pieces = max(1, math.ceil(turn / LONGEST_TURN))
    h = dt / pieces
    for _ in range(pieces):
        a = _euler(numbers, w)
        b = _euler(numbers, along(w, 0.5 * h, a))
        c = _euler(numbers, along(w, 0.5 * h, b))
        d = _euler(numbers, along(w, h, c))
        change = along(along(a, 2.0, along(b, 1.0, c)), 1.0, d)
        late = along(w, h / 6.0, change)
        # ∫ω = h (ω₀ + 4 ω_m + ω₁) / 6 with Hermite's ω_m, and half the integral of brackets.
        sums = along(along(w, 1.0, late), h / 6.0, along(a, -1.0, _euler(numbers, late)))
        x = along((0.0, 0.0, 0.0), 0.5 * h, sums)
        turn_by(q, 3, along(x, h * h / 12.0, cross(w, late)), q)
        w = late
    size = math.sqrt(q[3] * q[3] + q[4] * q[4] + q[5] * q[5] + q[6] * q[6])
    for k in range(3, 7):
        q[k] /= size
    arm = rotated(q, 3, lever)
    own = along(rotated_by((-q[3], -q[4], -q[5]), q[6], speed), -1.0, cross(w, lever))
    for k in range(3):
        q[k] -= arm[k]
        v[k], v[3 + k] = own[k], w[k]


def _examples() -> tuple:
    return np.ones(24), np.zeros(1), np.eye(7)[6:], np.zeros((1, 6))


@entry(_examples, seconds=1.0)
def fly_all(numbers: np.ndarray, dt: np.ndarray, q: np.ndarray, v: np.ndarray) -> None:
    """Move states (n, 7), (n, 6), each by its own time (n,), in place."""
    for i in range(len(dt)):
        _fly(numbers, dt[i], q[i], v[i])


@entry(_examples, seconds=1.5)
def fly_along(numbers: np.ndarray, dt: np.ndarray, q: np.ndarray, v: np.ndarray) -> None:
    """Write the state of the first rows at ascending times (n,) before and after it, in place."""
    last = len(dt) - 1
    first = 0
    while first < last and dt[first] < 0.0:
        first += 1
    here, speed = q[0].copy(), v[0].copy()
    for side in range(2):
        now_q, now_v, now = here.copy(), speed.copy(), 0.0
        count = len(dt) - first if side == 0 else first
        for k in range(count):
            i = first + k if side == 0 else first - 1 - k
            _fly(numbers, dt[i] - now, now_q, now_v)
            now = dt[i]
            q[i], v[i] = now_q, now_v
