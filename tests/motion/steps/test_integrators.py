"""Integrators come nearer the truth as they are asked to: exact motions, closed forms."""

import numpy as np
import pytest

from benchmarks.methods.registry import methods
from benchmarks.problems.registry import problems
from impulsekit import Robot, Scene, simulate

MOTIONS = list(problems(quick=True, families=["swing", "flight"]))


@pytest.mark.parametrize("problem", MOTIONS, ids=lambda problem: problem.name)
def test_dop853_comes_nearer_the_truth_with_its_tolerance(problem):
    ways = methods(["impulsekit, simulate dop853"])
    errors = [problem.error(np.asarray(way.prepare(problem)())) for way in ways[::-1]]
    assert ways[0].setting > ways[-1].setting
    assert errors[0] < 1e-11
    assert errors[0] < errors[-1]


def test_free_flight_of_a_robot_keeps_energy_and_momentum():
    talos = Robot.from_example("talos", root="freeflyer")
    v = np.random.default_rng(0).normal(size=talos.nv)
    motion = simulate(
        Scene(talos), talos.neutral(), v, duration=1.0, samples=21, rtol=1e-12, atol=1e-14
    )
    energy, momentum = motion.energy(), motion.momentum()
    assert np.ptp(energy.total) < 1e-11 * energy.kinetic[0]
    weight = talos.mass * np.array([0.0, 0.0, -9.81])
    linear = momentum.linear - np.outer(motion.t, weight)
    assert np.abs(linear - linear[0]).max() < 1e-11 * talos.mass * 9.81
