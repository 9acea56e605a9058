"""Tables of plain text: names on the left, numbers aligned on their decimal points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

__all__ = ["ROUNDING", "Table", "TableLine", "decimals", "paper_decimals", "table"]

INDENT = "  "
GAP = "   "
# Beside the largest number of its table, what is smaller than this is rounding.
ROUNDING = 1e-13
# From here on a number is written with its exponent.
LONG_NUMBER = 1e7


@dataclass(frozen=True, eq=False)
class Table:
    """The cells behind the lines of a table."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def is_number_column(self, index: int) -> bool:
        """Return whether a column holds numbers alone."""
        return all(_is_number(row[index]) for row in self.rows)


class TableLine(str):
    """A line of plain text that knows its table, for forms other than plain text."""

    table: Table

    @classmethod
    def of(cls, text: str, table: Table) -> TableLine:
        """The line ``text`` of a table."""
        line = cls(text)
        line.table = table
        return line


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table; a column that holds numbers alone is aligned on the point.

    Example:
        >>> print("\\n".join(table(["point", "x"], [["a", "17.321"], ["b", "-0.0005"]])))
          point         x
          -----   -------
          a       17.321
          b       -0.0005
    """
    columns = []
    for title, cells in zip(head, zip(*rows, strict=True), strict=True):
        numeric = all(map(_is_number, cells))
        body = _on_the_point(cells) if numeric else list(cells)
        width = max(map(len, [title, *body]))
        align = str.rjust if numeric else str.ljust
        columns.append([align(cell, width) for cell in [title, "-" * width, *body]])
    whole = Table(tuple(head), tuple(tuple(row) for row in rows))
    lines = (INDENT + GAP.join(line) for line in zip(*columns, strict=True))
    return [TableLine.of(line.rstrip(), whole) for line in lines]


def decimals(value: float, scale: float = 0.0) -> str:
    """Six significant digits; 0 where the value is rounding beside ``scale``.

    Example:
        >>> decimals(43.301270189), decimals(3e-17, scale=1.0)
        ('43.3013', '0')
    """
    return "0" if abs(value) <= ROUNDING * scale or value == 0.0 else f"{value:.6g}"


def paper_decimals(value: float, scale: float = 0.0) -> str:
    """Three decimals, or the first significant digit of what is smaller.

    The rounding of Table 1 in Chang & Huston 1995.

    Example:
        >>> [paper_decimals(x) for x in (17.320508, -0.333210, 0.000463, 0.0000661)]
        ['17.321', '-0.333', '0.0005', '0.00007']
    """
    if not math.isfinite(value) or abs(value) >= LONG_NUMBER:
        return f"{value:.6g}"
    if abs(value) <= ROUNDING * scale or value == 0.0:
        return "0"
    first_digit = Decimal(f"{value:.0e}")
    if abs(first_digit) >= Decimal("0.001"):
        return f"{value:.3f}"
    return f"{first_digit:f}" if abs(first_digit) >= Decimal("1e-6") else f"{value:.0e}"


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return cell == ""
    return True


def _on_the_point(cells: Sequence[str]) -> list[str]:
    tails = [len(cell) - len(cell.split(".")[0].split("e")[0]) for cell in cells]
    return [cell + " " * (max(tails) - tail) for cell, tail in zip(cells, tails, strict=True)]
