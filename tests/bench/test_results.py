"""What is shown of the benchmark is what was measured: documentation, report and rows agree."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.problems.registry import problems
from benchmarks.report import main_table, problem_table
from benchmarks.run import Row, read_table

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "benchmarks/results"
ROWS = read_table(RESULTS / "rows.csv")
ABOUT = json.loads((RESULTS / "about.json").read_text(encoding="utf-8"))

# Of the documentation's page.
CHOSEN = (
    "struck chain 40",
    "random tree 40",
    "struck robot 9",
    "struck robot 38",
    "held robot 12",
    "closed chain 8",
    "foot that slides 38",
    "feet 8",
    "landing block 16",
)


def short_table(rows: list[Row]) -> str:
    """A few problems, with the programs of which no method meets the tolerance."""
    shown = [row for row in rows if row.problem in CHOSEN]
    titles = "`solve_batch`", "quickest other"
    return problem_table(shown, titles, lambda row: row.name.split(",")[0])


def test_the_table_of_the_documentation_is_that_of_the_rows():
    page = (ROOT / "docs/benchmark.md").read_text(encoding="utf-8")
    assert short_table(ROWS) in page
    assert ABOUT["machine"] in page and ABOUT["date"] in page


def test_the_report_is_that_of_the_rows():
    report = (RESULTS / "report.md").read_text(encoding="utf-8")
    assert main_table(ROWS) in report
    for picture in RESULTS.glob("*.svg"):
        assert f"]({picture.name})" in report


def test_the_rows_are_of_todays_problems():
    assert {row.problem for row in ROWS} == {problem.name for problem in problems()}


def test_solve_meets_every_tolerance():
    ours = [row for row in ROWS if row.method == row.baseline]
    assert len(ours) == len({row.problem for row in ROWS})
    assert all(row.met for row in ours)


def test_results_are_small():
    own = [*RESULTS.glob("*.csv"), *RESULTS.glob("*.svg"), RESULTS / "report.md"]
    assert sum(path.stat().st_size for path in own) < 1_000_000
