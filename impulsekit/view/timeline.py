"""``Timeline``: the motion's time over playback time, slowed down around impacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import RangeError

# The share by which a duration of whole frames may fall short of them.
ROUNDED = 1e-12
# [of the duration, or s] Instants nearer than this are one frame.
SAME_TIME = 1e-9

# A page with more frames than this is a mistake, not a picture.
MOST_FRAMES = 200_000


@dataclass(frozen=True, eq=False)
class Timeline:
    """Motion time against playback time, linear between knots, both rising.

    Attributes:
        moved: (k,) motion times [s].
        played: (k,) playback times [s], from 0.

    Example:
        >>> line = Timeline.of(0.0, 1.0, impacts=[0.5], slow_motion=0.1, window=0.05)
        >>> round(line.duration, 6), float(line.to_motion(line.to_playback(0.5)))
        (1.9, 0.5)
    """

    moved: np.ndarray
    played: np.ndarray

    @classmethod
    def of(
        cls,
        start: float,
        end: float,
        impacts: Sequence[float] = (),
        *,
        speed: float = 1.0,
        slow_motion: float = 1.0,
        window: float = 0.05,
    ) -> Timeline:
        """Return a timeline from ``start`` to ``end`` of a motion [s].

        Args:
            impacts: instants around which the motion is slowed [s].
            speed: motion seconds for each second of playback.
            slow_motion: factor on the speed near an impact, above 0 and up to 1.
            window: time before and after an impact with that factor [s].

        Raises:
            RangeError: a number outside its range.
        """
        for what, value in (("speed", speed), ("slow_motion", slow_motion)):
            if not 0.0 < value < np.inf:
                raise RangeError.of(f"replay: {what}", value, "a finite number above 0")
        if slow_motion > 1.0:
            raise RangeError.of("replay: slow_motion", slow_motion, "above 0 and up to 1")
        if not 0.0 <= window < np.inf:
            raise RangeError.of("replay: slow_window", window, "0 s or more")
        knots = {start, end}
        slow: list[tuple[float, float]] = []
        if slow_motion < 1.0 and window > 0.0:
            for instant in sorted(impacts):
                low, high = max(start, instant - window), min(end, instant + window)
                if slow and low <= slow[-1][1]:
                    slow[-1] = (slow[-1][0], max(high, slow[-1][1]))
                elif low < high:
                    slow.append((low, high))
        knots.update(x for pair in slow for x in pair)
        moved = np.array(sorted(knots))
        middles = 0.5 * (moved[1:] + moved[:-1])
        slowed = np.array([any(a < m < b for a, b in slow) for m in middles], dtype=bool)
        rates = speed * np.where(slowed, slow_motion, 1.0)
        played = np.concatenate([[0.0], np.cumsum(np.diff(moved) / rates)])
        return cls(moved, played)

    @property
    def duration(self) -> float:
        """The length of the playback [s]."""
        return float(self.played[-1])

    def to_playback(self, t: float | np.ndarray) -> np.ndarray:
        """Return playback times of motion times [s]."""
        return np.interp(t, self.moved, self.played)

    def to_motion(self, t: float | np.ndarray) -> np.ndarray:
        """Return motion times of playback times [s]."""
        return np.interp(t, self.played, self.moved)

    def frames(self, fps: float, instants: Sequence[float] = ()) -> np.ndarray:
        """Return (F,) playback times [s]: ``fps`` frames a second, the end, motion ``instants``.

        Raises:
            RangeError: not above zero, or more frames than a page can hold.
        """
        if not 0.0 < fps < np.inf:
            raise RangeError.of("replay: fps", fps, "a finite number above 0")
        if self.duration == 0.0:
            return np.zeros(1)
        count = int(np.floor(self.duration * fps * (1.0 + ROUNDED)))
        if count > MOST_FRAMES:
            raise RangeError.of(
                "replay: frames", count, f"at most {MOST_FRAMES} (raise speed or lower fps)"
            )
        regular = np.arange(count + 1) / fps
        extra = [self.duration, *self.to_playback(np.array(list(instants), dtype=float))]
        # An instant on the grid, but for rounding, is no frame of its own.
        extra = [
            t for t in extra if np.abs(regular - t).min() > SAME_TIME * max(1.0, self.duration)
        ]
        return np.unique(np.concatenate([regular, extra]))
