"""The guard against getting slower counts; it never looks at a clock here."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.impact.counts import MOST, counted_solves, counts


@pytest.fixture(scope="module")
def solves():
    """Compiled when a test asks for them: at import every process would wait for it."""
    return counted_solves()


@pytest.mark.parametrize("name", MOST)
def test_a_solve_takes_no_more_calls_and_lines_than_it_should(solves, name):
    found, most = counts(solves[name]), MOST[name]
    assert found.calls <= most.calls
    assert found.lines <= most.lines


def test_every_counted_solve_has_its_most(solves):
    assert list(solves) == list(MOST)


def test_counting_is_exact_and_leaves_no_trace(solves):
    solve = solves["Panda, known blow"]
    before = sys.gettrace(), sys.getprofile()
    assert counts(solve) == counts(solve)
    assert (sys.gettrace(), sys.getprofile()) == before


def test_what_is_done_twice_counts_twice(solves):
    solve = solves["Talos, known blow"]
    once = counts(solve)

    def twice():
        solve()
        solve()

    assert counts(twice).calls >= 2 * once.calls
    assert not counts(twice).calls <= MOST["Talos, known blow"].calls


def test_the_gate_measures_the_ratios():
    lines = (Path(__file__).parents[2] / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert ".venv/bin/python -m benchmarks.claims guard" in lines
