"""Nasty problems end, and what is SOLVED obeys the law."""

from .fuzz_laws import BAR, fuzz, lack_of_newton, problem_of


def test_what_is_solved_obeys_the_law():
    found, worst = fuzz(600)
    assert worst <= BAR
    assert found["SOLVED"] > 480


def test_an_impulse_that_is_off_is_seen():
    import numpy as np

    from impulsekit.impact.contact_law import solve_contacts
    from impulsekit.scene.law import Law

    problem = problem_of(np.random.default_rng(1))
    impulse = np.array(solve_contacts(problem, Law()).impulse)
    impulse[2] += 1e-3 + impulse[2]
    assert lack_of_newton(problem, impulse) > BAR
