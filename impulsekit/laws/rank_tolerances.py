"""Thresholds of rank: which bilateral rows count, move nothing, are implied, or hold a contact.

Each once, for answers, motions, derivatives and checks. Lengths of rows are those of
C = L⁻¹ Aᵀ with M = L Lᵀ, and W = Cᵀ C has their squares. Rounding of a double is 2.2e-16.
Tests: ``tests/impact/test_dependent_rows.py``.
"""

from __future__ import annotations

__all__ = [
    "EXACT_RANK", "FAINT_AXIS", "FAINT_PIVOT", "FAINT_ROW", "RANK_TOLERANCE", "SMALLEST_PIVOT",
    "UNFILLED_ROW", "WEIGHTLESS",
]  # fmt: skip

# Rows beside each other.

# [rad] A row is dependent if, scaled to unit length, it stands less than this out of the span of
# the others; and zero if its entries are less than this share of the terms they are sums of. Loops
# closed by hand are off by about as much.
RANK_TOLERANCE = 1e-7
# The same that rounding leaves of dependent rows, by row; more is told as nearly dependent.
EXACT_RANK = 1e-14
# [rad] A row that is one axis of a vector is dependent if it stands less than this out of the span
# of the others, in the length of the longest of its axes: what the digits of files leave of a loop
# in a plane. An arm stretched to 1e-5 rad leaves more.
FAINT_AXIS = 1e-8

# Rows that move nothing.

# Rows of less than this share of the longest do not fill up a singular mass matrix.
UNFILLED_ROW = 1e-12


# Rows of contacts that move nothing (``tests/impact/test_contacts_that_cannot_move.py``): smaller
# ones are looked at more closely, and are zero below ``EXACT_RANK`` of the terms they are sums of.

# [m²] Squares of the normal's row, and of both tangents together, that leave no doubt: rows of
# 1e-6 are eight orders above the rounding of places 1 m away.
FAINT_ROW = 1e-12

# The mass matrix.

# A pivot of M this far below its diagonal is rounding, not inertia.
SMALLEST_PIVOT = 1e-13
# Pivots depend on the order of elimination: below this the matrix is looked at as a whole.
FAINT_PIVOT = 1e-6
# A generalized mass below this share of the largest counts as zero.
WEIGHTLESS = 1e-12
