"""Rates of a pair's velocities are those of bodies that move by power series, to 50 digits."""

import mpmath as mp
import numpy as np
import pytest

from impulsekit.rows.frame_pair import (
    motion_at,
    passing,
    relative_rate,
    turning_of_line,
    velocity_at,
)

DIGITS = 50
EXACT = mp.mpf(10) ** -40


@pytest.fixture(autouse=True)
def fifty_digits():
    with mp.workdps(DIGITS):
        yield


def drawn(rng):
    return tuple(mp.mpf(float(x)) for x in rng.normal(size=3))


def skew(a):
    return mp.matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def vector(a):
    return mp.matrix(list(a))


class Body:
    """A body whose origin and turn are power series of the time; all that is known at t = 0."""

    def __init__(self, rng):
        self.origin, self.velocity, self.acceleration, self.spin, self.spin_rate = (
            drawn(rng) for _ in range(5)
        )
        rate = vector(self.acceleration) - skew(self.spin) * vector(self.velocity)
        self.spatial = tuple(rate)

    def place(self, t, arm):
        """Where a point is whose arm at t = 0 was this."""
        turn = skew(self.spin)
        bent = skew(self.spin_rate) + turn * turn
        start = vector(self.origin) + t * vector(self.velocity)
        return (
            start
            + t * t / 2 * vector(self.acceleration)
            + (vector(arm) + t * (turn * vector(arm)) + t * t / 2 * (bent * vector(arm)))
        )

    def field(self, t, x):
        """The velocity of the body at a place."""
        turn = skew(self.spin)
        bent = skew(self.spin_rate) + turn * turn
        whole, rate = mp.eye(3) + t * turn + t * t / 2 * bent, turn + t * bent
        origin = self.place(t, (0, 0, 0))
        moves = vector(self.velocity) + t * vector(self.acceleration)
        return moves + rate * mp.lu_solve(whole, x - origin)

    def motion(self, arm):
        """How the point moves, by the formula."""
        return motion_at(self.velocity, self.spatial, self.spin, self.spin_rate, arm)


def derivative(f, order=1):
    return [mp.diff(lambda t, k=k: f(t)[k], 0, order) for k in range(3)]


def off(found, wanted):
    return max(abs(a - b) for a, b in zip(found, wanted, strict=True))


@pytest.mark.parametrize("seed", range(3))
def test_a_point_of_a_body_moves_as_its_place_does(seed):
    rng = np.random.default_rng(seed)
    body, arm = Body(rng), drawn(rng)
    found = body.motion(arm)
    assert off(found.velocity, derivative(lambda t: body.place(t, arm))) < EXACT
    assert off(found.rate, derivative(lambda t: body.place(t, arm), 2)) < EXACT
    assert off(velocity_at(body.velocity, body.spin, arm), found.velocity) < EXACT


@pytest.mark.parametrize("seed", range(3))
def test_the_rate_at_a_place_that_moves_in_axes_that_turn(seed):
    rng = np.random.default_rng(10 + seed)
    first, other, arm = Body(rng), Body(rng), drawn(rng)
    moves, turning = drawn(rng), drawn(rng)
    place = first.place(0, arm)
    there = tuple(place - vector(other.origin))

    def u(t):
        x = place + t * vector(moves)
        w = first.field(t, x) - other.field(t, x)
        return mp.lu_solve(mp.eye(3) + t * skew(turning), w)

    found = relative_rate(
        passing(first.motion(arm), moves), passing(other.motion(there), moves), turning
    )
    assert off(found, derivative(u)) < EXACT


@pytest.mark.parametrize("seed", range(3))
def test_a_line_between_two_points_turns_with_them(seed):
    rng = np.random.default_rng(20 + seed)
    first, other, here, there = Body(rng), Body(rng), drawn(rng), drawn(rng)

    def direction(t):
        between = first.place(t, here) - other.place(t, there)
        return between / mp.norm(between)

    length = mp.norm(first.place(0, here) - other.place(0, there))
    n = tuple(direction(mp.mpf(0)))
    one, two = first.motion(here), other.motion(there)
    w = tuple(vector(one.velocity) - vector(two.velocity))
    turning = turning_of_line(n, length, w)
    assert off(skew(turning) * vector(n), derivative(direction)) < EXACT
    assert abs((vector(turning).T * vector(n))[0]) < EXACT
    # So the rate of the distance is n·ẇ less what the line's own turning takes.
    rate = relative_rate(one, two, turning)

    def distance(t):
        return mp.norm(first.place(t, here) - other.place(t, there))

    assert abs((vector(rate).T * vector(n))[0] - mp.diff(distance, 0, 2)) < EXACT
