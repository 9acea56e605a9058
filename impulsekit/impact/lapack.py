"""The routines of LAPACK and BLAS that impacts call; scipy is loaded with the first of them.

On matrices as small as these, looking a name up in scipy at every call costs about as much as
the routine itself. ``lapack.dpotrf`` is looked up once.
"""

from __future__ import annotations

from typing import Any

ROUTINES = {
    "blas": ("dtrsm",),
    "lapack": ("dgesdd", "dgesv", "dpotrf", "dpotrs", "dpstrf"),
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
