"""Thresholds of the laws that more than one module uses: each once, with meaning, unit and reason.

A threshold that a single module uses stands at its top. No two modules give one name two values
(``tests/test_tolerances.py``). All are relative unless a unit is given. Rounding of a double is
2.2e-16.
"""

from __future__ import annotations

__all__ = [
    "ARRIVED", "AT_REST", "LEAST_PIVOT", "RESIDUAL_LIMIT", "ROUNDING_OF_SUMS", "SETTLED",
    "SINGULAR",
]  # fmt: skip

# Velocities.

# An approach below this share of the velocities counts as zero: some five roundings of what the
# closed forms of one contact read.
AT_REST = 1e-15

# Residuals, and where iterations end.

# Residuals above this are no rounding: 1e5 times the 1e-14 that a solve may leave.
RESIDUAL_LIMIT = 1e-9
# The same of a sum over many contacts, as of W P beside J Δv, relative to its terms.
ROUNDING_OF_SUMS = 1e-14
# The last of Newton's steps on one number: less than half its rounding.
ARRIVED = 1e-16
# Impulses that a round of sweeps changes by less than this share of all velocities have settled.
SETTLED = 1e-13

# Rank. Pivots are relative to the diagonal, eigenvalues to the largest.

# A pivot, an eigenvalue or a determinant below this share of its terms is a zero, where motions
# are looked for: 1e-5 of a length is.
SINGULAR = 1e-10
# In place of a pivot smaller than this, so that something can be divided by it.
LEAST_PIVOT = 1e-14
