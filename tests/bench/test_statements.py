"""Laws of contact against their own statements: a small share, and faults that are seen."""

import dataclasses

import numpy as np
import pytest

from impulsekit.bench.stress import statements
from impulsekit.bench.stress.run import jobs_of, solved_case
from impulsekit.bench.stress.statements import SWEEPS

SHARES = {"statement-turning": 8, "statement-adhesion": 10, "statement-friction": 8}


@pytest.mark.parametrize("sweep", SWEEPS, ids=lambda sweep: sweep.name)
def test_every_answer_obeys_its_statement(sweep):
    share = SHARES.get(sweep.name, 1) / sweep.repeats
    points = [p for job in jobs_of([sweep], seed=5, share=share) for p in solved_case(job)]
    assert [p for p in points if p.verdict == "wrong"] == []
    assert sum(p.verdict == "right" for p in points) > 0.9 * len(points)


@pytest.mark.parametrize("sweep", SWEEPS[:3], ids=lambda sweep: sweep.name)
def test_an_impulse_that_is_off_is_seen(sweep, monkeypatch):
    """A thousandth more of all impulses breaks every statement."""
    plain = statements.find_impulses

    def off(problem, law):
        found = plain(problem, law)
        return dataclasses.replace(found, impulse=1.001 * found.impulse)

    monkeypatch.setattr(statements, "find_impulses", off)
    points = sweep.cases(2.0, np.random.default_rng(2))
    moved = [p for p in points if p.error > 0.0]
    assert moved and sum(p.verdict == "wrong" for p in moved) >= len(moved) // 2
