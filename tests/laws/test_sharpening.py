"""Rounding of sums over many contacts is taken out of an answer where it is found."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.bench.problems.registry import problem_named
from impulsekit.impact.contact_space import refine
from impulsekit.impact.warm import compile_laws


@pytest.fixture
def refined(monkeypatch):
    """How often an answer was refined apart."""
    calls = []
    own = refine.refined
    monkeypatch.setattr(refine, "refined", lambda *a: calls.append(1) or own(*a))
    return calls


@pytest.mark.parametrize(
    ("family", "size"), [("landing block", 32), ("landing block", 16), ("smooth feet", 8)]
)
def test_answers_of_many_contacts_leave_the_one_call_at_rounding_level(refined, family, size):
    problem = problem_named(family, f"{family} {size}")
    compile_laws(problem.scene)
    rng = np.random.default_rng(size)
    for k in range(4):
        v = problem.v if k == 0 else problem.v * (1.0 + 0.05 * rng.uniform(size=problem.v.shape))
        impact = ik.solve(problem.scene, problem.q, v)
        assert impact.is_valid() and impact.residuals.complementarity < 2e-15
        if k == 0:
            assert problem.error(impact.v_after) < 1e-14
    assert not refined


def test_works_are_those_of_the_sharpened_impulses(refined):
    problem = problem_named("smooth feet", "smooth feet 8")
    compile_laws(problem.scene)
    impact = ik.solve(problem.scene, problem.q, problem.v)
    for contact in impact.contacts:
        mean = 0.5 * (np.asarray(contact.velocity_before) + np.asarray(contact.velocity_after))
        assert abs(contact.work - contact.impulse @ mean) < 1e-14
    assert abs(sum(impact.energy.work.values()) - impact.energy.change) < 1e-13
