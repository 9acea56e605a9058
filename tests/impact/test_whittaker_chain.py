"""Whittaker's struck chain: the exact answer is known for every number of links."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.problems.blows import chain_problem, pendulum_problem
from impulsekit.reference.whittaker import struck_chain, struck_pendulum


def struck(n: int, mass: float = 1.0, length: float = 1.0, impulse: float = 5.0) -> ik.Impact:
    """A free straight chain of n links, struck across at the far end of its last link."""
    problem = chain_problem(n, mass, length, impulse)
    return ik.solve(problem.scene, problem.q, problem.v)


def point_velocities(impact: ik.Impact, n: int, length: float = 1.0) -> np.ndarray:
    """(n + 1,) from the struck end to the far one, across the chain."""
    points = [(f"link_{n}", [length, 0, 0])]
    points += [(f"link_{k}", [0, 0, 0]) for k in range(n, 0, -1)]
    return np.array([impact.velocity_at(frame, at).after[1] for frame, at in points])


LONGEST = pytest.param(240, marks=[pytest.mark.slow, pytest.mark.sweep])


@pytest.mark.parametrize("n", [1, 2, 3, 5, 10, 14, 15, 20, 40, 60, 120, LONGEST])
def test_point_velocities_are_the_exact_fractions_to_1e_14(n):
    exact = np.array([float(u) for u in struck_chain(n, 1, 1, 5).point_velocities])
    error = np.abs(point_velocities(struck(n), n) - exact).max() / np.abs(exact).max()
    assert error < 1e-14


def test_a_hanging_double_rod_struck_at_the_bottom():
    mass, length, impulse = 1.5, 0.8, 2.0
    problem = pendulum_problem(2, mass, length, impulse)
    impact = ik.solve(problem.scene, problem.q, problem.v)
    # Towards +x is a negative turn about y; the closed form counts it as positive.
    rates = np.array([-impact.bodies[f"link_{k}"].domega[1] for k in (1, 2)])
    expected = np.array([-6 / 7, 30 / 7]) * impulse / (mass * length)
    np.testing.assert_allclose(rates, expected, rtol=1e-14)


def test_the_ten_link_pendulum_of_the_paper():
    impulse = 133.447
    robot = ik.Robot.from_urdf("models/pendulum_10.urdf")
    blow = ik.AppliedImpulse("link_10", linear=[impulse, 0, 0], at=[0, 0, -0.3048])
    impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
    exact = struck_pendulum(10, 14.5939, 0.3048, impulse)
    velocities = [impact.velocity_at("link_10", [0, 0, -0.3048]).after[0]]
    velocities += [impact.velocity_at(f"link_{k}").after[0] for k in range(10, 0, -1)]
    scale = float(exact.point_velocities[0])
    error = np.abs(np.array(velocities) - [float(u) for u in exact.point_velocities]).max()
    assert error / scale < 1e-14
