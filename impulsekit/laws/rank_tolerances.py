"""Thresholds of rank: which bilateral rows count, move nothing, are implied, or hold a contact.

Each once, for answers, batches, motions, derivatives and checks. Lengths of rows are those of
C = L⁻¹ Aᵀ with M = L Lᵀ, and W = Cᵀ C has their squares. Rounding of a double is 2.2e-16.
Tests: ``tests/impact/test_bilateral.py``, ``test_one_rank.py`` and ``test_rewritten_demands.py``,
``tests/batch/test_held.py``.
"""

from __future__ import annotations

__all__ = [
    "COARSE", "COMPARABLE", "CONTRADICTION_TOLERANCE", "DEPENDENT_SHARES", "DETERMINED",
    "EXACT_NULL_ROW", "EXACT_RANK", "FAINT_AXIS", "FAINT_AXIS_PIVOT", "FAINT_MOBILITY",
    "FAINT_PIVOT", "FAINT_ROW",
    "GOOD_PIVOT", "IDLE", "IN_SPAN", "LIVE_ROW", "NULL_ROW", "RANK_TOLERANCE", "SHORT_ROW",
    "SMALLEST_PIVOT", "SPAN_ROUNDING", "UNEVEN_AXES", "UNFILLED_ROW", "WEIGHTLESS",
    "WITH_FEW_DIGITS",
]  # fmt: skip

# Rows beside each other.

# [rad] A row is dependent if, scaled to unit length, it stands less than this out of the span of
# the others; and zero if its entries are less than this share of the terms they are sums of. Loops
# closed by hand are off by about as much.
RANK_TOLERANCE = 1e-7
# The same that rounding leaves of dependent rows, by row; more is told as nearly dependent.
EXACT_RANK = 1e-14
# A row whose unit vector lies in the span of the rows to this share has a unique impulse.
DETERMINED = 1.0 - 1e-9
# What dependent rows may disagree by, relative to the velocities they speak of: what the digits of
# loops closed by hand make of them.
CONTRADICTION_TOLERANCE = 1e-6
# [rad] A row that is one axis of a vector is dependent if it stands less than this out of the span
# of the others, in the length of the longest of its axes: what the digits of files leave of a loop
# in a plane. An arm stretched to 1e-5 rad leaves more.
FAINT_AXIS = 1e-8
# Rows of one vector this much shorter than its longest are judged beside it.
UNEVEN_AXES = 0.1
# Singular values below this share of the largest, where loads are spread over dependent rows.
DEPENDENT_SHARES = 1e-9

# Rows that move nothing.

# A row whose square is this much smaller than that of its terms is a zero.
NULL_ROW = 1e-22
# The same but for rounding; more is told as nearly dependent.
EXACT_NULL_ROW = 1e-27
# Rows of less than this share of the longest do not fill up a singular mass matrix.
UNFILLED_ROW = 1e-12

# Pivots: squares of lengths. Above ``tolerances.CLEAR`` they need no closer look.

# Rows whose squares differ by less than this are no rounding of each other.
COMPARABLE = 1e-9
# Pivots of W beside the longest axis of the row's vector that need no closer look: of 1e-8 of a
# length, ``FAINT_AXIS``, ten times as much.
FAINT_AXIS_PIVOT = 1e-14
# Pivots of W below this lose digits that those of C keep, whose squares they are.
GOOD_PIVOT = 1e-2
# The same in single precision, whose doubts are solved again in double.
COARSE = 1e-4

# Clear cases, which batches settle by themselves; all between is left to ``solve``.

# A row whose W is this share of that of its terms is live.
LIVE_ROW = 1e-12
# A live row this short may be one axis of a longer vector.
SHORT_ROW = 1e-4
# What rows that are set aside may want beside the others, over the speeds at hand.
IDLE = 2e-14
# Share of its W that a contact row keeps beside bilateral ones; below, digits are lost.
WITH_FEW_DIGITS = 1e-6

# Rows of contacts that move nothing (``tests/impact/test_contacts_that_cannot_move.py``): smaller
# ones are looked at more closely, and are zero below ``EXACT_RANK`` of the terms they are sums of.

# [m²] Squares of the normal's row, and of both tangents together, that leave no doubt: rows of
# 1e-6 are eight orders above the rounding of places 1 m away.
FAINT_ROW = 1e-12
# W_nn, times the mass of all bodies, that leaves no doubt: rows of 1e-7 of their sizes.
FAINT_MOBILITY = 1e-14

# Contacts beside bilateral rows.

# What the bilateral rows leave of a contact row is rounding below this share of it.
IN_SPAN = 1e-13
# The same where rows are nearly dependent: rounding over their least singular value.
SPAN_ROUNDING = 5e-15

# The mass matrix.

# A pivot of M this far below its diagonal is rounding, not inertia.
SMALLEST_PIVOT = 1e-13
# Pivots depend on the order of elimination: below this the matrix is looked at as a whole.
FAINT_PIVOT = 1e-6
# A generalized mass below this share of the largest counts as zero.
WEIGHTLESS = 1e-12
