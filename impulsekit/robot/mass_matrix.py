"""The mass matrix by Pinocchio's composite rigid bodies, also where joints mimic others."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

__all__ = ["crba_of", "symmetric"]


def crba_of(model: pin.Model) -> Callable[[pin.Model, Any, np.ndarray], np.ndarray]:
    """The function of (model, data, q) that writes the upper triangle of M(q) to ``data.M``.

    Pinocchio 4.1's ``crba`` in the joints' own axes adds to what its last call left in the columns
    of joints behind one that mimics another; in world axes it does not.
    """
    if not len(model.mimicking_joints):
        return pin.crba
    return _in_world_axes


def _in_world_axes(model: pin.Model, data: Any, q: np.ndarray) -> np.ndarray:
    return pin.crba(model, data, q, pin.Convention.WORLD)


def symmetric(upper: np.ndarray) -> np.ndarray:
    """The whole of a symmetric matrix of which Pinocchio filled the upper triangle."""
    return np.where(_below(len(upper)), upper.T, upper)


@functools.cache
def _below(size: int) -> np.ndarray:
    """(size, size) mask of what is below the diagonal."""
    return np.tri(size, k=-1, dtype=bool)
