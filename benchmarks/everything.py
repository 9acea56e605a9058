"""The whole benchmark into a folder: rows, claims, diagrams, report."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from impulsekit.errors import InputError

from .about import about
from .claim import Claim
from .methods.method import Method
from .rows import Row, read_table, write_table

__all__ = ["Wish", "whole"]


@dataclass(frozen=True)
class Wish:
    """What of the benchmark is to be run.

    Attributes:
        quick: small problems, few rounds, and only the claims that are measured soon.
        families: of problems; none for all.
        methods: those that are installed take part.
        parts: of "rows", "claims".
    """

    quick: bool
    families: tuple[str, ...]
    methods: tuple[Method, ...]
    parts: tuple[str, ...]


def whole(wish: Wish, folder: Path, tell: Callable[[str], object]) -> Path:
    """Run it and give the path of the report.

    Raises:
        InputError: the folder holds another run.
        UnknownNameError: a family that does not exist.
    """
    start = time.perf_counter()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "report.md"
    if path.exists():
        raise InputError(f"{path} is there already: name another folder")
    missing = {method.name: lack for method in wish.methods if (lack := method.missing())}
    rows: list[Row] = []
    claims: list[tuple[str, Claim]] = []
    if "rows" in wish.parts:
        rows = _rows(wish, tell)
        write_table(folder / "rows", rows)
        # The report rounds what the table holds, so that the two agree.
        rows = read_table(folder / "rows.csv")
    if "claims" in wish.parts:
        claims = _claims(wish, tell)
        told = [{"section": name, **asdict(one), "met": one.met} for name, one in claims]
        write_table(folder / "claims", told)
    from .diagrams import draw
    from .report import report

    facts, minutes = about(), (time.perf_counter() - start) / 60.0
    (folder / "about.json").write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    pictures = draw(rows, folder) if rows else []
    text = report(facts, rows, claims, pictures, missing, minutes)
    path.write_text(text, encoding="utf-8")
    return path


def _rows(wish: Wish, tell: Callable[[str], object]) -> list[Row]:
    from . import run
    from .problems.registry import problems

    present = [method for method in wish.methods if not method.missing()]
    effort = run.QUICK if wish.quick else run.WHOLE
    chosen = problems(wish.quick, wish.families)
    return run.run(chosen, present, effort=effort, tell=tell)


def _claims(wish: Wish, tell: Callable[[str], object]) -> list[tuple[str, Claim]]:
    from .claims import LONG_SECTIONS, SECTIONS, claims

    found: list[tuple[str, Claim]] = []
    for section in SECTIONS:
        if not (wish.quick and section in LONG_SECTIONS):
            tell(f"claims: {section}")
            found.extend(claims([section]))
    return found
