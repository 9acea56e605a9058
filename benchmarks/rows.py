"""Rows of the benchmark: one a problem and method, kept as they come."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from impulsekit.display.plain import plain

__all__ = ["Row", "read_table", "write_table"]


@dataclass(frozen=True)
class Row:
    """One problem by one method. Times are per state.

    Attributes:
        problem: family and size.
        family, size: of the problem.
        method: its label: name and setting.
        name, setting: of the method; None for no setting.
        peer: whether it is another program's or a classical way.
        states: how many states a call answers.
        seconds: median over the rounds; None where it failed.
        low, high: quartiles [s].
        rounds: how many.
        error: relative, against the exact answer; None where it failed.
        tolerance: up to which the problem counts as solved.
        met: whether it was. A time without it is no time.
        baseline: the method that ``ratio`` is against, in the same rounds.
        ratio, ratio_low, ratio_high: of times, its median and quartiles.
        source: where the exact answer comes from.
        note: why it failed.
    """

    problem: str
    family: str
    size: int
    method: str
    name: str
    setting: float | None
    peer: bool
    states: int
    seconds: float | None
    low: float | None
    high: float | None
    rounds: int
    error: float | None
    tolerance: float
    met: bool
    baseline: str
    ratio: float | None
    ratio_low: float | None
    ratio_high: float | None
    source: str
    note: str = ""


def write_table(stem: Path, records: Iterable[Any]) -> None:
    """Rows of any one dataclass, or dictionaries, as ``stem``.json and ``stem``.csv."""
    items = [plain(row if isinstance(row, dict) else asdict(row)) for row in records]
    text = json.dumps(items, indent=1, ensure_ascii=False) + "\n"
    stem.with_suffix(".json").write_text(text, encoding="utf-8")
    _write_csv(stem.with_suffix(".csv"), items)


def read_table(path: Path) -> list[Row]:
    """The rows of a CSV file."""
    texts = {"problem", "family", "method", "name", "baseline", "source", "note"}
    whole = {"size", "states", "rounds"}
    rows = []
    with path.open(encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            values: dict[str, Any] = {}
            for name, text in line.items():
                if name in texts:
                    values[name] = text
                elif text in ("True", "False"):
                    values[name] = text == "True"
                else:
                    number = int if name in whole else float
                    values[name] = number(text) if text else None
            rows.append(Row(**values))
    return rows


def _write_csv(path: Path, items: list[dict[str, Any]]) -> None:
    """Numbers in four digits: the spread is wider than that."""
    names = list(items[0]) if items else [field.name for field in fields(Row)]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        for item in items:
            writer.writerow({name: _short(value) for name, value in item.items()})


def _short(value: Any) -> Any:
    return f"{value:.4g}" if isinstance(value, float) else value
