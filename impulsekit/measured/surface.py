"""A loss over one or more parameters out of few evaluations: its least point, and how sure."""

from __future__ import annotations

import numpy as np

__all__ = ["design_points", "least_of", "resampled_least"]

# A surrogate needs its constant, slopes and curvatures, and some points more.
RIDGE = 1e-6
# A loss that differs by less over a box is flat there [relative].
FLAT = 1e-3


def design_points(
    low: np.ndarray, high: np.ndarray, count: int, seed: int, centre: np.ndarray | None = None
) -> np.ndarray:
    """(count, P) points of Sobol's sequence in a box; the first is ``centre`` where it is given."""
    import warnings

    from scipy.stats import qmc

    sampler = qmc.Sobol(len(low), scramble=True, seed=seed)
    with warnings.catch_warnings():
        # Counts that are no power of two are balanced well enough here.
        warnings.simplefilter("ignore", UserWarning)
        unit = sampler.random(count)
    points = low + unit * (high - low)
    if centre is not None:
        points[0] = centre
    return np.asarray(points)


def least_of(
    points: np.ndarray,
    losses: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    counts: np.ndarray | None = None,
) -> np.ndarray:
    """(P,) where the squared loss, as a quadratic of the parameters, is least within a box.

    A mean of distances has the form √(c² + k² (x − x₀)²) about its least point: its square is
    the quadratic. Points of large loss count less, since the quadratic holds near the least.

    Args:
        points: (K, P). losses: (K,), above zero. low, high: (P,) the box.
        counts: (K,) how much each point counts; all alike by default.
    """
    from scipy.optimize import lsq_linear, minimize

    unit = 2.0 * (points - low) / (high - low) - 1.0
    count = unit.shape[1]
    pairs = [(i, j) for i in range(count) for j in range(i, count)]
    if len(points) < 1 + count + len(pairs):
        # Too few for products: curvatures of single parameters alone.
        pairs = [(i, i) for i in range(count)]
    basis = np.column_stack(
        [np.ones(len(unit)), unit, *(unit[:, i] * unit[:, j] for i, j in pairs)]
    )
    squares = (losses / losses.min()) ** 2
    weights = (1.0 if counts is None else np.sqrt(counts)) / squares
    bounds = np.full(basis.shape[1], -np.inf)
    for k, (i, j) in enumerate(pairs):
        if i == j:
            # No curvature below zero: the least point would be a corner of the box.
            bounds[1 + count + k] = 0.0
    ridge = np.sqrt(RIDGE * len(unit)) * np.eye(basis.shape[1])
    found = lsq_linear(
        np.vstack([basis * weights[:, None], ridge]),
        np.concatenate([squares * weights, np.zeros(len(ridge))]),
        bounds=(bounds, np.inf),
    ).x

    slope, curvature = found[1 : 1 + count], np.zeros((count, count))
    for (i, j), own in zip(pairs, found[1 + count :], strict=True):
        curvature[i, j] += own
        curvature[j, i] += own

    def value(x: np.ndarray) -> tuple[float, np.ndarray]:
        bent = curvature @ x
        return float(x @ (slope + 0.5 * bent)), slope + bent

    starts = [unit[int(np.argmin(losses))], np.zeros(count)]
    # scipy's L-BFGS-B wakes all threads of BLAS at each step, 20 times the work of so small a sum.
    ends = [
        minimize(value, start, jac=True, bounds=[(-1.0, 1.0)] * count, method="TNC")
        for start in starts
    ]
    best = min(ends, key=lambda end: end.fun).x
    return np.asarray(low + 0.5 * (best + 1.0) * (high - low))


def resampled_least(
    points: np.ndarray,
    losses: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    count: int,
    seed: int,
) -> np.ndarray:
    """(count, P) the least points of means over resampled recordings (bootstrap, Efron 1979).

    Points count by random weights besides (Rubin 1981): motions with many impacts are rough
    functions of their coefficients, and the few points of a quadratic feel it.

    Args:
        points: (K, P). losses: (K, R) by point and recording.
    """
    rng = np.random.default_rng(seed)
    recordings = losses.shape[1]
    found = np.empty((count, points.shape[1]))
    for k in range(count):
        chosen = rng.integers(recordings, size=recordings)
        mean = losses[:, chosen].mean(axis=1)
        if mean.max() - mean.min() <= FLAT * mean.max():
            # A loss that is the same everywhere has its least point anywhere.
            found[k] = low + rng.random(len(low)) * (high - low)
            continue
        counts = rng.exponential(size=len(points))
        found[k] = least_of(points, mean, low, high, counts)
    return found
