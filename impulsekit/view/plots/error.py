"""Run time against error: how much accuracy costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...errors import ShapeError
from .canvas import CYCLE, axes_or_new, plain, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["time_against_error"]

MARKERS = "osD^vP*X"
# Where an error is 0, it is drawn at the unit of rounding.
LEAST_ERROR = 2.0**-53


def time_against_error(
    methods: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    ax: Axes | None = None,
    *,
    error: str = "relative error",
    per: str = "run time",
) -> Axes:
    """Run times over errors of several methods, both logarithmic. Down and left is better.

    Args:
        methods: by name, the errors of each run and the seconds it took.
        ax: where to draw; a new figure if None.
        error: what the error is, with its unit if it has one.
        per: what the seconds are for.

    Raises:
        ShapeError: errors and seconds that are not as many.
        MissingExtraError: matplotlib is not installed.

    Example:
        >>> ax = time_against_error({"rk4": ([1e-3, 1e-6], [0.01, 0.06])})
        >>> ax.get_xscale(), ax.get_ylabel()
        ('log', 'run time [s]')
    """
    ax = axes_or_new(ax)
    for i, (name, (errors, seconds)) in enumerate(methods.items()):
        if len(errors) != len(seconds):
            what = f'time_against_error: seconds of "{name}"'
            raise ShapeError.of(what, (len(errors),), (len(seconds),))
        order = np.argsort(errors)
        ax.plot(
            np.maximum(np.asarray(errors, dtype=float)[order], LEAST_ERROR),
            np.asarray(seconds, dtype=float)[order],
            marker=MARKERS[i % len(MARKERS)],
            color=CYCLE[i % len(CYCLE)],
            linewidth=1.2,
            markersize=6,
            label=plain(name),
        )
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel(error)
    ax.set_ylabel(f"{per} [s]")
    ax.set_title("Run time against error", loc="left")
    if methods:
        ax.legend(frameon=False)
    return tidy(ax)
