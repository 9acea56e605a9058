"""What a row of a batch may be besides a ``Status``."""

from __future__ import annotations

from ..laws.words import AGAIN

__all__ = ["AGAIN", "OPEN", "SHARED"]

# Added to the code of a row where it is not proven that no other v⁺ obeys the law.
OPEN = 32
# The same where others do, which differ by how redundant load is shared: the law has a rule for
# that, and the status stays.
SHARED = 64
