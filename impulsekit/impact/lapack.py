"""The routines of LAPACK and BLAS that impacts call; scipy is loaded with the first of them.

On matrices as small as these, looking a name up in scipy at every call costs about as much as
the routine itself. ``lapack.dpotrf`` is looked up once.
"""

from __future__ import annotations

from typing import Any

import numpy as np

# OpenBLAS starts threads for a triangle with more right-hand sides than make so many numbers,
# which takes it a thousand times as long as these; where it has to, larger ones pay.
WITHOUT_THREADS, WITH_THREADS = 1024, 512

ROUTINES = {
    "blas": ("dtrsm",),
    "lapack": ("dgeqp3", "dgesdd", "dgesv", "dpotrf", "dpotrs", "dpstrf", "dtrtri"),
}


def __getattr__(name: str) -> Any:
    """A routine, the first time: all of them are put into this module.

    Raises:
        AttributeError: none of them has this name.
    """
    import scipy.linalg

    for library, names in ROUTINES.items():
        routines = getattr(scipy.linalg, library)
        globals().update((routine, getattr(routines, routine)) for routine in names)
    try:
        return globals()[name]
    except KeyError:
        raise AttributeError(f"impulsekit.impact.lapack has no routine {name!r}") from None


def solve_triangle(
    dtrsm: Any, triangle: np.ndarray, columns: np.ndarray, **options: int
) -> np.ndarray:
    """(n, m) X with T X = columns, by ``dtrsm`` and its options; columns (n, m) may be overwritten.

    Args:
        dtrsm: the routine of that name here.
        triangle: (n, n) T. columns: (n, m). options: ``lower``, ``trans_a`` and ``diag``.
    """
    if columns.size <= WITHOUT_THREADS or len(columns) > WITH_THREADS:
        return dtrsm(1.0, triangle, columns, overwrite_b=1, **options)
    n, m = columns.shape
    found, few = np.empty((n, m), order="F"), WITHOUT_THREADS // n
    for first in range(0, m, few):
        part = columns[:, first : first + few]
        found[:, first : first + few] = dtrsm(1.0, triangle, part, **options)
    return found
