"""What a row of a batch may be besides a ``Status``."""

from __future__ import annotations

__all__ = ["AGAIN", "OPEN"]

# In a kernel: the row is left to the solver of single states.
AGAIN = -1
# Added to the code of a row where it is not proven that no other v⁺ obeys the law.
OPEN = 32
