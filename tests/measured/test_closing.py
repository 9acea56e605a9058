"""Rows of contacts and constraints where an impact was measured."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.measured.closing import ClosingContacts
from tests.measured.bodies import ball_scene


def test_rows_of_a_rod_are_the_rate_of_its_length():
    scene = ball_scene()
    rod = ik.DistanceAnchor("ball", at=[0.01, 0.02, 0.03], other_at=[0.2, -0.1, 0.6], name="rod")
    closing = ClosingContacts(replace(scene, constraints=[rod]))
    model, rng = scene.robot.model, np.random.default_rng(0)
    for _ in range(200):  # memory that is not there shows itself after a while
        q = pin.integrate(model, scene.robot.neutral(), rng.normal(size=6))
        rows = closing.mass_and_rows(q)[1]
    v = rng.normal(size=6)

    def length(share):
        place = pin.XYZQUATToSE3(pin.integrate(model, q, share * v))
        return np.linalg.norm(place.act(np.array(rod.at)) - rod.other_at)

    assert rows.shape == (4, 6)
    assert rows[-1] @ v == pytest.approx((length(1e-6) - length(-1e-6)) / 2e-6, abs=1e-8)
