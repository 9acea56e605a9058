"""What the shared thresholds decide, on both sides of each."""

import numpy as np
import pytest

from impulsekit.laws.alone import find_acting
from impulsekit.laws.single import gained, hit_contact
from impulsekit.laws.status import Status, judged
from impulsekit.laws.words import NEWTON

BALL = (1.0, 0.0, 1.0, 0.0, 0.0, 1.0)
SIDES = pytest.mark.parametrize(("share", "above"), [(0.9, False), (1.1, True)])


@SIDES
def test_an_approach_of_one_contact(share, above):
    impulse = hit_contact.py_func(
        BALL, (0, 0, -1.0), (0, 0, -share * 1e-15), 0.0, 0.0, 0.0, NEWTON
    )[0]
    assert (impulse[2] > 0.0) == above


@SIDES
def test_friction_that_would_underflow(share, above):
    before = (1.0, 0.0, -1.0)
    impulse = hit_contact.py_func(BALL, before, before, 0.0, share * 1e-150, 0.0, NEWTON)[0]
    assert (impulse[0] < 0.0) == above


@SIDES
def test_an_approach_beside_others(share, above):
    free = np.array([0.0, 0.0, -1.0, 0.0, 0.0, -share * 1e-12])
    count, last, size = find_acting(free, free, np.zeros(2), 2, NEWTON, 1.0)
    assert (count, last, size) == (1 + above, int(above), 1.0)


@SIDES
def test_a_gain_of_energy(share, above):
    u, still = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
    assert gained(int(Status.SOLVED), share * 1e-10, 0.0, u, still, u) == above


@SIDES
def test_a_residual_that_is_no_rounding(share, above):
    assert (judged(Status.SOLVED, share * 1e-9) is not Status.SOLVED) == above
