"""Impacts of a fit are solved once at each value, with their derivatives by values and states."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.design import solved
from impulsekit.design.parameters import Measurement, parameters_of

from ..robots import one_body


def test_values_are_solved_once_while_they_are_remembered(monkeypatch):
    count, solve = [0], solved.solve_batch

    def counted(*given, **options):
        count[0] += 1
        return solve(*given, **options)

    monkeypatch.setattr(solved, "solve_batch", counted)
    robot = one_body("ball", 2, 1)
    scene = ik.Scene(robot, contacts=[ik.Contact("ball", restitution=0.5, name="floor")])
    seen = [
        Measurement(scene, robot.neutral(), [0, 0, -w, 0, 0, 0], np.zeros(6), covariance=np.eye(18))
        for w in (1.0, 2.0)
    ]
    impacts = solved.SolvedImpacts(seen, parameters_of([scene], ["floor"], (), {}))
    x = np.array([0.3])
    for (after, columns), w in zip(impacts.at(x), (1.0, 2.0), strict=True):
        # v⁺ = −e v⁻, by e and by v⁻.
        assert after[2] == pytest.approx(0.3 * w) and columns[2, 0] == pytest.approx(w)
    assert [by_v[2, 2] for _, by_v in impacts.slopes(x).values()] == pytest.approx([-0.3, -0.3])
    assert count == [1]
    for k in range(solved.REMEMBERED):
        impacts.at(x + 0.1 * k)
    impacts.at(x)
    assert count == [solved.REMEMBERED]
    impacts.at(x + 0.5)
    impacts.at(x)
    assert count == [solved.REMEMBERED + 2]
