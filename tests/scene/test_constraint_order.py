"""A constraint's numbers stay with their directions, and what is no list is told."""

import pytest

from impulsekit import FrameAnchor, JointCoupling
from impulsekit.errors import InputError


def test_velocities_follow_their_directions_when_these_are_put_in_order():
    anchor = FrameAnchor("a", "b", directions=("rz", "x", "y"), velocity=(1.0, 2.0, 3.0))
    assert dict(zip(anchor.directions, anchor.velocity, strict=True)) == {"rz": 1, "x": 2, "y": 3}
    assert anchor.directions == ("x", "y", "rz")


@pytest.mark.parametrize(
    "make",
    [
        lambda: FrameAnchor("a", "b", directions=3),
        lambda: JointCoupling("a", 3),
        lambda: JointCoupling("a", None),
    ],
)
def test_what_is_no_name_is_told(make):
    with pytest.raises(InputError, match="must be a name or several"):
        make()
