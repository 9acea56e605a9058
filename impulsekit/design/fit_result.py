"""``Fit``: fitted coefficients with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..display import Displayed, one_line
from ..errors import RangeError, UnknownNameError
from ..tolerances import NONZERO

__all__ = ["UNSEEN", "Fit"]

# A parameter on which v⁺ depends less than this, relative to the most telling one, is not seen.
UNSEEN = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Displayed):
    """The result of a fit with P parameters; arrays are read-only.

    Attributes:
        names: (P,) such as "floor: restitution", "floor: friction", "elbow: mass".
        values: (P,) the fitted values.
        covariance: (P, P); infinite variance if v⁺ does not depend on the parameter.
        noise: estimated standard deviation of the measurements, in units of their sigma
            if that was given.
        freedom: measured numbers minus parameters.
        residuals: measured minus fitted, over sigma if that was given.
        converged: whether scipy's least squares converged where every friction has an effect.
        message: the message of scipy.
        estimated: whether the covariance is based on ``noise``, not on a given sigma; also
            true if the residuals are far above the given sigma.
        sigma_given: whether the measurements came with a sigma.
        bounds: (P, 2) of each parameter.
        notes: warnings: a misfit, parameters without effect on any measurement, bounds
            reached, outliers. Empty for a good fit.
        weights: (M,) how much each measurement counts, 1 without ``robust``.

    Example:
        >>> from impulsekit import Contact, Robot, Scene, solve
        >>> from impulsekit.measured import Measurement, fit_impacts
        >>> ball = Robot.from_urdf("models/ball.urdf", root="freeflyer")
        >>> guess, truth = (Contact("ball", restitution=e, name="floor") for e in (0.5, 0.7))
        >>> q, v = ball.neutral(), [0.0, 0, -2, 0, 0, 0]
        >>> v_after = solve(Scene(ball, contacts=[truth]), q, v).v_after
        >>> measured = Measurement(Scene(ball, contacts=[guess]), q, v, v_after)
        >>> round(fit_impacts([measured], restitution=["floor"])["floor: restitution"], 9)
        0.7
    """

    names: tuple[str, ...]
    values: np.ndarray
    covariance: np.ndarray
    noise: float
    freedom: int
    residuals: np.ndarray = field(repr=False)
    converged: bool
    message: str
    estimated: bool
    sigma_given: bool
    bounds: np.ndarray = field(repr=False)
    notes: tuple[str, ...] = ()
    weights: np.ndarray = field(default_factory=lambda: np.ones(0), repr=False)
    _blocks: tuple[tuple[np.ndarray, np.ndarray], ...] = field(default=(), repr=False)

    @property
    def sigma(self) -> np.ndarray:
        """(P,) standard deviations."""
        return np.sqrt(np.diagonal(self.covariance))

    def __repr__(self) -> str:
        state = "CONVERGED" if self.converged else "NOT CONVERGED"
        doubts = [f"{len(self.notes)} note{'s' if len(self.notes) > 1 else ''}"] * bool(self.notes)
        found = zip(self.names, self.values, self.sigma, strict=True)
        values = [f"{name} = {value:.4g} ± {sigma:.1g}" for name, value, sigma in found]
        return one_line("Fit", state, *doubts, *values)

    def __getitem__(self, name: str) -> float:
        """The value of one parameter by name.

        Raises:
            UnknownNameError.
        """
        if name not in self.names:
            raise UnknownNameError.among("parameter", name, self.names, "fit")
        return float(self.values[self.names.index(name)])

    def intervals(self, level: float = 0.95) -> np.ndarray:
        """(P, 2) confidence intervals within the bounds: Student's where the noise was estimated.

        Raises:
            RangeError: the level is not between 0 and 1.
        """
        from scipy import stats

        if not 0.0 < level < 1.0:
            raise RangeError.of("level", level, "between 0 and 1")
        tail = 0.5 + 0.5 * level
        reach = stats.t.ppf(tail, self.freedom) if self.estimated else stats.norm.ppf(tail)
        ends = np.stack([self.values - reach * self.sigma, self.values + reach * self.sigma], 1)
        return np.clip(ends, self.bounds[:, :1], self.bounds[:, 1:])

    def resampled(self, count: int = 1000, seed: int = 0) -> np.ndarray:
        """(count, P) values from resampled measurements (bootstrap), a Newton step each.

        Percentiles are intervals that need no normal noise: hold them beside ``intervals``.

        Raises:
            RangeError: ``count`` is below 1.
        """
        if count < 1:
            raise RangeError.of("count", count, "1 or more")
        rng = np.random.default_rng(seed)
        normals = np.array([rows.T @ rows for rows, _ in self._blocks])
        scores = np.array([rows.T @ left for rows, left in self._blocks])
        found = np.empty((count, len(self.values)))
        for k in range(count):
            chosen = rng.integers(len(normals), size=len(normals))
            normal, score = normals[chosen].sum(axis=0), scores[chosen].sum(axis=0)
            size = np.sqrt(np.maximum(np.diagonal(normal), NONZERO))
            inverse = np.linalg.pinv(normal / np.outer(size, size), rcond=UNSEEN, hermitian=True)
            found[k] = self.values - (inverse @ (score / size)) / size
        return np.clip(found, self.bounds[:, 0], self.bounds[:, 1])
