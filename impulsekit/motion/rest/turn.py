"""How points that rest roll and spin: directions, and when they begin and stop."""

from __future__ import annotations

import numpy as np

from ..tree.pressed import direction_of
from .settle import next_slide

__all__ = ["GROWN_SLIP", "NO_TURN", "after_stop", "direction_of_slip", "way_of_slip"]

# Turning below this [rad/s] has no direction of its own.
NO_TURN = 1e-9
# Turning that began, and is slower than this [rad/s], is opposed along its acceleration.
GROWN_SLIP = 1e-7


def direction_of_slip(slip: np.ndarray, start: np.ndarray, slow: float) -> np.ndarray:
    """(k,) unit: that of slip, and where it is slower than ``slow`` the one in which it began."""
    return np.array(direction_of(*_two(slip), np.array(_two(start)), slow)[: len(slip)])


def way_of_slip(
    slip: np.ndarray,
    rate: np.ndarray,
    force: tuple[np.ndarray, float],
    reach: float,
    before: tuple[np.ndarray | None, bool],
    scale: float,
    *,
    fresh: bool,
) -> tuple[np.ndarray | None, bool]:
    """Where a point turns from now on, or None; and whether that has just begun.

    Args:
        slip, rate: (k,) turning [rad/s] and its rate [rad/s²].
        force: the moment (k,) [N m] and the normal force [N].
        reach: the largest moment over the normal force [m].
        before: the direction up to now, or None; and whether it had just begun.
        scale: the largest rate [rad/s²].
        fresh: after an impact, when the turning decides alone.
    """
    way, begins = before
    now, starts = next_slide(
        (0.0, 0.0, 0.0) if way is None else (*_two(way), 1.0),
        begins,
        _two(slip),
        _two(rate),
        (*_two(force[0]), force[1]),
        (reach, scale, NO_TURN, GROWN_SLIP),
        fresh,
    )
    return np.array(now[: len(slip)]) if now[2] else None, starts


def _two(vector: np.ndarray) -> tuple[float, float]:
    """A vector of one or two entries."""
    return float(vector[0]), float(vector[1]) if len(vector) > 1 else 0.0


def after_stop(speed: np.ndarray, way: np.ndarray, bar: float) -> tuple[np.ndarray | None, bool]:
    """The direction after an event, or None; and whether it has stopped."""
    size = float(np.linalg.norm(speed))
    if size <= bar:
        stopped = float(speed.dot(way)) <= NO_TURN
        return (None, True) if stopped else (way, False)
    return speed / size, False
