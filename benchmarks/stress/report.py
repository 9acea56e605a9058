"""A stress test written down: points as CSV, summary as JSON and Markdown, pictures."""

from __future__ import annotations

import csv
import json
import math
import pathlib
from collections.abc import Sequence
from dataclasses import asdict, fields

from .judge import BACKWARD, BOUND, ILL_POSED
from .run import sweep_named
from .summary import Line, is_ill_posed, lines_of, machine, whole_of
from .sweep import Point

__all__ = ["HEAD", "cells", "markdown", "write_report"]

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
        f"status calls valid is right where its error is at most {BOUND:g} times condition times "
        "eps; else it is silently wrong. The condition is Skeel's, of the linear equations that "
        "hold at the solution: it knows no norm and no units. Errors are velocities of matter, "
        "over the largest at hand. Ill-posed are answers for which even that bound is above "
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
    from .pictures import draw_sweep

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
