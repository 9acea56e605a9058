"""The display of results: one line or tables of plain text, plain data, tables in a notebook."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

# A line longer than this wraps in a terminal several times over.
LONGEST_LINE = 160
LONGEST_VALUE = 60
INDENT = "  "
GAP = "   "
# Beside the largest number of its table, what is smaller than this is rounding.
ROUNDING = 1e-13
# From here on a number is written with its exponent.
LONG_NUMBER = 1e7

_shown: list[Callable[[Any], str]] = []


class OneLine:
    """A dataclass whose ``repr`` is one line, however large its arrays are.

    The dataclass is declared with ``repr=False``, or its own ``__repr__`` would come first.

    Attributes:
        answer: the names of what is shown, the answer first; empty for all fields.
    """

    __slots__ = ()
    answer: ClassVar[tuple[str, ...]] = ()

    def __repr__(self) -> str:
        """The class and its answer, or its fields; arrays by their shape."""
        shown = self.answer or [
            field.name
            for field in fields(self)  # type: ignore[arg-type]
            if field.repr
        ]
        named: dict[str, Any] = {name: getattr(self, name, None) for name in shown}
        return one_line(type(self).__name__, **named)


def one_line(title: str, *first: str, **named: Any) -> str:
    """Return ``title(first, ..., name=value, ...)`` in one line.

    Args:
        title: the class.
        first: words as they are, such as a status.
        named: values, each cut to what can be read.

    Example:
        >>> import numpy as np
        >>> one_line("Fit", "CONVERGED", names=("e", "mu"), covariance=np.eye(2))
        "Fit(CONVERGED, names=('e', 'mu'), covariance=array(2, 2))"
    """
    inside = ", ".join([*first, *(f"{name}={_short(value)}" for name, value in named.items())])
    return _cut(f"{title}({inside})", LONGEST_LINE)


def _short(value: Any) -> str:
    shape = getattr(value, "shape", None)
    if isinstance(shape, tuple):
        # A dask array has a shape before it has values.
        small = len(shape) == 1 and isinstance(shape[0], int) and 0 < shape[0] <= 3
        if shape and not (small and hasattr(value, "tolist")):
            return f"array({', '.join(map(str, shape))})"
        if shape:
            return "[" + ", ".join(_short(x) for x in value.tolist()) + "]"
    if isinstance(value, float) or type(value).__module__ == "numpy":
        try:
            return f"{float(value):.6g}"
        except (TypeError, ValueError):
            pass
    if isinstance(value, Mapping) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    if isinstance(value, list | tuple) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    return _cut(" ".join(repr(value).split()), LONGEST_VALUE)


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else text[: longest - 4].rstrip(" ,") + " ..." + text[-1]


def show_with(html_of: Callable[[Any], str]) -> None:
    """Have notebooks show results by a function that gives valid HTML of one."""
    _shown[:] = [html_of]


class Displayed(OneLine):
    """A result that a notebook shows as tables, or as an interactive replay."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return _shown[0](self)


def plain(value: Any) -> Any:
    """Return a result in dictionaries, lists and numbers, as JSON has them.

    NaN and infinity, which JSON lacks, are None.

    Example:
        >>> import numpy as np
        >>> plain({"mass": np.array([1.0, np.inf]), 3: ("a",)})
        {'mass': [1.0, None], '3': ['a']}
    """
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


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
        """Return the line ``text`` of a table."""
        line = cls(text)
        line.table = table
        return line


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table; a column that holds numbers alone is aligned on the point.

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


def decimals(value: float, scale: float = 0.0, rounding: float = ROUNDING) -> str:
    """Return six significant digits; 0 where the value is ``rounding`` beside ``scale``.

    Example:
        >>> decimals(43.301270189), decimals(3e-17, scale=1.0)
        ('43.3013', '0')
    """
    return "0" if abs(value) <= rounding * scale or value == 0.0 else f"{value:.6g}"


def paper_decimals(value: float, scale: float = 0.0) -> str:
    """Return three decimals, or the first significant digit of what is smaller.

    The rounding of Table 1 in Chang & Huston 1995.

    Example:
        >>> [paper_decimals(x) for x in (17.320508, -0.333210, 0.000463, 0.0000661)]
        ['17.321', '-0.333', '0.0005', '0.00007']
    """
    if not math.isfinite(value) or abs(value) >= LONG_NUMBER:
        return f"{value:.6g}"
    if abs(value) <= ROUNDING * scale or value == 0.0:
        return "0"
    from decimal import Decimal

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
