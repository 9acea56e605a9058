"""Very many contacts at once: what is refused, what ends it."""

from __future__ import annotations

import signal

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.stress.bodies import Link, robot_of
from impulsekit.impact.contact_law import ContactProblem, solve_contacts


def on_a_ball(count):
    ball = robot_of([Link(-1, 1.0, (0.1, 0.1, 0.1))], "freeflyer")
    contacts = [ik.Contact("link_0", at=[1e-6 * i, 0, 0]) for i in range(count)]
    return ik.Scene(ball, contacts=contacts), ball.neutral(), [0, 0, -1, 0, 0, 0]


def coupled(count):
    """Contacts on random rows of one body, each with a mobility of its own beside."""
    rng = np.random.default_rng(0)
    J = rng.normal(size=(3 * count, 6))
    u = J @ rng.normal(size=6)
    u[2::3] = -np.abs(u[2::3])
    one = np.ones(count)
    return ContactProblem(J @ J.T + np.eye(len(u)), u, u, 0.2 * one, 0.5 * one, 0.0 * one)


@pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
@pytest.mark.parametrize("count", [7000, 30000])
def test_more_rows_than_a_matrix_has_are_refused_before_it_is_made(count):
    scene, q, v = on_a_ball(count)
    with pytest.raises(ik.errors.InputError, match=rf"{3 * count} rows act at once.* 20000"):
        ik.solve(scene, q, v)
    assert ik.solve_batch(scene, np.array([q]), np.array([v])).status[0] == ik.Status.REFUSED


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="the system has no interval timer")
def test_signals_are_heeded_while_the_core_computes():
    class Ended(Exception):
        pass

    ticks = []

    def tick(*_):
        ticks.append(1)
        if len(ticks) == 5:
            raise Ended

    problem = coupled(500)
    former = signal.signal(signal.SIGALRM, tick)
    signal.setitimer(signal.ITIMER_REAL, 0.01, 0.01)
    try:
        # Signals that wait until the core returns are one.
        with pytest.raises(Ended):
            solve_contacts(problem, ik.Law())
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, former)
    assert solve_contacts(coupled(2), ik.Law()).status is ik.Status.SOLVED
