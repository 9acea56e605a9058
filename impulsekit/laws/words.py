"""The words of a ``Law`` as integers, and False as numba takes it without compiling once more."""

from __future__ import annotations

import numpy as np

__all__ = ["NEWTON", "NO", "POISSON", "STRONGE"]

NEWTON, POISSON, STRONGE = 0, 1, 2

NO: bool = np.bool_(False)  # type: ignore[assignment]
