"""Numbers that all packages share and that are no thresholds by themselves.

A threshold stands at the top of the module that uses it, with its reason.
"""

from __future__ import annotations

__all__ = ["EPS", "NONZERO"]

# The rounding of a double, relative: the distance from 1 to the next one.
EPS = 2.0**-52
# In place of a size 0 that something is divided by: far below all measured sizes, and its inverse
# is still a double.
NONZERO = 1e-300
