"""The words of a ``Law`` as integers: restitution, slip, order; and the code of no answer."""

from __future__ import annotations

import numpy as np

__all__ = [
    "AGAIN", "END", "LZB", "NEWTON", "NO", "PATH", "POISSON", "SEQUENTIAL", "SIMULTANEOUS",
    "STRONGE", "YES",
]  # fmt: skip

NEWTON, POISSON, STRONGE, LZB = 0, 1, 2, 3
END, PATH = 0, 1
SIMULTANEOUS, SEQUENTIAL = 0, 1

# Beside the codes of ``Status``: the problem is left to a slower way.
AGAIN = -1

# As arguments of compiled functions: for a literal numba would compile all that takes it once
# more.
YES: bool = np.bool_(True)  # type: ignore[assignment]
NO: bool = np.bool_(False)  # type: ignore[assignment]
