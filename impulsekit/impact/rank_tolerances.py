"""Thresholds of rank: which bilateral rows count, and what of the mass matrix is rounding.

Each once, for answers, motions, derivatives and checks; ``core/laws/tolerances.hpp`` has those of
the core. Lengths of rows are those of C = L⁻¹ Aᵀ with M = L Lᵀ. Rounding of a double is 2.2e-16.
Tests: ``tests/impact/test_dependent_rows.py``.
"""

from __future__ import annotations

__all__ = [
    "FAINT_AXIS", "FAINT_PIVOT", "RANK_TOLERANCE", "SMALLEST_PIVOT", "UNFILLED_ROW", "WEIGHTLESS",
]  # fmt: skip

# Rows beside each other.

# [rad] A row is dependent if, scaled to unit length, it stands less than this out of the span of
# the others; and zero if its entries are less than this share of the terms they are sums of. Loops
# closed by hand are off by about as much.
RANK_TOLERANCE = 1e-7
# [rad] A row that is one axis of a vector is dependent if it stands less than this out of the span
# of the others, in the length of the longest of its axes: what the digits of files leave of a loop
# in a plane. An arm stretched to 1e-5 rad leaves more.
FAINT_AXIS = 1e-8

# Rows that move nothing.

# Rows of less than this share of the longest do not fill up a singular mass matrix.
UNFILLED_ROW = 1e-12


# The mass matrix.

# A pivot of M this far below its diagonal is rounding, not inertia.
SMALLEST_PIVOT = 1e-13
# Pivots depend on the order of elimination: below this the matrix is looked at as a whole.
FAINT_PIVOT = 1e-6
# A generalized mass below this share of the largest counts as zero.
WEIGHTLESS = 1e-12
