"""``Fit``: fitted coefficients with their uncertainty, weights of impacts, and what to doubt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..errors import RangeError, UnknownNameError
from ..errors.calls import public
from ..formatting import Displayed, one_line
from ..tolerances import NONZERO
from .parameters import Parameter

# The spread of residuals that are all the same.
LEAST_SPREAD = 1e-6

# Ways to weigh measurements that are off the others.
ROBUST = ("none", "huber", "biweight")
# Beyond these multiples of what is typical a measurement counts less; beyond the last not at all
# (95 % efficiency for normal noise: Huber 1964; Beaton & Tukey 1974).
HUBER, BIWEIGHT = 1.345, 4.685
# Variances below this share of the largest are of directions without noise.
NOISELESS = 1e-12


def whitening(covariance: np.ndarray) -> np.ndarray:
    """Return (n, n) W with WᵀW = C⁻¹ of a covariance, its smallest variances raised."""
    values, axes = np.linalg.eigh(covariance)
    values = np.maximum(values, NOISELESS * values[-1])
    return np.asarray(axes.T / np.sqrt(values)[:, None])


def block_weights(kind: str, blocks: Sequence[np.ndarray]) -> np.ndarray:
    """Return (M,) weights, 0 to 1, of measurements by the size of their residuals.

    Args:
        kind: one of ``ROBUST``.
        blocks: by measurement, its residuals over their noise.
    """
    sizes = np.array([np.sqrt(own @ own / max(len(own), 1)) for own in blocks])
    typical = float(np.median(sizes))
    if kind == "none" or not typical > 0.0:
        return np.ones(len(sizes))
    # A size is of several numbers, so about 1 and never negative: what counts is its excess.
    excess = np.maximum(sizes / typical - 1.0, 0.0)
    spread = max(1.4826 * float(np.median(np.abs(sizes / typical - 1.0))), LEAST_SPREAD)
    if kind == "huber":
        return np.minimum(1.0, HUBER * spread / np.maximum(excess, NONZERO))
    return np.asarray(np.clip(1.0 - (excess / (BIWEIGHT * spread)) ** 2, 0.0, 1.0) ** 2)


# Probability that noise of the given sigma leaves residuals as large: one fit in 10 000.
MISFIT = 1e-4
# A measurement is off the others where its residuals are, in the root mean square, so many times
# the median of all; of normal noise one in 10^6 is.
OFF = 6.0
# Fewer measurements have no typical size; below this [m/s, or sigmas] all is rounding.
FEWEST, EXACT = 5, 1e-9
# So many measurements more than parameters determine how far measurements differ.
FEWEST_TO_SPREAD = 3
# Squares of singular values below this share of the largest are of what is not seen.
SINGULAR = 1e-18
# A parameter this near to its bound [relative] has reached it.
AT_BOUND = 1e-9


def not_seen(names: Sequence[str], covariance: np.ndarray) -> list[str]:
    """Return the parameters on which no measurement depends."""
    return [
        f"{name} is not determined: no measured velocity depends on it where the fit ends"
        + (" (no contact slides)" if name.endswith("friction") else "")
        for name, variance in zip(names, np.diagonal(covariance), strict=True)
        if not np.isfinite(variance)
    ]


def bounds_reached(
    names: Sequence[str], values: np.ndarray, low: np.ndarray, high: np.ndarray
) -> list[str]:
    """Return parameters that end at a bound."""
    found = []
    for name, value, *ends in zip(names, values, low, high, strict=True):
        for end in ends:
            if np.isfinite(end) and abs(value - end) <= AT_BOUND * max(abs(end), 1.0):
                found.append(
                    f"{name} reaches its bound {end:g}: the measurements ask for more than the law "
                    "allows, or for none of it"
                )
    return found


def is_misfit(residual: np.ndarray, freedom: int) -> bool:
    """Return whether residuals over sigma are larger than noise of that sigma leaves (χ² test)."""
    from scipy import stats

    return freedom > 0 and bool(stats.chi2.sf(float(residual @ residual), freedom) < MISFIT)


def outliers(residual: np.ndarray, counts: Sequence[int]) -> list[str]:
    """Return measurements whose residuals are far above those of the others.

    Args:
        residual: (N,) of all measured numbers.
        counts: how many of them each measurement has.
    """
    parts = np.split(residual, np.cumsum(counts)[:-1])
    sizes = np.array([np.sqrt(part @ part / len(part)) if len(part) else 0.0 for part in parts])
    typical = float(np.median(sizes))
    if len(sizes) < FEWEST or sizes.max() < EXACT:
        return []
    return [
        f"measurements[{i}] is off by {sizes[i] / max(typical, EXACT):.3g} times what half of all "
        "leave; fit without it and see"
        for i in np.flatnonzero(sizes > OFF * max(typical, EXACT)).tolist()
    ]


def spread_of_measurements(
    jacobian: np.ndarray, residual: np.ndarray, counts: Sequence[int]
) -> np.ndarray:
    """Return (P,) standard deviations by how much each measurement pulls, for any noise.

    The jackknife of least squares (MacKinnon & White 1985; Bell & McCaffrey 2002): noise of v⁻
    goes through the impact, so that the numbers of one measurement are off together. 0 where
    measurements are too few to determine it.
    """
    count = len(counts)
    if count < jacobian.shape[1] + FEWEST_TO_SPREAD:
        return np.zeros(jacobian.shape[1])
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=SINGULAR, hermitian=True)
    ends = np.cumsum(counts)[:-1]
    pulls = []
    for rows, left in zip(np.split(jacobian, ends), np.split(residual, ends), strict=True):
        own = np.eye(len(left)) - rows @ inverse @ rows.T
        pulls.append(inverse @ rows.T @ np.linalg.pinv(own, hermitian=True) @ left)
    return np.sqrt((count - 1) / count * np.square(pulls).sum(axis=0))


def widened(covariance: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Return the covariance with standard deviations of no less than these."""
    own = np.sqrt(np.diagonal(covariance))
    factor = np.ones_like(own)
    wider = sigma > own
    factor[wider & (own > 0.0)] = sigma[wider & (own > 0.0)] / own[wider & (own > 0.0)]
    return covariance * np.outer(factor, factor)


# A parameter on which v⁺ depends less than this, relative to the most telling one, is not seen.
UNSEEN = 1e-9


@public
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
        parameters: (P,) the unknowns, each with its start, bounds and contacts.

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
    parameters: tuple[Parameter, ...] = field(default=(), repr=False)
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
        """Return the value of one parameter by name.

        Raises:
            UnknownNameError.
        """
        if name not in self.names:
            raise UnknownNameError.among("parameter", name, self.names, "fit")
        return float(self.values[self.names.index(name)])

    def intervals(self, level: float = 0.95) -> np.ndarray:
        """Return (P, 2) confidence intervals in the bounds, Student's where noise was estimated.

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
        """Return (count, P) values from resampled measurements (bootstrap), a Newton step each.

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
