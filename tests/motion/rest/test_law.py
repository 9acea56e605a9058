"""Forces of resting points: one answer where many would do, and a smooth one."""

import numpy as np
import pytest

from impulsekit.motion.rest.law import RestNotSolved, by_cones, solve_rest

WEIGHT = 9.81


def plate(places, mass=2.0, inertia=0.03):
    """(3n, 3n) W and (3n, 6) rows of points under a plate that lies still."""
    rows = []
    for x, y in places:
        rows += [[1, 0, 0, 0, -0.1, -y], [0, 1, 0, 0.1, 0, x], [0, 0, 1, y, -x, 0]]
    rows = np.array(rows, dtype=float)
    inverse = np.diag([1 / mass] * 3 + [1 / inertia] * 3)
    return rows @ inverse @ rows.T, rows


def at_rest(rows):
    """(3n,) b under gravity."""
    return rows @ [0, 0, -WEIGHT, 0, 0, 0]


SQUARE = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def test_four_points_alike_bear_a_quarter_each():
    delassus, rows = plate(SQUARE)
    forces = solve_rest(delassus, at_rest(rows), np.full(4, 0.5), np.zeros(12))
    np.testing.assert_allclose(forces.reshape(4, 3), [[0, 0, 2 * WEIGHT / 4]] * 4, atol=1e-9)


def test_loads_do_not_depend_on_where_the_search_begins():
    rng = np.random.default_rng(5)
    places = rng.uniform(-1, 1, (6, 2)) + 0.01
    delassus, rows = plate([*places, (1, 1), (-1, -1), (1, -1), (-1, 1)])
    free = at_rest(rows) + rows @ [0.4, -0.2, 0, 0, 0, 1.0]
    first = solve_rest(delassus, free, np.full(10, 0.6), np.zeros(30))
    for _ in range(5):
        start = rng.uniform(0, 10, 30)
        found = solve_rest(delassus, free, np.full(10, 0.6), start)
        np.testing.assert_allclose(found, first, rtol=0, atol=1e-7)
    # Rigid points all the same: what they are pressed with holds them still.
    assert np.abs(delassus @ first + free).max() < 1e-11


@pytest.mark.parametrize("friction", [0.05, 0.3, 0.8])
def test_points_that_slide_keep_to_coulomb_and_change_their_loads_smoothly(friction):
    delassus, rows = plate([(0.3, 0.2), (0.3, -0.2), (-0.3, 0.2), (-0.3, -0.2)])
    free = at_rest(rows)
    last = None
    for angle in np.linspace(0.0, 2.0 * np.pi, 721):
        ways = np.eye(12)
        for i in range(4):
            spread = angle + 0.7 * i
            ways[3 * i : 3 * i + 2, 3 * i : 3 * i + 2] = 0.0
            ways[3 * i : 3 * i + 2, 3 * i + 2] = -friction * np.array(
                [np.cos(spread), np.sin(spread)]
            )
        start = np.zeros(12) if last is None else last
        forces = solve_rest(delassus, free, np.zeros(4), start, ways)
        loads, rates = forces[2::3], (delassus @ ways @ forces + free)[2::3]
        assert loads.min() >= 0.0
        assert rates.min() > -1e-11
        assert np.abs(loads * rates).max() < 1e-10
        if last is not None:
            # By half a degree of turn: no more than a few times µ of that.
            assert np.abs(loads - last[2::3]).max() < 0.05 * friction * WEIGHT
        last = forces


def test_a_point_that_jams_has_no_force():
    # Painlevé: what friction adds to the normal acceleration is more than the load takes away.
    delassus = np.array([[2.0, 0.0, 0.9], [0.0, 2.0, 0.0], [0.9, 0.0, 1.0]])
    ways = np.zeros((3, 3))
    ways[:, 2] = [-2.0, 0.0, 1.0]
    with pytest.raises(RestNotSolved):
        solve_rest(delassus, np.array([0.0, 0.0, -1.0]), np.zeros(1), np.zeros(3), ways)


def test_points_that_stick_to_a_plate_that_hardly_turns_do_not_contradict_each_other():
    """ω = 5 mrad/s asks points 2 m apart to come nearer at ω² 2 m: a rigid plate cannot."""
    delassus, rows = plate(SQUARE)
    omega = 5e-3
    bias = np.zeros((4, 3))
    bias[:, :2] = -(omega**2) * np.array(SQUARE)
    free = at_rest(rows) + bias.ravel()
    forces = solve_rest(delassus, free, np.full(4, 0.5), np.zeros(12)).reshape(4, 3)
    np.testing.assert_allclose(forces.sum(axis=0), [0, 0, 2 * WEIGHT], atol=1e-9)
    assert (np.hypot(forces[:, 0], forces[:, 1]) <= 0.5 * forces[:, 2] + 1e-9).all()
    # What is left of the accelerations is what the plate cannot do.
    left = delassus @ forces.ravel() + free
    np.testing.assert_allclose(left, bias.ravel(), atol=1e-9)


def test_points_that_contradict_each_other_by_more_than_slow_speeds_do_are_refused_or_slide():
    """At 2 rad/s it is no small part: then no forces hold all four, and none are made up."""
    delassus, rows = plate(SQUARE)
    bias = np.zeros((4, 3))
    bias[:, :2] = -4.0 * np.array(SQUARE)
    free = at_rest(rows) + bias.ravel()
    friction = np.full(4, 0.5)
    try:
        forces = solve_rest(delassus, free, friction, np.zeros(12))
    except RestNotSolved:
        return
    left = (delassus @ forces + free).reshape(4, 3)
    for acceleration, force in zip(left, forces.reshape(4, 3), strict=True):
        if np.hypot(*acceleration[:2]) > 1e-6:
            assert np.hypot(*force[:2]) == pytest.approx(0.5 * force[2], rel=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_joints_with_bounds_and_points_obey_the_law_together(seed):
    # Three points with friction and five bounded rows on six speeds: many share the load.
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(14, 6))
    bounds, friction = rng.choice([0.0, 0.3, 3.0], 5), rng.uniform(0.1, 0.8, 3)
    delassus, free = rows @ rows.T, rows @ rng.normal(0.0, 5.0, 6)
    forces = solve_rest(delassus, free, friction, np.zeros(14), None, bounds)
    rates, size = free + delassus @ forces, np.abs(free).max()
    for rate, torque, bound in zip(rates[9:], forces[9:], bounds, strict=True):
        assert abs(torque) <= bound * (1 + 1e-12)
        if abs(rate) > 1e-8 * size:
            assert torque == pytest.approx(-bound * np.sign(rate))
    for (a, b, c), (x, y, z), mu in zip(
        rates[:9].reshape(3, 3), forces[:9].reshape(3, 3), friction, strict=True
    ):
        assert min(c, z) > -1e-8 * size
        assert c * z < 1e-7 * size * max(z, 1.0)
        assert np.hypot(x, y) <= mu * z * (1 + 1e-9) + 1e-9
        if np.hypot(a, b) > 1e-7 * size:
            np.testing.assert_allclose(
                [x, y], -mu * z * np.array([a, b]) / np.hypot(a, b), atol=1e-6
            )


def test_the_second_search_gives_the_same_accelerations():
    rng = np.random.default_rng(2)
    for _ in range(10):
        delassus, rows = plate(rng.uniform(-1, 1, (5, 2)))
        free = at_rest(rows) + rows @ rng.normal(0.0, 3.0, 6)
        friction = rng.uniform(0.1, 0.8, 5)
        one = solve_rest(delassus, free, friction, np.zeros(15))
        other = by_cones(delassus, delassus, free, friction)
        np.testing.assert_allclose(delassus @ other, delassus @ one, atol=1e-8)


def test_points_that_part_bear_nothing_at_all_wherever_the_search_begins():
    # A load of 1e-24 N let what parts at 7 m/s² count as loaded: it was laid down again.
    rng = np.random.default_rng(3)
    parted = 0
    for _ in range(150):
        n = int(rng.integers(2, 5))
        rows = rng.normal(size=(3 * n, 3 * n + 2))
        friction = rng.choice([0.0, 0.3, 0.8], size=n)
        delassus, free = rows @ rows.T, 3.0 * rng.normal(size=3 * n)
        start = rng.normal(size=3 * n) * rng.integers(0, 2)
        forces = solve_rest(delassus, free, friction, start)
        parts = (delassus @ forces + free)[2::3] > 1e-6
        parted += np.count_nonzero(parts)
        assert not forces.reshape(-1, 3)[parts].any()
    assert parted > 100
