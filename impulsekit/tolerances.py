"""Numbers that all rooms share and that decide nothing by themselves.

What decides something stands at the top of the module that decides it, with its reason.
"""

from __future__ import annotations

__all__ = ["EPS", "NONZERO"]

# The rounding of a double, relative: the distance from 1 to the next one.
EPS = 2.0**-52
# Taken for a size that is 0 where something is divided by it: far below all that is measured, and
# its inverse is still a double.
NONZERO = 1e-300
