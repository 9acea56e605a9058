"""Thresholds of the laws that more than one module uses: each once, with meaning, unit and reason.

A threshold that a single module uses stands at its top. No two modules give one name two values
(``tests/test_tolerances.py``). What one contact or a count can tell of them is tested on both
sides (``tests/laws/test_thresholds.py``), the rest by the laws' tests. All are relative unless a
unit is given. Rounding of a double is 2.2e-16.
"""

from __future__ import annotations

__all__ = [
    "ARRIVED", "AT_REST", "AT_REST_AMONG_OTHERS", "BAR", "CLEAR", "EDGE", "GAIN", "LARGEST",
    "LEAST_PIVOT", "LEAST_RELEASE", "NEGLIGIBLE", "PART", "RESIDUAL_LIMIT", "ROUNDING",
    "ROUNDING_OF_SUMS", "ROUNDING_OF_TERMS", "SETTLED", "SINGULAR", "UNLOADED",
]  # fmt: skip

# Velocities.

# An approach below this share of the velocities counts as zero: some five roundings of what the
# closed forms of one contact read.
AT_REST = 1e-15
# The same beside other contacts, whose impulses made it: sums over them cancel.
AT_REST_AMONG_OTHERS = 1e-12
# Inequalities may be missed by this share of the velocities or loads, to find what lies on an edge.
EDGE = 1e-9

# Impulses, work, coefficients.

# Coefficients of friction and restitution below this are zero: they would only underflow.
NEGLIGIBLE = 1e-150
# [N s] Releases of less are none: a solution would leave the normal doubles for them.
LEAST_RELEASE = 1e-290
# A load below this share of the largest, or that moves its own contact by less than this share of
# the velocities, is none.
UNLOADED = 1e-12
# A contact has part in a shift of loads that moves nothing above this share of its square.
PART = 1e-9
# Impulses this many times those that make the velocities are of systems that are nearly singular:
# what they leave of the law is rounding of their own.
LARGEST = 1e8
# Work above this share of the energies in play is a gain. These are |P·u| of the velocities before
# and of those that blows alone would leave: of what rests and is struck the first are none. Blows
# and contacts act at one instant: work is P·(u + u⁺)/2 from the velocities before, or from those
# after the blows if these come first, and a gain is one by both accounts.
GAIN = 1e-10

# Residuals, and where iterations end.

# Residuals above this are no rounding: 1e5 times the 1e-14 that a solve may leave.
RESIDUAL_LIMIT = 1e-9
# What the residual of contacts that rub must come down to.
BAR = 1e-10
# What rounding leaves of the law's own equations.
ROUNDING = 2e-15
# The same of a sum over many contacts, as of W P beside J Δv, relative to its terms.
ROUNDING_OF_SUMS = 1e-14
# The same of the terms of a sum whose factors were solved for.
ROUNDING_OF_TERMS = 1e-13
# The last of Newton's steps on one number: less than half its rounding.
ARRIVED = 1e-16
# Impulses that a round of sweeps changes by less than this share of all velocities have settled.
SETTLED = 1e-13

# Rank. Pivots are relative to the diagonal, eigenvalues to the largest.

# Pivots above this leave no doubt that rows are independent.
CLEAR = 1e-6
# A pivot, an eigenvalue or a determinant below this share of its terms is a zero, where motions
# are looked for: 1e-5 of a length is.
SINGULAR = 1e-10
# In place of a pivot smaller than this, so that something can be divided by it.
LEAST_PIVOT = 1e-14
