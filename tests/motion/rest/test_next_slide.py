"""Where a point slides from now on, and whether its slip has only begun."""

from __future__ import annotations

import numpy as np
import pytest

from impulsekit.motion.rest.slip import next_slide
from impulsekit.motion.tree.pressed import BEGINS, STICKS, direction_of

# µ, the largest acceleration [m/s²], slip without a direction and slip that has grown [m/s].
NUMBERS = 0.5, 1.0, 1e-7, 1e-5
ON_CONE = -0.5, 0.0, 1.0
ALONG = 1.0, 0.0, BEGINS


@pytest.mark.parametrize("slip", [1e-16, 0.0, -1e-16])
def test_slip_that_is_rounding_does_not_decide_whether_it_has_begun(slip):
    # It gets faster along the way in which it began, whatever the sign of its rounding.
    assert next_slide(ALONG, (slip, 0.0), (1e-3, 0.0), ON_CONE, NUMBERS, False) == ALONG


@pytest.mark.parametrize("slip", [1e-16, 0.0, -1e-16])
def test_a_point_that_is_pushed_back_before_it_has_moved_sticks(slip):
    stuck = next_slide(ALONG, (slip, 0.0), (-1e-3, 0.0), ON_CONE, NUMBERS, False)
    assert stuck == (0.0, 0.0, STICKS)


def test_slip_that_has_a_direction_goes_on_in_that():
    way = next_slide(ALONG, (0.0, 1e-6), (0.0, 1e-3), ON_CONE, NUMBERS, False)
    assert way == (0.0, 1.0, BEGINS)


@pytest.mark.parametrize("across", [0.0, 1e-9, 1.8e-8, 1e-7, 3e-6, 1e-3])
def test_the_direction_of_slip_has_no_jump_and_no_bend_past_its_stop(across):
    """Or steps would end next to it: the way goes on as a polynomial through both sides."""
    slow, way = 1e-7, np.array([0.6, 0.8])
    step = 1e-2 * max(slow, across)
    along = step * np.arange(-4, 5)
    turned = []
    for a in along.tolist():
        s1, s2 = a * way[0] + across * way[1], a * way[1] - across * way[0]
        found = direction_of(s1, s2, way, slow)
        assert np.hypot(*found) == pytest.approx(1.0, abs=1e-15)
        turned.append(np.arctan2(found[0] * way[1] - found[1] * way[0], found @ way))
    # The fourth differences of what is smooth on the scale of ``step`` are small.
    assert np.abs(np.diff(turned, 4)).max() < 1e-4
    # Before the stop it is the direction of slip where that is fast, else the way it had.
    a = 50.0 * slow
    fast = np.array([a * way[0] + across * way[1], a * way[1] - across * way[0]])
    np.testing.assert_allclose(direction_of(*fast, way, slow), fast / np.hypot(*fast), atol=1e-15)


@pytest.mark.parametrize("speed", [1e-8, 1e-6, 1e-3, 1.0])
def test_straight_slip_keeps_its_direction_past_its_stop(speed):
    way = np.array([1.0, 0.0])
    assert direction_of(-speed, 0.0, way, 1e-7) == (1.0, 0.0)
