"""The words of a ``Law`` and of one contact as integers; a False that numba takes as any."""

from __future__ import annotations

import numpy as np

__all__ = ["JAM", "MANY", "NO", "NOT_UNIQUE", "Block", "Triple"]

# W of one contact: t1t1, t1t2, t2t2, t1n, t2n, nn [1/kg].
Block = tuple[float, float, float, float, float, float]
# Along the tangents and the normal.
Triple = tuple[float, float, float]

# Beside the codes of ``Status``: loads that move nothing are open, it jams, several answers.
NOT_UNIQUE, JAM, MANY = 2, 3, 5

NO: bool = np.bool_(False)  # type: ignore[assignment]
