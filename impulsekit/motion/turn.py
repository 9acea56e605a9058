"""How points that rest roll and spin: directions, and when they begin and stop."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["GROWN", "NO_TURN", "Turn", "after_stop", "direction_of_slip", "way_of_slip"]

# Turning below this [rad/s] has no direction of its own.
NO_TURN = 1e-9
# Turning that began, and is slower than this [rad/s], is opposed along its acceleration.
GROWN = 1e-7
# Forces this near the cone are on it; slip that is all but grown has grown.
ON_CONE, ALL_BUT = 1.0 - 1e-7, 0.999


class Turn:
    """How one point rolls and spins.

    Attributes:
        rolls: (2,) the direction of rolling, or None. spins: (1,) that of spin, or None.
        rolling_begins, spin_begins: whether it has just begun.
    """

    def __init__(
        self,
        rolls: np.ndarray | None = None,
        spins: np.ndarray | None = None,
        rolling_begins: bool = False,
        spin_begins: bool = False,
    ) -> None:
        self.rolls, self.spins = rolls, spins
        self.rolling_begins, self.spin_begins = rolling_begins, spin_begins

    def packed(self) -> list[Any]:
        """Ready for JSON."""
        ways = [None if way is None else way.tolist() for way in (self.rolls, self.spins)]
        return [*ways, self.rolling_begins, self.spin_begins]

    @classmethod
    def unpacked(cls, packed: list[Any]) -> Turn:
        """What ``packed`` packed."""
        rolls, spins = (None if way is None else np.array(way, dtype=float) for way in packed[:2])
        return cls(rolls, spins, bool(packed[2]), bool(packed[3]))

    def copied(self) -> Turn:
        """Another one, the same."""
        return Turn(self.rolls, self.spins, self.rolling_begins, self.spin_begins)


def direction_of_slip(slip: np.ndarray, start: np.ndarray, slow: float) -> np.ndarray:
    """(k,) unit: that of slip, and where it is slower than ``slow`` the one in which it began."""
    # Past its stop, within a step that will be cut there, it goes on smoothly.
    s = -slip if slip.dot(start) < 0.0 else slip
    s = s + slow * np.exp(-slip.dot(slip) / slow**2) * start
    return s / np.sqrt(s.dot(s))


def way_of_slip(
    slip: np.ndarray,
    rate: np.ndarray,
    force: float,
    limit: float,
    before: tuple[np.ndarray | None, bool],
    scale: float,
    *,
    fresh: bool,
) -> tuple[np.ndarray | None, bool]:
    """Where a point turns from now on, or None; and whether that has just begun.

    Args:
        slip, rate: (k,) turning [rad/s] and its rate [rad/s²].
        force, limit: the moment and its bound [N m].
        before: the direction up to now, or None; and whether it had just begun.
        scale: the largest rate [rad/s²].
        fresh: after an impact, when the turning decides alone.
    """
    if not limit > 0.0:
        return (before[0], before[1]) if before[0] is not None else (None, False)
    speed = float(np.linalg.norm(slip))
    slips = speed > NO_TURN
    way, begins = before
    if way is not None and not begins:
        return (slip / speed if slips else way), False
    if fresh and slips:
        return slip / speed, False
    on_cone = force >= limit * ON_CONE
    if way is not None:
        if on_cone and speed < ALL_BUT * GROWN and slip.dot(rate) >= 0.0:
            return (slip / speed if slips else way), True
        return (slip / speed if slips else None), False
    if not on_cone:
        return None, False
    if slips:
        return slip / speed, False
    size = float(np.linalg.norm(rate))
    if not size > 1e-7 * max(scale, 1e-300):
        return None, False
    return rate / size, True


def after_stop(speed: np.ndarray, way: np.ndarray, bar: float) -> tuple[np.ndarray | None, bool]:
    """The direction after an event, or None; and whether it has stopped."""
    size = float(np.linalg.norm(speed))
    if size <= bar:
        stopped = float(speed.dot(way)) <= NO_TURN
        return (None, True) if stopped else (way, False)
    return speed / size, False
