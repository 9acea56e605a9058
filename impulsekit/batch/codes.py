"""What a row of a batch may be besides a ``Status``."""

from __future__ import annotations

__all__ = ["AGAIN"]

# In a kernel: the row is left to the solver of single states.
AGAIN = -1
