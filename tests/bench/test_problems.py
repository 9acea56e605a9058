"""The problems of the benchmark: their answers are exact, kept ones are not old, and they hold."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

import impulsekit as ik
from benchmarks.problems import problem as kept
from benchmarks.problems.answers import decimals
from benchmarks.problems.blows import (
    tree_problem,
)
from benchmarks.problems.registry import problems
from benchmarks.truths.planar import planar_impulses

QUICK = list(problems(quick=True))
IMPACTS = [problem for problem in QUICK if not problem.duration]


@pytest.mark.parametrize("problem", IMPACTS, ids=lambda p: p.name)
def test_solve_finds_the_answer(problem):
    impact = ik.solve(problem.scene, problem.q, problem.v)
    assert problem.error(impact.v_after) < 1e-11
    assert impact.status.valid


# -- kept answers -----------------------------------------------------------------------------


def kept_problems():
    return [problem for problem in problems() if hasattr(problem.exact, "derive")]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["random tree 5", "struck robot 9", "closed chain 3"])
def test_kept_answers_come_out_again(name):
    (problem,) = [p for p in kept_problems() if p.name == name]
    entry = kept.kept(problem.family)[str(problem.size)]
    assert decimals(problem.exact.derive()) == entry["answer"]


def test_an_old_answer_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "FOLDER", tmp_path)
    kept.kept.cache_clear()
    stale = {"5": {"of": "another robot", "answer": ["0"] * 10}}
    (tmp_path / "random_tree.json").write_text(json.dumps(stale))
    problem = tree_problem(5)
    assert problem.error(ik.solve(problem.scene, problem.q, problem.v).v_after) < 1e-13
    kept.kept.cache_clear()


# -- where the answers come from -----------------------------------------------------------------


def test_routh_in_the_plane():
    """W of a rod; its end slides, sticks, and leaves with e times the work regained."""
    w = (Fraction(2), Fraction(1, 2), Fraction(1))
    half = Fraction(1, 2)
    ((p_t, p_n),) = planar_impulses((*w, 0, Fraction(-1)), half, 1, "stronge", "path")
    # At rest along, u_n' = w_nn − w_tn²/w_tt all the way: p = (1 + e)/(7/8).
    assert float(p_n) == pytest.approx(1.5 / 0.875, rel=1e-15)
    assert float(p_t) == pytest.approx(-0.25 * 1.5 / 0.875, rel=1e-15)
    # Slip stops at p = 1/2, then it sticks; without restitution all motion of the end is lost.
    data = (*w, half, Fraction(-1))
    ((p_t, p_n),) = planar_impulses(data, Fraction(0), Fraction(3, 4), "stronge", "path")
    assert half + w[0] * p_t + w[1] * p_n == pytest.approx(0, abs=1e-15)
    assert -1 + w[1] * p_t + w[2] * p_n == pytest.approx(0, abs=1e-15)
    assert p_t == pytest.approx(-4 / 7)
