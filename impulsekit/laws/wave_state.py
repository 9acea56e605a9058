"""The state of several contacts while their impulses grow, and its rates.

Each contact has an indentation δ, its normal force is F = κ δ^n. In compression dδ/dt = −u_n, in
restitution −u_n/e², so that the force regains e² of the work of the compression, and is
continuous (the bi-stiffness law of Liu, Zhao & Brogliato 2008): dP_i/dP_j = F_i/F_j depends on
stiffness ratios and stored energies E = κ δ^(n + 1)/(n + 1) alone. Time t, indentation and force
are in units in which all are of size 1; no result depends on the absolute stiffness.

A contact whose stiffness is infinite beside the others, or that loses all its energy at the
end of its compression (e = 0), is held: u_n = 0, F from the equations of motion, F ≥ 0.

Friction opposes the slip of each instant: it slides, or sticks as long as its force stays in the
cone. Slip that starts from rest creeps at first: it goes where its acceleration goes, as the slip
of a single contact does exactly, for its own direction would be lost in rounding. Contacts that
stick and depend on each other share friction in proportion to what their cones hold, so that
none is beyond its cone as long as all can hold together; one that gives all it has, while others
hold it still, leans.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .compiled import compiled

__all__ = [
    "AFTER", "BEGAN", "CREEPS", "FAINT", "HELD", "LEANS", "LOADS", "NONE", "OPEN", "SLIPS",
    "STICKS", "UNLOADS", "Array", "Grid", "Integers", "Matrix", "Wave", "wave",
]  # fmt: skip

Array = np.ndarray[tuple[int], np.dtype[np.float64]]
Integers = np.ndarray[tuple[int], np.dtype[np.int64]]
Grid = np.ndarray[tuple[int, int], np.dtype[np.int64]]
Matrix = np.ndarray[tuple[int, int], np.dtype[np.float64]]

# What a contact does along its normal, and along its tangents.
OPEN, LOADS, UNLOADS, HELD = 0, 1, 2, 3
NONE, SLIPS, STICKS, CREEPS, LEANS = 0, 1, 2, 3, 4
# Slip below this has the direction that it was given: it starts or ends there.
FAINT = 1e-11
# Rows of ``Wave.stages`` behind the 12 of a step. (An array more in the tuple, the 33rd, makes
# compiled code with friction take twice as long.)
BEGAN, AFTER = 12, 13


class Wave(NamedTuple):
    """Contacts in units of their own; the rows are the normals and the tangents that rub.

    Attributes:
        W: (r, r) Delassus matrix. free: (r,) u_free.
        reach: (r, 2) the first column of each row of W that is not 0, and that behind the last.
        normal, tangent: (n,) row of the normal, of the first tangent or −1.
        kappa: (n,) stiffness, the largest finite one being 1; infinite: held.
        e2: (n,) e². mu: (n,) friction.
        power: (1,) n.
        mode, slip: (n,) along the normal and along the tangents.
        way: (n, 3) the direction of slip where it began; what was left of it, beyond rest, when
            it began from there (<= 0).
        pulls: (r, r + 4) how friction of what creeps together accelerates it, and how it is
            without in the column behind; the last three by contact: whether it stuck before some
            began to slip, and the direction against its friction then.
        y: P by row (r), δ by contact (n), and where any rubs the work of friction (n).
        u: (r,) velocity. force: (r,) dP/dt.
        began, loaded: (n,) E where the loading at hand began; all that was loaded so far.
        matrix, right, order: room for what sticks or is held.
        rows: (r + n,) those rows, and behind r the contacts that creep.
        solved: (1,) how many. redundant: (1,) whether they depend.
        load: (n,) the normal force of what is held, before the step.
        share: (n,) by how much less than its cone allows a contact takes of what is shared.
        stages, trial, error: room of a step; in the last two rows of stages, ``BEGAN`` and
            ``AFTER``, the forces where it began and a little behind its end.
        lead: (1,) the contact whose √δ is the variable of the step; −1: time.
        pace: (1,) its dδ/dt where the step begins.
        stiff: (1,) whether steps are implicit.
    """

    W: Matrix
    reach: Grid
    free: Array
    normal: Integers
    tangent: Integers
    kappa: Array
    e2: Array
    mu: Array
    power: Array
    mode: Integers
    slip: Integers
    way: Matrix
    pulls: Matrix
    y: Array
    u: Array
    force: Array
    began: Array
    loaded: Array
    matrix: Matrix
    right: Array
    order: Integers
    rows: Integers
    solved: Integers
    redundant: Integers
    load: Array
    share: Array
    stages: Matrix
    trial: Array
    error: Array
    lead: Integers
    pace: Array
    stiff: Integers


@compiled
def wave(n: int, r: int) -> Wave:
    """Memory for n contacts with r rows."""
    m = r + n if r == n else r + 2 * n
    return Wave(
        np.zeros((r, r)),
        np.zeros((r, 2), dtype=np.int64),
        np.zeros(r),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(1),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros((n, 3)),
        np.zeros((r, r + 4)),
        np.zeros(m),
        np.zeros(r),
        np.zeros(r),
        np.zeros(n),
        np.zeros(n),
        np.zeros((r, r)),
        np.zeros(r),
        np.zeros(r, dtype=np.int64),
        np.zeros(r + n, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        np.zeros(n),
        np.ones(n),
        np.zeros((AFTER + 1, m)),
        np.zeros(m),
        np.zeros(m),
        np.full(1, -1),
        np.zeros(1),
        np.zeros(1, dtype=np.int64),
    )
