"""Axes of contacts, and places as the core takes them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from .._core import Place
from .._core import contact_axes as core_axes

__all__ = ["contact_axes", "core_place"]


def contact_axes(normal: np.ndarray) -> np.ndarray:
    """(3, 3) columns t₁, t₂, n: a right-handed triad on a unit normal.

    t₁ is the world axis that is most across the normal, made perpendicular to it.
    """
    return core_axes(normal).reshape(3, 3)


def core_place(placement: pin.SE3) -> Place:
    """A frame in another one as the core takes it."""
    return Place(rotation=np.array(placement.rotation), origin=placement.translation)
