"""Drift of resting points is taken out, also where points come and go on the way."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.motion.course.drift import take_out_drift
from impulsekit.motion.dynamics.accelerations import Dynamics

from ..models import sliders


class _Line:
    """A plank above a floor: seen from afar it touches with both ends, from near with the lower.

    q = height and tilt; its ends are at ±1.
    """

    def ends(self, q):
        low = q[0] - abs(q[1])
        both = 2.0 * abs(q[1]) <= 0.5 * abs(low)
        return [(1.0, 1.0), (1.0, -1.0)] if both else [(1.0, -np.sign(q[1]))]

    def rows(self, resting, q):
        found = []
        for contact in resting:
            ends = self.ends(q)
            contact.count = len(ends)
            for height, side in ends:
                found += [[0.0, 0.0], [0.0, 0.0], [height, side]]
        return np.array(found)

    def of_points(self, resting, q, v):
        low = min(q[0] + side * q[1] for _, side in [(1.0, 1.0), (1.0, -1.0)])
        return np.concatenate([np.full(contact.count, low) for contact in resting])


def moved(q, rows, off):
    # Uneven masses, so that the plank tilts as it is lifted.
    return np.linalg.lstsq(rows @ np.diag([1.0, 0.3]), off, rcond=None)[0] * [1.0, 0.3]


def test_points_that_go_while_drift_is_taken_out_leave_the_others_in_place():
    model = pin.Model()
    for axis in (pin.JointModelPZ(), pin.JointModelRX()):
        model.addJoint(0, axis, pin.SE3.Identity(), f"joint {model.njoints}")
    for tilt in (0.0, 1e-9, -5e-9, 5e-8):
        resting = [SimpleNamespace(count=2), SimpleNamespace(count=2)]
        now = SimpleNamespace(
            q=np.array([1e-7, tilt]), v=np.array([1e-9, 0.0]), t=0.0, model=model, held=None,
            gaps=_Line(), resting=SimpleNamespace(contacts=resting, rolling=None, joints=None),
            dynamics=SimpleNamespace(moved=moved),
        )  # fmt: skip
        take_out_drift(now, [(point, row) for point in range(4) for row in (2,)])
        low = min(now.q[0] + now.q[1], now.q[0] - now.q[1])
        assert abs(low) < 1e-14
        assert abs(now.gaps.rows(resting, now.q)[2::3] @ now.v).max() < 1e-14


@pytest.mark.parametrize("count", [1, 2])
def test_what_rows_ask_for_is_met_at_once_also_where_they_depend_on_each_other(count):
    dynamics = Dynamics(ik.Scene(sliders(count)))
    row = np.eye(count)[0]
    for rows in ([row], [row, row], [row, -row, row]):
        change = np.array(rows).dot(3.0 * row)
        moved = dynamics.moved(np.zeros(count), np.array(rows), change)
        np.testing.assert_allclose(moved, 3.0 * row, atol=1e-12)
