"""A stress test written down: points as CSV, summary as JSON and Markdown, pictures."""

from __future__ import annotations

import csv
import json
import math
import pathlib
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from benchmarks.truths.numbers import EPS, truth_numbers
from impulsekit.view.plots.canvas import AFTER, IMPULSE, INK, QUIET, new_figure, tidy

from ..run import about
from .judge import AGREED, BACKWARD, BOUND, ILL_POSED
from .run import sweep_named
from .sweep import Point


@dataclass(frozen=True)
class Line:
    """A sweep, or all of them.

    Attributes:
        sweep: its name.
        scenes: different scenes and states.
        points: answers: of each scene by each method.
        right, said, wrong: how many points; said: the status or an error reports it as not valid.
        ill_posed: points for which even 10 condition eps is more than a thousandth.
        share: the largest error of a right, well-posed answer over condition times eps.
        error: the largest relative error of those.
        momentum, law: the largest residuals of those that are called valid.
        above: how many of those leave more of their equations than rounding does.
        microseconds: the middle time of ``solve``.
        statuses: how often each status or error came.
    """

    sweep: str
    scenes: int
    points: int
    right: int
    said: int
    wrong: int
    ill_posed: int
    share: float
    error: float
    momentum: float
    law: float
    above: int
    microseconds: float
    statuses: dict[str, int]

    @property
    def complaint(self) -> str:
        """What is wrong with the answers, in one line; empty if nothing is."""
        faults = []
        if self.wrong:
            faults.append(f"{self.wrong} silently wrong")
        if self.above:
            left = max(self.momentum, self.law)
            faults.append(
                f"{self.above} leave up to {left:.0e} of their equations, more than {BACKWARD:g}"
            )
        return f"{self.sweep}: {', '.join(faults)}" if faults else ""

    @property
    def said_share(self) -> float:
        """The part of the points that were reported as not valid."""
        return self.said / self.points if self.points else 0.0


def count_scenes(points: Iterable[Point]) -> int:
    """How many different scenes and states there are."""
    return len({(p.sweep, p.value, p.repeat, p.state) for p in points})


def is_ill_posed(point: Point) -> bool:
    """Whether the data determine the answer to less than a thousandth."""
    return point.condition * EPS * BOUND > ILL_POSED


def line_of(name: str, points: Sequence[Point]) -> Line:
    """The line of some points."""
    verdicts = Counter(p.verdict for p in points)
    valid = [p for p in points if p.verdict != "said so"]
    sound = [p for p in valid if p.verdict == "right" and not is_ill_posed(p)]
    seconds = [p.seconds for p in points if p.method == "solve"]
    return Line(
        name,
        count_scenes(points),
        len(points),
        verdicts["right"],
        verdicts["said so"],
        verdicts["wrong"],
        sum(is_ill_posed(p) for p in points),
        max((p.share for p in sound if math.isfinite(p.share)), default=0.0),
        max((p.error for p in sound if math.isfinite(p.error)), default=0.0),
        max((p.momentum for p in valid if not math.isnan(p.momentum)), default=0.0),
        max((p.law for p in valid if not math.isnan(p.law)), default=0.0),
        sum(p.momentum > BACKWARD or p.law > BACKWARD for p in valid),
        1e6 * statistics.median(seconds) if seconds else math.nan,
        dict(Counter(p.status for p in points).most_common()),
    )


def lines_of(points: Sequence[Point]) -> list[Line]:
    """The line of each sweep, in the order of the points."""
    by_sweep: dict[str, list[Point]] = {}
    for point in points:
        by_sweep.setdefault(point.sweep, []).append(point)
    return [line_of(name, own) for name, own in by_sweep.items()]


def whole_of(points: Sequence[Point]) -> Line:
    """The line of all sweeps."""
    return line_of("all", points)


def machine() -> str:
    """Date, kind of machine and versions, in one line."""
    facts = about()
    packages = ", ".join(
        f"{name} {facts[name]}" for name in ("Python", "impulsekit", "pin", "numpy")
    )
    return f"{facts['date']}, {facts['machine']}, {packages}; truth: {truth_numbers().name}"


# Errors of nothing are drawn here, those beyond the upper edge there.
LEAST, MOST = 1e-18, 1e2
COLOURS = {"right": AFTER, "said so": QUIET, "wrong": IMPULSE}
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


HEAD = (
    "sweep",
    "scenes",
    "answers",
    "said so",
    "silently wrong",
    "ill-posed",
    "worst error",
    "error / (cond eps)",
    "momentum left",
    "law left",
    "µs",
)


def cells(line: Line) -> tuple[str, ...]:
    """A line of the table."""
    return (
        line.sweep,
        f"{line.scenes}",
        f"{line.points}",
        f"{100 * line.said_share:.1f} %",
        f"{line.wrong}",
        f"{line.ill_posed}",
        f"{line.error:.0e}",
        f"{line.share:.2g}",
        f"{line.momentum:.0e}",
        f"{line.law:.0e}",
        "" if math.isnan(line.microseconds) else f"{line.microseconds:.0f}",
    )


def markdown(points: Sequence[Point], seconds: float, pictures: Sequence[str] = ()) -> str:
    """The report.

    Args:
        seconds: how long it took.
        pictures: names of picture files beside it, by sweep: "mass-ratio.png".
    """
    lines, whole = lines_of(points), whole_of(points)
    text = [
        "# Stress test",
        "",
        f"{whole.scenes} scenes, {whole.points} answers, **{whole.wrong} silently wrong**; "
        f"{100 * whole.said_share:.2f} % came with a status or an error that says they are no "
        "answer.",
        "",
        f"{machine()}. {seconds:.0f} s.",
        "",
        "Each answer is held against one in 50 digits: Kane's equations, Coulomb's law solved "
        "mode by mode, Routh's path in closed form, Whittaker's recursion. An answer that its "
        f"status calls valid is right where its error is at most {AGREED:g}, or {BOUND:g} times "
        "condition times eps; else it is silently wrong. The condition is Skeel's, of the linear "
        "equations that hold at the solution: it knows no norm and no units. "
        "Errors are velocities of matter, over the largest at hand. Ill-posed are answers for "
        "which even that bound is above "
        f"{ILL_POSED:g}: they count as right, too, if what they leave of their equations is below "
        f"{BACKWARD:g}, and are left out of the worst errors. "
        "Residuals are formed in 50 digits, over the sizes of the terms in them; µs is the "
        "middle time of `solve`.",
        "",
        "| " + " | ".join(HEAD) + " |",
        "|---|" + "---:|" * (len(HEAD) - 1),
        *("| " + " | ".join(cells(line)) + " |" for line in (*lines, whole)),
        "",
    ]
    for line in lines:
        sweep = sweep_named(line.sweep)
        told = ", ".join(f"{name} {count}" for name, count in line.statuses.items())
        text += [f"## {line.sweep}", "", f"{sweep.what} Over: {sweep.parameter}. {told}.", ""]
        wrong = [p for p in points if p.sweep == line.sweep and p.verdict == "wrong"][:5]
        text += [
            f"- silently wrong at {p.value:g} (repeat {p.repeat}, state {p.state}) by {p.method}: "
            f"{p.status}, error {p.error:.1e}, {p.share:.1e} condition eps"
            for p in wrong
        ]
        text += [""] if wrong else []
        name = f"{line.sweep}.png"
        if name in pictures:
            text += [f"![error and bound over {sweep.parameter}]({name})", ""]
    return "\n".join(text)


def write_report(
    points: Sequence[Point],
    folder: pathlib.Path,
    seconds: float,
) -> None:
    """Write stress.md, and beside it stress.json, points.csv and a picture per sweep.

    Raises:
        OSError: the folder cannot be written.
        MissingExtraError: matplotlib is not installed.
    """

    folder.mkdir(parents=True, exist_ok=True)
    drawn: list[str] = []
    for name in dict.fromkeys(p.sweep for p in points):
        drawn.append(f"{name}.png")
        draw_sweep([p for p in points if p.sweep == name], folder / drawn[-1])
    (folder / "stress.md").write_text(markdown(points, seconds, drawn), encoding="utf-8")
    summary = {
        "machine": machine(),
        "seconds": round(seconds, 1),
        "sweeps": [asdict(line) for line in (*lines_of(points), whole_of(points))],
    }
    (folder / "stress.json").write_text(json.dumps(summary, indent=1), encoding="utf-8")
    with (folder / "points.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([*(field.name for field in fields(Point)), "ill_posed"])
        writer.writerows([*point.row(), is_ill_posed(point)] for point in points)
