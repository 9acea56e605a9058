"""``Variation``: what differs from row to row of a study, and how."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InputError, RangeError, UnknownNameError
from ...scene.numbers import keep, number, optional, text

__all__ = ["DISTRIBUTIONS", "WHATS", "Variation"]

WHATS = ("configuration", "velocity", "impulse", "direction", "restitution", "friction", "mass")
DISTRIBUTIONS = ("uniform", "normal")


@dataclass(frozen=True)
class Variation:
    """A random quantity, drawn for every row.

    Attributes:
        what: the quantity.

            - "configuration": a step from the file's q along each degree of freedom
              [rad, m], independent of each other.
            - "velocity": an addition to the file's v [rad/s, m/s], in the same way.
            - "impulse": a factor on a known impulse.
            - "direction": an angle [rad] by which a known impulse is rotated about a normal axis,
              whose direction is uniform.
            - "restitution", "friction": the coefficient of a contact itself.
            - "mass": a factor on the mass of a link, and on its inertia with it.
        of: the joint, known impulse, contact or link by name; all of them by default,
            independent of each other.
        distribution: "uniform" from ``low`` to ``high``, or "normal" with ``mean`` and
            ``deviation``.
        low, high: bounds; samples of a normal distribution are clipped to them.

    Raises:
        RangeError, NotFiniteError, UnknownNameError, InputError.

    Example:
        >>> Variation("friction", low=0.3, high=0.9).distribution
        'uniform'
    """

    what: str
    of: str | None = None
    distribution: str = "uniform"
    low: float | None = None
    high: float | None = None
    mean: float = 0.0
    deviation: float | None = None

    def __post_init__(self) -> None:
        for name, known in (("what", WHATS), ("distribution", DISTRIBUTIONS)):
            if getattr(self, name) not in known:
                kind = {"what": "quantity to vary"}.get(name, name)
                raise UnknownNameError.among(kind, str(getattr(self, name)), known, "Variation")
        where = f"Variation of {self.what}"
        if self.of is not None:
            text(self.of, f"{where}: of")
        keep(self, where, optional(number), "low", "high", "mean", "deviation")
        if self.distribution == "uniform" and (self.low is None or self.high is None):
            raise InputError(f"{where}: a uniform distribution needs low and high")
        if self.distribution == "normal":
            if self.deviation is None:
                raise InputError(f"{where}: a normal distribution needs a deviation")
            if self.deviation < 0.0:
                raise RangeError.of(f"{where}: deviation", self.deviation, "0 or more")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise RangeError.of(f"{where}: low", self.low, f"at most high, {self.high:g}")
        self._check_coefficient(where)

    def _check_coefficient(self, where: str) -> None:
        """A coefficient that is drawn has to stay in its range."""
        if self.what == "mass" and (self.low is None or self.low <= 0.0):
            raise RangeError.of(f"{where}: low", self.low, "above 0")
        if self.what not in ("restitution", "friction"):
            return
        if self.low is None or self.low < 0.0:
            raise RangeError.of(f"{where}: low", self.low, "0 or more")
        if self.what == "restitution" and (self.high is None or self.high > 1.0):
            raise RangeError.of(f"{where}: high", self.high, "at most 1")

    def draw(self, rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
        """Numbers of this distribution."""
        if self.distribution == "uniform":
            low, high = float(self.low or 0.0), float(self.high or 0.0)
            return rng.uniform(low, high, shape)
        drawn = self.mean + float(self.deviation or 0.0) * rng.standard_normal(shape)
        if self.low is not None or self.high is not None:
            np.clip(drawn, self.low, self.high, out=drawn)
        return drawn
