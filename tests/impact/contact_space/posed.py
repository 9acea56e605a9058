"""Contact problems as the compiled law works on them."""

import numpy as np

from impulsekit.laws.frictional import clear_smooth, frictional
from impulsekit.laws.least_shares import share_least
from impulsekit.laws.modes import DEPENDENT, sizes_of
from impulsekit.laws.status import Status
from impulsekit.laws.workspace import workspace


def posed(W, b, mu, P=None):
    """The arguments of the law's parts: workspace, number of contacts, sizes."""
    n = len(b) // 3
    work = workspace(n)
    work.W[:], work.b[:], work.mu[:] = W, b, mu
    if P is not None:
        work.P[:] = P
    clear_smooth(work, n)
    return work, n, sizes_of(work, n, 0.0)


def solved_phase(W, b, mu):
    """Status and P of one phase, redundant load shared as under Poisson's law."""
    work, n, _ = posed(W, b, mu)
    # Compiled code does not warn of what is divided by zero, nor does Python in its place.
    with np.errstate(all="ignore"):
        code, residual = frictional.py_func(work, n, 0.0, False, 0.0, DEPENDENT)
        share_least.py_func(work, n, 0.0, DEPENDENT, residual)
    return Status(code), work.P
