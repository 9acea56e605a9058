"""What the shared thresholds decide, on both sides of each."""

import numpy as np
import pytest

from impulsekit.laws.alone import find_acting
from impulsekit.laws.redundant import find_shared
from impulsekit.laws.several import hit_contacts
from impulsekit.laws.single import gained, hit_contact
from impulsekit.laws.status import Status, judged
from impulsekit.laws.words import NEWTON, POISSON
from impulsekit.laws.workspace import Sizes, workspace

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


@SIDES
def test_a_release_that_would_leave_the_normal_doubles(share, above):
    pressed = 2.0 * share * 1e-290
    free, none = np.tile([0.0, 0.0, -pressed], 2), np.zeros(2)
    halves = np.full(2, 0.5)
    impulse = hit_contacts.py_func(np.eye(6), free, free, none, halves, none, POISSON)[2]
    expected = pressed * (1.5 if above else 1.0)
    np.testing.assert_allclose(impulse, [0, 0, expected] * 2, rtol=1e-12, atol=0)


@SIDES
def test_friction_on_its_cone(share, above):
    """Two contacts at one point share what sticks; slip in two directions tells their loads."""
    work, friction = workspace(2), 1.0 - share * 1e-9
    work.W[:] = np.kron(np.ones((2, 2)), np.eye(3))
    work.mu[:], work.P[:] = 1.0, (friction, 0.0, 1.0, 0.0, friction, 1.0)
    shared = find_shared.py_func(work, 2, Sizes(1.0, 1.0, 1e-14, True), 1e-10, True)
    assert shared == above
