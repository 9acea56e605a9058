"""``Section``: what is told of one set of recorded data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Section:
    """A part of the report on recorded data.

    Attributes:
        title: of the data.
        lines: of text.
        figures: (what was measured, ours, others') for the table of all.
    """

    title: str
    lines: Sequence[str]
    figures: Sequence[tuple[str, str, str]] = field(default_factory=tuple)

    def __str__(self) -> str:
        return "\n".join(self.lines) + "\n"


def joined(sections: Sequence[Section]) -> str:
    """All sections, and behind them one table of their figures."""
    if len(sections) == 1:
        return str(sections[0])
    parts = [f"{each.title}\n{'=' * len(each.title)}\n{each}" for each in sections]
    rows = [("measured", "impulsekit", "others")]
    rows += [figure for each in sections for figure in each.figures]
    widths = [max(len(row[k]) for row in rows) for k in range(2)]
    table = [f"{a:{widths[0]}}  {b:{widths[1]}}  {c}".rstrip() for a, b, c in rows]
    return "\n".join([*parts, *table]) + "\n"
