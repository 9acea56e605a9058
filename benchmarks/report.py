"""The benchmark written up as Markdown: tables of rows and claims, and the diagrams."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from .claim import Claim
from .rows import Row

__all__ = ["claim_table", "detail_table", "main_table", "problem_table", "report", "time_text"]

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
