"""The benchmark written up as Markdown: tables of rows and claims, and diagrams."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from impulsekit.errors import MissingExtraError

from .run import Row
from .timing import Claim

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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


TIME_UNITS = (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6))


def report(
    facts: Mapping[str, str],
    rows: Sequence[Row],
    claims: Sequence[tuple[str, Claim]],
    pictures: Iterable[Path],
    missing: Mapping[str, str],
    minutes: float,
) -> str:
    """The whole text.

    Args:
        facts: of ``about``.
        pictures: in the same folder as the text.
        missing: by program, why it was left out.
        minutes: that the whole took.
    """
    told = ", ".join(f"{name} {value}" for name, value in facts.items() if name not in HEAD)
    parts = [
        "# Run time against error\n",
        f"{facts['machine']}, {facts['date']}; {told}. The run took {minutes:.0f} minutes.\n",
        INTRODUCTION,
    ]
    if missing:
        parts.append("Left out: " + "; ".join(f"{m}: {why}" for m, why in missing.items()) + ".\n")
    if rows:
        parts += ["## By problem\n", MAIN, main_table(rows)]
        parts += [f"![{path.stem.replace('_', ' ')}]({path.name})\n" for path in pictures]
    if claims:
        parts += ["## Claims\n", CLAIMS, claim_table(claims)]
    if rows:
        parts += ["## Every row\n", DETAIL, detail_table(rows)]
    return "\n".join(parts)


HEAD = ("machine", "date")
INTRODUCTION = """\
Every problem has an answer that is known beyond double precision: fractions, closed forms, or
Kane's equations in 50 digits. Errors are relative to its largest entry. The methods of one
problem are timed in turn, round by round; times are medians, ratios are medians over the rounds,
with quartiles. **A method whose error is above the problem's tolerance has not solved it, and
its time does not count.**
"""
MAIN = """\
"others" is the quickest program but ours that meets the tolerance, on one state, and how many
times ours its time is. Batches are per state, on one thread or all cores, whichever is quicker.
"""
CLAIMS = """\
What is promised elsewhere, with its bound: the ratio of two times unless a unit is given.
"""
DETAIL = """\
"ratio" is to the baseline, `solve`, or `simulate` with rtol 1e-10; times in brackets miss the
tolerance.
"""


def main_table(rows: Sequence[Row]) -> str:
    """A line for each problem: ours, the batch, the best of the others, and who misses."""
    return problem_table(rows, ("batch", "others"), lambda row: row.name)


def problem_table(rows: Sequence[Row], titles: tuple[str, str], who: Callable[[Row], str]) -> str:
    """A line for each problem; ``who``: by what those are called that miss."""
    lines = []
    for own in _by_problem(rows):
        rivals = _rivals(own)
        missing = {who(row) for row in rivals} - {who(row) for row in rivals if row.met}
        lines.append([*_best(own), ", ".join(sorted(missing))])
    return _table(("problem", "`solve`", "error", *titles, "times ours", "miss"), lines)


def _by_problem(rows: Sequence[Row]) -> list[list[Row]]:
    """The rows of each problem that ours took part in."""
    names = dict.fromkeys(row.problem for row in rows if row.method == row.baseline)
    return [[row for row in rows if row.problem == name] for name in names]


def _rivals(own: Sequence[Row]) -> list[Row]:
    """Other programs on one state."""
    return [row for row in own if row.peer and row.states == 1 and row.seconds is not None]


def _best(own: Sequence[Row]) -> list[str]:
    """Ours with its error, the batch, and the quickest of the others with its ratio."""
    ours = next(row for row in own if row.method == row.baseline)
    batches = [row for row in own if row.name.startswith("impulsekit, batch") and row.met]
    batch = min(batches, key=lambda row: row.seconds or 0.0, default=None)
    good = [row for row in _rivals(own) if row.met]
    best = min(good, key=lambda row: row.seconds or 0.0, default=None)
    return [
        ours.problem,
        time_text(ours.seconds) if ours.met else f"({time_text(ours.seconds)})",
        _error(ours.error),
        time_text(batch.seconds) if batch else "",
        f"{time_text(best.seconds)}, {best.method}" if best else "",
        _number(best.ratio) if best else "",
    ]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    return "\n".join([*lines, *(f"| {' | '.join(cells)} |" for cells in rows)]) + "\n"


def detail_table(rows: Sequence[Row]) -> str:
    """Every row."""
    lines = []
    for row in rows:
        time = time_text(row.seconds)
        spread = f"{time_text(row.low)} to {time_text(row.high)}" if row.low else ""
        ratios = f"{_number(row.ratio_low)} to {_number(row.ratio_high)}" if row.ratio else ""
        time = time if row.met or not time else f"({time})"
        error = row.note.replace("|", "/") or _error(row.error)
        lines.append([row.problem, row.method, time, spread, error, _number(row.ratio), ratios])
    head = ("problem", "method", "time", "quartiles", "error", "ratio", "quartiles")
    return _table(head, lines)


def claim_table(claims: Sequence[tuple[str, Claim]]) -> str:
    """A line for each claim."""
    lines = []
    for section, claim in claims:
        value = f"{claim.value:.3g}{' ' + claim.unit if claim.unit else ''}"
        spread = f"{_number(claim.low)} to {_number(claim.high)}" if claim.low is not None else ""
        bound = f"{'≥' if claim.at_least else '≤'} {claim.bound:g}"
        label = f"{section}: {claim.label}"
        times, kept = map(time_text, (claim.ours, claim.theirs)), "yes" if claim.met else "**no**"
        lines.append([label, *times, value, spread, bound, kept])
    return _table(("what", "ours", "theirs", "value", "spread", "bound", "kept"), lines)


def time_text(seconds: float | None) -> str:
    """Three digits in the unit that fits."""
    if seconds is None:
        return ""
    for unit, scale in TIME_UNITS:
        if seconds >= scale or unit == "µs":
            return f"{seconds / scale:.3g} {unit}"
    return ""


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def _error(error: float | None) -> str:
    return "failed" if error is None else f"{error:.1e}"
