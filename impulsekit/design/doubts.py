"""What to doubt in a fit: misfits, bounds, outliers, what nothing measures, shared noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = [
    "bounds_reached",
    "is_misfit",
    "not_seen",
    "outliers",
    "spread_of_measurements",
    "widened",
]

# Probability that noise of the given sigma leaves residuals as large: one fit in 10 000.
MISFIT = 1e-4
# A measurement is off the others where its residuals are, in the root mean square, so many times
# the median of all; of normal noise one in 10^6 is.
OFF = 6.0
# So many measurements at least tell what is typical; below this [m/s, or sigmas] all is rounding.
FEWEST, EXACT = 5, 1e-9
# So many measurements more than parameters tell how far measurements differ.
FEWEST_TO_SPREAD = 3
# Squares of singular values below this share of the largest are of what is not seen.
SINGULAR = 1e-18
# A parameter this near to its bound [relative] has reached it.
AT_BOUND = 1e-9


def not_seen(names: Sequence[str], covariance: np.ndarray) -> list[str]:
    """Parameters on which no measurement depends."""
    return [
        f"{name} is not determined: no measured velocity depends on it where the fit ends"
        + (" (no contact slides)" if name.endswith("friction") else "")
        for name, variance in zip(names, np.diagonal(covariance), strict=True)
        if not np.isfinite(variance)
    ]


def bounds_reached(
    names: Sequence[str], values: np.ndarray, low: np.ndarray, high: np.ndarray
) -> list[str]:
    """Parameters that end at a bound."""
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
    """Whether residuals over sigma are larger than noise of that sigma leaves (χ² test)."""
    from scipy import stats

    return freedom > 0 and bool(stats.chi2.sf(float(residual @ residual), freedom) < MISFIT)


def outliers(residual: np.ndarray, counts: Sequence[int]) -> list[str]:
    """Measurements whose residuals are far above those of the others.

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
    """(P,) standard deviations by how much each measurement pulls: they hold whatever the noise.

    The jackknife of least squares (MacKinnon & White 1985; Bell & McCaffrey 2002): noise of v⁻
    goes through the impact, so that the numbers of one measurement are off together. 0 where
    measurements are too few to tell.
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
    """The covariance with standard deviations of no less than these."""
    own = np.sqrt(np.diagonal(covariance))
    factor = np.ones_like(own)
    wider = sigma > own
    factor[wider & (own > 0.0)] = sigma[wider & (own > 0.0)] / own[wider & (own > 0.0)]
    return covariance * np.outer(factor, factor)
