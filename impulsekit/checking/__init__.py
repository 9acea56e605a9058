"""An impact beside Chang & Huston's own method, which shares no code with Pinocchio.

robot ─► system ─┐
scene ─► demands ┴► check ─► Check     differences, tolerances, a plain yes or no
"""

from .check import check
from .result import Check, CheckRow

__all__ = ["Check", "CheckRow", "check"]
