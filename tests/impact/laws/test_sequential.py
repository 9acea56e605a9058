"""Contacts one after the other, to the last digit of their approach."""

import numpy as np
import pytest

from impulsekit.scene.law import Law

from .problems import solved


def test_an_approach_far_slower_than_the_first_is_struck_as_well():
    before = [0, 0, -1.0, 0, 0, -5e-14]
    solution = solved(np.eye(6), before, e=0.5, law=Law(order="sequential"))
    assert solution.velocity_after[2::3] == pytest.approx([0.5, 2.5e-14], rel=1e-12)
