"""What a row of a batch may be besides a ``Status``."""

from __future__ import annotations

from ..laws.words import AGAIN

__all__ = ["AGAIN", "OPEN"]

# Added to the code of a row where it is not proven that no other v⁺ obeys the law.
OPEN = 32
