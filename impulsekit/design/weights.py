"""How much each measured impact counts: noise before and after it, and outliers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..tolerances import NONZERO

__all__ = ["ROBUST", "block_weights", "whitening"]

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
    """(n, n) W with WᵀW = C⁻¹ of a covariance, its smallest variances raised to be of use."""
    values, axes = np.linalg.eigh(covariance)
    values = np.maximum(values, NOISELESS * values[-1])
    return np.asarray(axes.T / np.sqrt(values)[:, None])


def block_weights(kind: str, blocks: Sequence[np.ndarray]) -> np.ndarray:
    """(M,) weights, 0 to 1, of measurements by the size of their residuals.

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
