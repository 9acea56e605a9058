"""Where a point slides from now on, and whether its slip has only begun."""

from __future__ import annotations

import pytest

from impulsekit.motion.compiled_settle import next_slide

# µ, the largest acceleration [m/s²], slip without a direction and slip that has grown [m/s].
NUMBERS = 0.5, 1.0, 1e-7, 1e-5
ON_CONE = -0.5, 0.0, 1.0
ALONG = 1.0, 0.0, 1.0


@pytest.mark.parametrize("slip", [1e-16, 0.0, -1e-16])
def test_slip_that_is_rounding_does_not_decide_whether_it_has_begun(slip):
    # It gets faster along the way in which it began, whatever the sign of its rounding.
    assert next_slide(ALONG, True, (slip, 0.0), (1e-3, 0.0), ON_CONE, NUMBERS, False) == (
        ALONG,
        True,
    )


@pytest.mark.parametrize("slip", [1e-16, 0.0, -1e-16])
def test_a_point_that_is_pushed_back_before_it_has_moved_sticks(slip):
    stuck = next_slide(ALONG, True, (slip, 0.0), (-1e-3, 0.0), ON_CONE, NUMBERS, False)
    assert stuck == ((0.0, 0.0, 0.0), False)


def test_slip_that_has_a_direction_goes_on_in_that():
    way, begins = next_slide(ALONG, True, (0.0, 1e-6), (0.0, 1e-3), ON_CONE, NUMBERS, False)
    assert (way, begins) == ((0.0, 1.0, 1.0), True)
