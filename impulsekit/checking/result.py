"""``Check``: what was compared, how far apart it is, and the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..display import Displayed, one_line

__all__ = ["Check", "CheckRow"]


@dataclass(frozen=True, eq=False)
class CheckRow:
    """One quantity by both programs.

    Attributes:
        name: what it is.
        unit: of the entries; several where they differ from entry to entry.
        entries: (k,) the name of each entry.
        ours, reference: (k,) the numbers, read-only.
        difference: the largest difference of an entry, relative to ``scale``.
        scale: in words, what the difference is relative to.
        tolerance: what the difference may be.
        worst: the index of the entry that is furthest apart.
    """

    name: str
    unit: str
    entries: tuple[str, ...]
    ours: np.ndarray
    reference: np.ndarray
    difference: float
    scale: str
    tolerance: float
    worst: int

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the tolerance; NaN is not."""
        return bool(self.difference <= self.tolerance)

    def __repr__(self) -> str:
        verdict = "agrees" if self.agrees else "DISAGREES"
        return f"CheckRow({self.name!r}, {self.difference:.1e} of {self.tolerance:.1e}: {verdict})"


@dataclass(frozen=True, eq=False, repr=False)
class Check(Displayed):
    """An impact beside its reference.

    Attributes:
        rows: the quantities, in the order of a report.
        tolerance: what their differences may be; see :func:`impulsekit.check`.
        condition: of the generalized masses, scaled to unit diagonal.
        condition_of_rows: the same of the Delassus matrix of the independent constraint
            rows; 1 without any.
        numbers: what the reference computed in, such as "double".
        notes: what has to be known of how it was compared.
    """

    rows: tuple[CheckRow, ...]
    tolerance: float
    condition: float
    condition_of_rows: float
    numbers: str
    notes: tuple[str, ...] = ()

    @property
    def agrees(self) -> bool:
        """Whether every row agrees."""
        return all(row.agrees for row in self.rows)

    def row(self, name: str) -> CheckRow:
        """The row of this name.

        Raises:
            UnknownNameError: there is none.
        """
        for row in self.rows:
            if row.name == name:
                return row
        from ..errors import UnknownNameError

        raise UnknownNameError.among("row of a check", name, (row.name for row in self.rows))

    def report(self) -> str:
        """The comparison as a table: each quantity at the entry that is furthest apart."""
        return "\n".join(self.lines()) + "\n"

    def lines(self) -> list[str]:
        """The lines of the report; those of the table know its cells."""
        from ..display.table import table

        lines = [
            f"Check against Kane's equations ({self.numbers}), furthest entry of each quantity"
        ]
        head = ["quantity", "entry", "ours", "reference", "unit", "difference", "agrees"]
        lines += table(head, [_cells(row) for row in self.rows])
        lines += [f"  {note}" for note in self.notes]
        conditions = f"condition of M {self.condition:.1e}"
        if self.condition_of_rows > 1.0:
            conditions += f", of the constraint rows {self.condition_of_rows:.1e}"
        lines.append(f"  {conditions}: differences up to {self.tolerance:.1e} are rounding")
        failed = [row.name for row in self.rows if not row.agrees]
        verdict = f"NO, in {_listed(failed)}" if failed else "yes"
        lines.append(f"Agrees: {verdict}")
        return lines

    def __repr__(self) -> str:
        verdict = "AGREES" if self.agrees else "DISAGREES"
        worst = max(self.rows, key=lambda row: row.difference / row.tolerance, default=None)
        furthest = [] if worst is None else [f"furthest {worst.name}: {worst.difference:.1e}"]
        count = f"{len(self.rows)} quantities to {self.tolerance:.1e}"
        return one_line("Check", verdict, count, *furthest, numbers=self.numbers)

    def __str__(self) -> str:
        return self.report()

    def __bool__(self) -> bool:
        return self.agrees


def _cells(row: CheckRow) -> list[str]:
    entry, ours, reference = "-", "-", "-"
    if row.entries:
        entry = row.entries[row.worst]
        ours, reference = f"{row.ours[row.worst]:.9g}", f"{row.reference[row.worst]:.9g}"
    verdict = "yes" if row.agrees else "NO"
    return [row.name, entry, ours, reference, row.unit, f"{row.difference:.1e}", verdict]


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
