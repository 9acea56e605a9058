"""``python -m benchmarks``: what counts as solved, what is kept, and what is written."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.__main__ import main
from benchmarks.claims import LONG_SECTIONS, SECTIONS, TABLE, OfProblem, claims
from benchmarks.methods.method import Method
from benchmarks.methods.registry import methods
from benchmarks.problems.blows import chain_problem
from benchmarks.problems.registry import problem_named, problems
from benchmarks.report import main_table
from benchmarks.run import Effort, about, measure, read_table, write_table
from benchmarks.timing import Claim, Times, Timing
from impulsekit.errors import UnknownNameError

SHORT = Effort(rounds=3, seconds=1e-4, longest=0.01)
QUICK = list(problems(quick=True))


def method(name, call, **more):
    return Method(name, lambda problem: True, lambda problem: call(problem), **more)


RIGHT = method("impulsekit, solve", lambda p: lambda: p.answer)
WRONG = method("quick and wrong", lambda p: lambda: 1.001 * p.answer, peer=True)
BROKEN = method("broken", lambda p: 1 / 0, peer=True)


# -- rows -------------------------------------------------------------------------------------


def test_a_method_that_misses_the_tolerance_has_not_solved():
    right, wrong = measure(chain_problem(3), [RIGHT, WRONG], SHORT)
    assert right.met and right.error == 0.0
    assert not wrong.met and wrong.error == pytest.approx(1e-3)
    assert "quick and wrong" in main_table([right, wrong]).splitlines()[2].split("|")[-2]


def test_rows_are_written_as_json_and_csv(tmp_path):
    rows = measure(chain_problem(3), [RIGHT, BROKEN], SHORT)
    write_table(tmp_path / "rows", rows)
    kept = json.loads((tmp_path / "rows.json").read_text())
    with (tmp_path / "rows.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [item["method"] for item in kept] == [line["method"] for line in table]
    assert kept[1]["seconds"] is None and table[1]["seconds"] == ""
    again = read_table(tmp_path / "rows.csv")
    assert again[1] == rows[1]
    assert again[0].seconds == pytest.approx(rows[0].seconds, rel=1e-3)


# -- times ------------------------------------------------------------------------------------


def test_a_claim_is_kept_on_its_side_of_the_bound():
    ours, theirs = Timing((1.0, 1.0, 1.0)), Timing((3.0, 3.0, 3.0))
    assert Claim.of_ratio("less", Times(ours, theirs), 0.5).met
    assert not Claim.of_ratio("less", Times(theirs, ours), 0.5).met
    faster = Claim.of_ratio("more", Times(ours, theirs, 10), 2.0, at_least=True)
    assert faster.value == pytest.approx(30.0) and faster.met
    assert "NOT at least 40" in replace(faster, bound=40.0).line()
    assert "at most" in Claim.of_values("seconds", [1.0, 2.0, 3.0], 2.0, "s").line()


# -- methods ----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("problem", QUICK, ids=lambda p: p.name)
def test_all_our_ways_do_what_they_can(problem):
    for one in methods(peers=False):
        if one.suits(problem):
            error = problem.error(np.asarray(one.prepare(problem)()))
            assert error < (1e-9 if one.setting is None else 0.2)


# -- the command --------------------------------------------------------------------------------


def command(*arguments):
    return CliRunner().invoke(main, [*map(str, arguments)])


FEW = ("-p", "random tree", "-m", "impulsekit, solve", "-m", "pinocchio")


@pytest.mark.slow
def test_the_command_writes_report_rows_and_diagrams(tmp_path):
    out = tmp_path / "out"
    done = command("--quick", "--part", "rows", *FEW, "-o", out)
    assert done.exit_code == 0, done.output
    assert done.stdout.strip() == str(out / "report.md")
    report = (out / "report.md").read_text()
    assert about()["machine"] in report and "random tree 10" in report
    assert {path.name for path in out.iterdir()} >= {"rows.csv", "rows.json", "error_blows.svg"}
    for picture in out.glob("*.svg"):
        assert f"]({picture.name})" in report
    again = command("--quick", "--part", "rows", *FEW, "-o", out)
    assert again.exit_code == 2 and "another folder" in again.stderr


def test_the_command_names_what_it_does_not_know(tmp_path):
    done = command("-p", "struck chains", "-o", tmp_path / "out")
    assert done.exit_code == 2 and "struck chain" in done.stderr


# -- claims -------------------------------------------------------------------------------------


def test_the_table_of_claims_names_problems_and_methods_that_there_are():
    known = {m.label: m for m in methods()}
    for row in TABLE:
        assert row.bound > 0.0
        if isinstance(row, OfProblem):
            problem = problem_named(row.family, row.problem)
            assert known[row.ours].suits(problem) and not known[row.ours].peer
            assert known[row.theirs].suits(problem) and known[row.theirs].peer
    assert set(LONG_SECTIONS) < set(SECTIONS)
    with pytest.raises(UnknownNameError, match="known blow"):
        next(claims(["known blows"]))


def test_what_misses_the_answer_is_not_quick(monkeypatch):
    ways = {"off": WRONG, "right": RIGHT}
    monkeypatch.setattr("benchmarks.claims.method_labelled", ways.__getitem__)
    monkeypatch.setattr("benchmarks.claims.ROUNDS", 3)
    row = OfProblem("blows", "struck chain", "struck chain 3", "right", "off", 1e6)
    (right,) = row.claims()
    (off,) = replace(row, ours="off", theirs="right").claims()
    assert right.met and not off.met
