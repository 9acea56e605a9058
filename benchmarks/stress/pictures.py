"""A picture per sweep: errors and bounds over the parameter, coloured by verdict."""

from __future__ import annotations

import math
import pathlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from impulsekit.view.plots.canvas import AFTER, BLOW, INK, QUIET, new_figure, tidy
from tests.truths.numbers import EPS

from .judge import BOUND
from .run import sweep_named
from .sweep import Point

__all__ = ["draw_sweep"]

# Errors of nothing are drawn here, those beyond the upper edge there.
LEAST, MOST = 1e-18, 1e2
COLOURS = {"right": AFTER, "said so": QUIET, "wrong": BLOW}
MOST_DOTS = 2500


def draw_sweep(points: Sequence[Point], path: pathlib.Path) -> None:
    """Draw the points of one sweep to a file.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    figure = new_figure(6.4, 3.0)
    _draw(figure.subplots(), points, sweep_named(points[0].sweep).name)
    figure.savefig(path, dpi=64)


def _draw(ax: Any, points: Sequence[Point], title: str) -> None:
    sweep = sweep_named(points[0].sweep)
    values = sorted({p.value for p in points})
    # Values that are no decades stand one beside the other.
    even = not sweep.logarithmic or values[0] <= 0.0
    places = {value: float(i) if even else math.log10(value) for i, value in enumerate(values)}
    spread = 0.3 * min(
        (b - a for a, b in zip(list(places.values()), list(places.values())[1:], strict=False)),
        default=1.0,
    )
    rng = np.random.default_rng(0)
    for verdict, colour in COLOURS.items():
        own = [p for p in points if p.verdict == verdict]
        if not own:
            continue
        shown = own
        if len(own) > MOST_DOTS:
            shown = [own[i] for i in rng.choice(len(own), MOST_DOTS, replace=False)]
        ax.plot(
            [places[p.value] + rng.uniform(-spread, spread) for p in shown],
            [_within(p.error) for p in shown],
            ".",
            markersize=2.5 if verdict != "wrong" else 5,
            color=colour,
            label=f"{verdict}: {len(own)}",
        )
    bounds = {
        value: [BOUND * EPS * p.condition for p in points if p.value == value and p.condition > 0]
        for value in values
    }
    known = [value for value in values if bounds[value]]
    for pick, style in ((np.median, "-"), (np.max, ":")):
        line = [_within(float(pick(bounds[value]))) for value in known]
        label = "10 cond eps, " + ("middle" if style == "-" else "largest")
        ax.plot([places[v] for v in known], line, style, color=INK, linewidth=1, label=label)
    ax.set_yscale("log")
    ax.set_ylim(LEAST / 3, MOST * 3)
    ax.set_ylabel("relative error")
    label = sweep.parameter.split(":")[0]
    if even:
        ax.set_xticks(list(places.values()), [f"{v:.3g}" for v in values], fontsize=6, rotation=60)
        ax.set_xlabel(label, fontsize=8)
    else:
        ax.set_xlabel(f"log10 of {label}", fontsize=8)
    ax.set_title(title)
    tidy(ax)
    ax.legend(fontsize=6, frameon=False, ncols=2, loc="upper left")


def _within(error: float) -> float:
    return MOST if not error < MOST else max(error, LEAST)
