"""Results as plain data, ready for JSON."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

__all__ = ["plain"]


def plain(value: Any) -> Any:
    """The same in dictionaries, lists and numbers; NaN and infinity, which JSON lacks, are None.

    Example:
        >>> plain({"mass": np.array([1.0, np.inf]), 3: ("a",)})
        {'mass': [1.0, None], '3': ['a']}
    """
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(each) for each in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value
