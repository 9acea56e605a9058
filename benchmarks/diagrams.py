"""Diagrams of the benchmark: run time against error, time over size, states a second."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from impulsekit.errors import MissingExtraError

from .rows import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw"]

# Families side by side in one picture, each at its largest size.
AGAINST_ERROR = {
    "blows": ("struck chain", "random tree", "struck robot", "held robot", "closed chain"),
    "contacts": (
        "falling rod",
        "rod along its path",
        "foot that slides",
        "feet",
        "slipping feet",
        "landing block",
    ),
    "motions": ("swing after a blow", "flight after a blow", "sliding block"),
}
OVER_SIZE = ("struck chain", "random tree", "closed chain", "landing block")
# One colour a program; its methods differ by marker.
COLOURS = {
    "impulsekit": "#1f5fa8",
    "pinocchio": "#d9730d",
    "numpy": "#8a8a8a",
    "scipy": "#8a8a8a",
    "mujoco": "#2f8f4e",
    "crocoddyl": "#9b3fb5",
    "exudyn": "#b8860b",
}
MARKERS = "osD^vP*X<>hp8d"
# Where an error is 0 it is drawn at the unit of rounding.
ROUNDING = 2.0**-53


def draw(rows: Sequence[Row], folder: Path) -> list[Path]:
    """All diagrams for which there are rows, as SVG.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    with MissingExtraError.unless("matplotlib", "plot", "the diagrams of a benchmark"):
        from matplotlib import rc_context
    paths = []
    # The same rows give the same file.
    with rc_context({"svg.hashsalt": "impulsekit", "svg.fonttype": "none", "font.size": 8}):
        for name, families in AGAINST_ERROR.items():
            shown = [largest for family in families if (largest := _largest(rows, family))]
            if shown:
                paths.append(_against_error(shown, folder / f"error_{name}.svg"))
        growing = [f for f in OVER_SIZE if len({r.size for r in rows if r.family == f}) > 1]
        if growing:
            paths.append(_over_size(rows, growing, folder / "over_size.svg"))
    return paths


def _largest(rows: Sequence[Row], family: str) -> list[Row]:
    """The rows of the largest problem of a family that have a time."""
    own = [row for row in rows if row.family == family and row.seconds is not None]
    most = max((row.size for row in own), default=0)
    return [row for row in own if row.size == most]


def _program(name: str) -> str:
    return name.split(",")[0]


def _styles(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Colour and marker of each method, in the order of the rows."""
    styles: dict[str, dict[str, Any]] = {}
    counts: dict[str, int] = {}
    for row in rows:
        if row.name not in styles:
            colour = COLOURS.get(_program(row.name), "#555555")
            marker = MARKERS[counts.get(colour, 0) % len(MARKERS)]
            counts[colour] = counts.get(colour, 0) + 1
            styles[row.name] = {"color": colour, "marker": marker}
    return styles


def _against_error(problems: Sequence[Sequence[Row]], path: Path) -> Path:
    from matplotlib.figure import Figure

    columns = min(3, len(problems))
    lines = -(-len(problems) // columns)
    figure = Figure(figsize=(3.4 * columns, 2.9 * lines + 1.2), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    styles = _styles([row for rows in problems for row in rows])
    for axes, rows in zip(panels, problems, strict=False):
        for name in dict.fromkeys(row.name for row in rows):
            _curve(axes, [row for row in rows if row.name == name], styles[name])
        axes.axvline(rows[0].tolerance, color="#999999", linewidth=0.7, linestyle=":")
        axes.set_title(rows[0].problem, loc="left")
        _logarithmic(axes, "relative error", "time a state [µs]")
    for axes in panels[len(problems) :]:
        axes.remove()
    _legend(figure, styles, 3 if columns > 1 else 1)
    return _saved(figure, path)


def _curve(axes: Axes, rows: Sequence[Row], style: dict[str, Any]) -> None:
    """One method: a line over its settings; hollow where it misses the tolerance."""
    ordered = sorted(rows, key=lambda row: row.setting or 0.0)
    x = [max(row.error or 0.0, ROUNDING) for row in ordered]
    y = [1e6 * (row.seconds or 0.0) for row in ordered]
    axes.plot(x, y, color=style["color"], linewidth=0.8, alpha=0.6)
    for met in (True, False):
        at = [i for i, row in enumerate(ordered) if row.met is met]
        axes.plot(
            [x[i] for i in at],
            [y[i] for i in at],
            linestyle="none",
            marker=style["marker"],
            markersize=5,
            color=style["color"],
            markerfacecolor=style["color"] if met else "none",
        )


def _over_size(rows: Sequence[Row], families: Sequence[str], path: Path) -> Path:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.4 * len(families), 4.4), layout="constrained")
    panels = figure.subplots(1, len(families), squeeze=False).ravel()
    # Of methods with settings, the first that meets the tolerance.
    good = [row for row in rows if row.met and row.family in families and row.seconds]
    styles = _styles(good)
    for axes, family in zip(panels, families, strict=True):
        for name, style in styles.items():
            best: dict[int, float] = {}
            for row in good:
                if row.family == family and row.name == name and row.seconds:
                    best[row.size] = min(best.get(row.size, row.seconds), row.seconds)
            if best:
                sizes = sorted(best)
                axes.plot(sizes, [1e6 * best[n] for n in sizes], markersize=4, linewidth=1, **style)
        axes.set_title(family, loc="left")
        _logarithmic(axes, "size", "time a state [µs]")
        sizes = sorted({row.size for row in good if row.family == family})
        axes.set_xticks(sizes, [str(size) for size in sizes])
    _legend(figure, styles, 4)
    return _saved(figure, path)


def _logarithmic(axes: Axes, x: str, y: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.minorticks_off()
    axes.grid(alpha=0.25, linewidth=0.5)
    axes.spines[["top", "right"]].set_visible(False)


def _legend(figure: Any, styles: dict[str, dict[str, Any]], columns: int) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], linestyle="none", markersize=5, label=name, **style)
        for name, style in styles.items()
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize=7
    )


def _saved(figure: Any, path: Path) -> Path:
    figure.savefig(path, metadata={"Date": None})
    return path
