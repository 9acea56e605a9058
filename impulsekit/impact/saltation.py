"""The saltation matrix: how a small deviation passes through an event.

An event takes place where a guard g(x, t) vanishes and resets x⁻ to x⁺ = R(x⁻, t). A
neighbour x⁻ + δ meets the guard a little earlier or later, and to first order

    δ⁺ = Ξ δ⁻,   Ξ = ∂R/∂x + (f⁺ − ∂R/∂x f⁻ − ∂R/∂t) (∂g/∂x)ᵀ / (∂g/∂x·f⁻ + ∂g/∂t)

with the vector fields f⁻ before and f⁺ after (Aizerman & Gantmakher 1958; Kong et al. 2024).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, RangeError, ShapeError
from ..errors.calls import public
from ..formatting import OneLine
from ..robot.arrays import array_of, floats, lock
from ..scene.functions import call

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .derivatives import Derivatives
    from .result import Impact

__all__ = ["Saltation", "saltation", "saltation_matrix"]

# A guard that is met more slowly than this, relative to its terms, is grazed.
GRAZING = 1e-9


def saltation_matrix(
    reset: Any,
    field_before: Any,
    field_after: Any,
    guard: Any,
    *,
    guard_rate: float = 0.0,
    reset_rate: Any = 0.0,
) -> np.ndarray:
    """(n, n) Ξ of an event of any system.

    Args:
        reset: (n, n) ∂R/∂x.
        field_before, field_after: (n,) ẋ just before and just after.
        guard: (n,) ∂g/∂x.
        guard_rate: ∂g/∂t, for what moves on its own.
        reset_rate: (n,) or a number, ∂R/∂t.

    Raises:
        ShapeError, NotFiniteError: what is wrong with an argument.
        RangeError: the guard is grazed, and no saltation matrix exists.

    Example:
        >>> ball = saltation_matrix([[1, 0], [0, -0.5]], [-2, -10], [1, -10], [1, 0])
        >>> ball.tolist()
        [[-0.5, 0.0], [7.5, -0.5]]
    """
    jump = _array(reset, "reset", None)
    n = len(jump)
    if jump.shape != (n, n):
        raise ShapeError.of("reset", (n, n), jump.shape)
    before, after = (
        _array(given, what, (n,))
        for given, what in ((field_before, "field_before"), (field_after, "field_after"))
    )
    gradient = _array(guard, "guard", (n,))
    rate = np.broadcast_to(_array(reset_rate, "reset_rate", None), (n,))
    speed = float(gradient @ before + guard_rate)
    size = float(np.abs(gradient) @ np.abs(before)) + abs(guard_rate)
    if abs(speed) <= GRAZING * size or size == 0.0:
        raise RangeError.of("speed at which the guard is met", speed, "clearly different from 0")
    return jump + np.outer(after - jump @ before - rate, gradient) / speed


@dataclass(frozen=True, eq=False, repr=False)
class Saltation(OneLine):
    """An impact as a linear map of deviations (δq, δv); arrays are read-only.

    Attributes:
        derivatives: of the impact; look at ``derivatives.status.exists``.
        matrix: (2 nv, 2 nv) Ξ on the tangent of (q, v).
        reset: (2 nv, 2 nv) ∂R: Ξ without the shift in time.
        guard: (2 nv,) ∂g; zeros for a blow at a fixed time.
        speed: ġ before the impact [m/s]; 0 for a blow at a fixed time.
    """

    derivatives: Derivatives = field(repr=False)
    matrix: np.ndarray
    reset: np.ndarray
    guard: np.ndarray
    speed: float


@public
def saltation(
    impact: Impact,
    contact: str | None = None,
    *,
    acceleration_before: ArrayLike,
    acceleration_after: ArrayLike,
) -> Saltation:
    """The saltation matrix of an impact that occurs when a contact closes.

    The guard is the gap of the contact; its gradient is the normal row. Without a contact the
    impact occurs at a fixed time, and Ξ is the derivative of the reset alone.

    Args:
        impact: a solved impact.
        contact: the name of the contact that closes; None for a blow at a fixed time.
        acceleration_before, acceleration_after: (nv,) v̇ before and after, or a function of
            q and v that returns it.

    Raises:
        InputError: the impact is not valid, no such contact touched, or as for ``derivatives``.
        RangeError: the contact is only grazed.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, solve
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> scene = Scene(ball, contacts=[Contact("ball", restitution=0.5, name="floor")])
        >>> impact = solve(scene, ball.neutral(), [0, 0, -2, 0, 0, 0])
        >>> fall = [0, 0, -9.81, 0, 0, 0]
        >>> found = saltation(impact, "floor", acceleration_before=fall, acceleration_after=fall)
        >>> float(round(found.matrix[2, 2], 12))
        -0.5
    """
    from .derivatives import derivatives

    if not impact.is_valid():
        raise InputError(f"saltation: the impact is not valid. {impact.describe_status()}")
    found = derivatives(impact)
    nv = len(impact.v_before)
    reset = np.eye(2 * nv)
    reset[nv:, :nv], reset[nv:, nv:] = found["v_after", "q"], found["v_after", "v"]
    guard, speed = np.zeros(2 * nv), 0.0
    matrix = reset
    if contact is not None:
        guard[:nv] = _normal_row(impact, contact)
        speed = float(guard[:nv] @ impact.v_before)
        before = _acceleration(acceleration_before, impact.q, impact.v_before)
        after = _acceleration(acceleration_after, impact.q, impact.v_after)
        matrix = saltation_matrix(
            reset,
            np.concatenate([impact.v_before, before]),
            np.concatenate([impact.v_after, after]),
            guard,
        )
    lock(matrix, reset, guard)
    return Saltation(found, matrix, reset, guard, speed)


def _normal_row(impact: Impact, contact: str) -> np.ndarray:
    """(nv,) the gradient of a contact's gap."""
    names = impact.scene.entry_names("contacts")
    outcome = impact.outcome
    touches = () if outcome is None else outcome.touches
    rows = [
        touch.jacobian[2] for touch in touches if names[touch.entry] == contact and touch.turns < 0
    ]
    if not rows:
        touched = ", ".join(f'"{names[touch.entry]}"' for touch in touches) or "none"
        raise InputError(
            f'no contact "{contact}" touched in this impact; those that did: {touched}'
        )
    if len(rows) > 1:
        raise InputError(f'contact "{contact}" must touch at one point, got {len(rows)}')
    return rows[0]


def _acceleration(
    given: Any | Callable[[np.ndarray, np.ndarray], Any], q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    value = call(given, "acceleration", q, v) if callable(given) else given
    return _array(value, "acceleration", v.shape)


def _array(given: Any, what: str, shape: tuple[int, ...] | None) -> np.ndarray:
    array = floats(given, what)
    return array_of(array, array.shape if shape is None else shape, what)
