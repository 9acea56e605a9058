"""The words of a ``Law`` and of one contact as integers; a False that numba takes as any."""

from __future__ import annotations

import numpy as np

__all__ = ["JAM", "MANY", "NEWTON", "NO", "NOT_UNIQUE", "POISSON", "STRONGE"]

NEWTON, POISSON, STRONGE = 0, 1, 2

# Beside the codes of ``Status``: loads that move nothing are open, it jams, several answers.
NOT_UNIQUE, JAM, MANY = 2, 3, 5

NO: bool = np.bool_(False)  # type: ignore[assignment]
