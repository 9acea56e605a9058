"""What the shared thresholds decide, on both sides of each."""

import numpy as np
import pytest

from impulsekit.laws.alone import find_acting
from impulsekit.laws.approach import sweep
from impulsekit.laws.at_once import hit_contacts
from impulsekit.laws.least_shares import _range
from impulsekit.laws.plane_modes import plane_modes
from impulsekit.laws.pressing import share as share_normals
from impulsekit.laws.redundant import find_shared
from impulsekit.laws.resting_newton import points_of
from impulsekit.laws.single import gained, hit_contact
from impulsekit.laws.space_modes import _eliminate
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
    # Barely coupled: a contact alone has nothing to divide by.
    W = np.eye(6)
    W[2, 5] = W[5, 2] = 1e-13
    impulse = hit_contacts.py_func(W, free, free, none, halves, none, POISSON)[2]
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


@SIDES
def test_a_load_that_is_none(share, above):
    """Three points of a bar share next to no load, and none of them can have more of one."""
    lever = np.array([-1.0, 0.0, 1.0])
    A, unique = np.eye(4), np.ones(4, bool)
    A[:3, :3] = 1.0 + np.outer(lever, lever)
    p = np.array([share * 1e-12, share * 1e-12, share * 1e-12, 1.0])
    share_normals(A, 4, 1e-12, p, np.zeros(4), unique)
    np.testing.assert_allclose(p, [share * 1e-12] * 3 + [1.0], rtol=1e-2)
    assert unique.tolist() == [not above] * 3 + [True]


@SIDES
def test_a_part_in_a_shift_of_loads(share, above):
    # Scaled by D^½ with D = (1, ½, ½), z has the square 2 p of its first entry.
    part = 0.5 * share * 1e-9
    z = np.sqrt([part, 0.5 * (1.0 - part), 0.5 * (1.0 - part)])
    work = workspace(3)
    work.W[2::3, 2::3] = np.eye(3) - np.outer(z, z)
    work.P[2::3] = 1.0
    assert find_shared.py_func(work, 3, Sizes(1.0, 1.0, 1e-14, True), 1e-10, False)
    assert work.unique.tolist() == [not above, False, False]


@SIDES
def test_impulses_of_systems_that_are_nearly_singular(share, above):
    W, found = np.diag([1.0, 1.0 / (share * 1e8)]), np.empty((2, 2))
    none = np.zeros(1)
    count = plane_modes.py_func(W, np.array([0.0, -1.0]), none, none, 1.0, found)
    assert count == (0 if above else 1)


@SIDES
def test_sweeps_that_have_settled(share, above):
    work = workspace(1)
    work.W[:] = np.eye(3)
    work.b[2], work.P[2] = -1.0, 1.0 - share * 1e-13
    assert sweep.py_func(work, 1, 1.0, 1) == (not above)


@SIDES
def test_a_pivot_too_small_to_divide_by(share, above):
    own = share * 1e-14
    taken = own if above else 1e-14
    right = np.ones((1, 1))
    _eliminate(np.full((1, 1, 1), own), right)
    assert right[0, 0] == 1.0 / taken
    assert points_of(np.diag([1.0, own]), np.zeros(2), 1.0).rate.tolist() == [1.0, taken]


@SIDES
def test_eigenvalues_that_are_rounding(share, above):
    """Of what spans the velocities, by pivots below and by eigenvalues above."""
    weighted = np.diag([1.0, 1.0, share * 1e-13])
    assert _range(weighted).shape == (3, 3 if above else 2)
