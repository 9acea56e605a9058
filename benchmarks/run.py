"""Problems by methods: all timed in turn, each answer judged, all of it written down."""

from __future__ import annotations

import csv
import datetime
import gc
import json
import os
import platform
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from impulsekit import __version__
from impulsekit.errors import InputError
from impulsekit.formatting import plain

from .methods.method import Answer, Method
from .problems.problem import Problem
from .timing import Claim, Ratio, Timing, time_in_turn

PACKAGES = (
    "pin",
    "numpy",
    "scipy",
    "mujoco",
    "exudyn",
    "crocoddyl",
    "example-robot-data",
)


def about() -> dict[str, str]:
    """Facts by name, as text. The machine is told by its kind, not by its name."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    facts = {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "machine": f"{cores}-core {platform.machine().replace('_', '-')}",
        "system": platform.system(),
        "Python": platform.python_version(),
        "impulsekit": __version__,
    }
    for name in PACKAGES:
        try:
            facts[name] = version(name)
        except PackageNotFoundError:
            continue
    return facts


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


# What ratios are against: the first of these that took part.
BASELINES = ("impulsekit, solve", "impulsekit, simulate dop853, 1e-10")


@dataclass(frozen=True)
class Effort:
    """How long is measured.

    Attributes:
        rounds: of each method.
        seconds: of a round, about.
        longest: a method that would take longer on a problem has fewer rounds [s].
    """

    rounds: int
    seconds: float
    longest: float


WHOLE = Effort(rounds=401, seconds=0.0003, longest=1.0)
QUICK = Effort(rounds=51, seconds=0.0003, longest=0.1)


def run(
    problems: Iterable[Problem],
    methods: Sequence[Method],
    *,
    effort: Effort = WHOLE,
    tell: Callable[[str], object] = lambda name: None,
) -> list[Row]:
    """The rows of all problems and methods; ``tell`` hears of each problem as it begins."""
    rows: list[Row] = []
    for problem in problems:
        tell(problem.name)
        rows += measure(problem, [m for m in methods if m.suits(problem)], effort)
        # What Pinocchio keeps for a long chain is large.
        gc.collect()
    return rows


def measure(problem: Problem, methods: Sequence[Method], effort: Effort) -> list[Row]:
    """The rows of one problem."""
    calls: dict[str, Answer] = {}
    errors: dict[str, float] = {}
    notes: dict[str, str] = {}
    for method in methods:
        try:
            call = method.prepare(problem)
            errors[method.label] = problem.error(np.asarray(call()))
            calls[method.label] = call
        except Exception as fault:
            # A method of another program may fail in any way; that is its row.
            notes[method.label] = f"{type(fault).__name__}: {fault}".splitlines()[0][:200]
    times = time_in_turn(calls, effort.rounds, effort.seconds, longest=effort.longest, warm=False)
    baseline = next((name for name in BASELINES if name in times), "")
    return [
        _row(problem, method, times, baseline, errors, notes.get(method.label, ""))
        for method in methods
    ]


def _row(
    problem: Problem,
    method: Method,
    times: dict[str, Timing],
    baseline: str,
    errors: dict[str, float],
    note: str,
) -> Row:
    timing, error = times.get(method.label), errors.get(method.label)
    ratio = None
    if timing and baseline:
        # The baseline answers one state a call.
        ratio = Ratio.of(timing, times[baseline], method.states)
    low, high = timing.quartiles if timing else (None, None)
    return Row(
        problem=problem.name,
        family=problem.family,
        size=problem.size,
        method=method.label,
        name=method.name,
        setting=method.setting,
        peer=method.peer,
        states=method.states,
        seconds=timing.median / method.states if timing else None,
        low=low / method.states if low else None,
        high=high / method.states if high else None,
        rounds=len(timing.rounds) if timing else 0,
        error=error,
        tolerance=problem.tolerance,
        met=error is not None and error <= problem.tolerance,
        baseline=baseline if ratio else "",
        ratio=ratio.median if ratio else None,
        ratio_low=ratio.low if ratio else None,
        ratio_high=ratio.high if ratio else None,
        source=problem.source,
        note=note,
    )


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
    from .report import draw, report

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
