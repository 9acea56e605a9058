"""An answer that gains energy is not shown where another obeys the law and gains none."""

import dataclasses

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.bench.truths.enumerated import whole_answers
from impulsekit.impact.contact_space import ContactProblem, quiet, solve_contacts

from .test_uniqueness import bodies_in_a_plane

# Where the answer that is reached from sticking gains energy, and others do not.
BESIDE_GAIN = [("newton", 5041), ("newton", 5251), ("newton", 5545), ("poisson", 5469)]
RUBS = (0.0, 1.0, 3.0, 10.0)


def posed(law, seed):
    scene, v, problem = bodies_in_a_plane(seed, frictions=RUBS)
    scene = dataclasses.replace(scene, law=ik.Law(restitution=law))
    return scene, v, [one for one in whole_answers(problem, law) if not one.gains]


@pytest.mark.parametrize(("law", "seed"), BESIDE_GAIN)
def test_the_answer_of_least_energy_among_those_that_gain_none_is_shown(law, seed):
    scene, v, lawful = posed(law, seed)
    q = scene.robot.neutral()
    impact = ik.solve(scene, q, v)
    assert min(np.abs(impact.v_after - one.velocity).max() for one in lawful) < 1e-13
    assert impact.status is (ik.Status.SOLVED if len(lawful) == 1 else ik.Status.MANY_SOLUTIONS)
    assert impact.is_valid() == (len(lawful) == 1)
    assert len(impact.uniqueness.others) == len(lawful) - 1
    masses = impact.mechanics.mass_matrix
    energies = [one.velocity @ masses @ one.velocity for one in lawful]
    assert impact.v_after @ masses @ impact.v_after == pytest.approx(min(energies), rel=1e-12)
    if len(lawful) > 1:
        assert "least energy" in impact.uniqueness.rule
    books = sum(impact.energy.work.values())
    assert books == pytest.approx(impact.energy.change, abs=1e-13)
    assert impact.residuals.momentum < 1e-13 and impact.residuals.complementarity < 1e-13


@pytest.mark.parametrize(("law", "seed"), BESIDE_GAIN)
def test_neither_order_axes_nor_units_choose(law, seed, monkeypatch):
    problems = []
    given = quiet.without_gain

    def seen(problem, solution, *, newton):
        problems.append(problem)
        return given(problem, solution, newton=newton)

    monkeypatch.setattr(quiet, "without_gain", seen)
    scene, v, _ = posed(law, seed)
    ik.solve(scene, scene.robot.neutral(), v)
    problem, rule = problems[0], ik.Law(restitution=law)
    # What moves out of the plane has a mass of its own, so that tangents may be turned.
    W = problem.delassus.copy()
    still = np.flatnonzero(np.abs(W).max(axis=0) < 1e-12)
    W[still, still] = 1.0
    problem = dataclasses.replace(problem, delassus=W)
    first = solve_contacts(problem, rule)
    rng, n = np.random.default_rng(seed), len(problem.friction)
    for _ in range(3):
        order = rng.permutation(n)
        rows = (3 * order[:, None] + np.arange(3)).ravel()
        turned = np.zeros((3 * n, 3 * n))
        for i, angle in enumerate(rng.uniform(0.0, 6.0, n)):
            c, s = np.cos(angle), np.sin(angle)
            turned[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        change, kilograms, metres = turned @ np.eye(3 * n)[rows], 1e3, 1e-2
        again = solve_contacts(
            ContactProblem(
                kilograms * change @ problem.delassus @ change.T,
                metres * change @ problem.velocity_before,
                metres * change @ problem.velocity_free,
                problem.restitution[order],
                problem.friction[order],
                problem.tangential_restitution[order],
            ),
            rule,
        )
        assert again.status is first.status
        back = change.T @ again.velocity_after / metres
        assert back == pytest.approx(first.velocity_after, abs=1e-12)


def test_a_gain_is_told_where_every_answer_gains_energy():
    told = 0
    for seed in range(5000, 5025):
        scene, v, lawful = posed("newton", seed)
        status = ik.solve(scene, scene.robot.neutral(), v).status
        told += status is ik.Status.ENERGY_GAIN
        assert not (status is ik.Status.ENERGY_GAIN and lawful)
    assert told
