"""A bar on the difference of numbers, absolute and nothing else."""

from __future__ import annotations

import numpy as np


def close(found, wanted, bar):
    """Assert that no entry is further off than ``bar``."""
    np.testing.assert_allclose(found, wanted, rtol=0, atol=bar)
