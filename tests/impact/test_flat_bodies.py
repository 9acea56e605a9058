"""Flat bodies that collide are carried by all their corners, though some are deeper than others."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ..robots import one_body

BOX = one_body("box", 3, 0.02, '<box size="0.2 0.2 0.2"/>')
SLAB = one_body("slab", 1, 1, '<box size="2 2 0.2"/>', root="fixed")
OVER_PLANE = BOX.with_ground(), "box", "ground", "root_joint"
OVER_SLAB = (
    ik.combine(box=BOX, slab=SLAB, placements={"slab": [0, 0, -0.1]}),
    *("box/box", "slab/slab", "box/root_joint"),
)


def tilted(tilt, sunk):
    """Its lowest corner ``sunk`` below the ground [m]."""
    turn = pin.rpy.rpyToMatrix(tilt, 0.3 * tilt, 0.0)
    height = np.abs(turn[2]).sum() * 0.1 - sunk
    return np.array([0, 0, height, *pin.Quaternion(turn).coeffs()])


@pytest.mark.parametrize("bodies", [OVER_PLANE, OVER_SLAB], ids=["half-space", "slab"])
def test_corners_inside_the_floor_carry_whatever_the_deepest_is(bodies):
    robot, first, other, root = bodies
    scene = ik.Scene(robot, contacts=[ik.Collision(first, other)])
    v = robot.velocity({root: [0, 0, -1, 0, 0, 0]})
    q = tilted(1e-5, 5e-4)
    impact = ik.solve(scene, q, v)
    assert impact.contacts[0].impulse == pytest.approx([0, 0, 3.0], abs=1e-4)
    assert not impact.doubts
    batch = ik.solve_batch(scene, q[None], v[None])
    assert batch.v_after[0] == pytest.approx(impact.v_after, abs=1e-10)


def test_corners_close_by_that_are_left_out_are_told():
    box = OVER_PLANE[0]
    scene = ik.Scene(box, contacts=[ik.Collision("box", "ground", name="sole")])
    v = box.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    with pytest.warns(ik.errors.SetupWarning):
        impact = ik.solve(scene, tilted(1.3e-3, 0.0), v)
    assert impact.doubts == (
        "sole: 2 more points lie within 0.35 mm, outside margin 0.17 mm; margin=0.00035 includes "
        "them",
    )
    assert not ik.solve(scene, tilted(0.1, 0.0), v).doubts
    wider = ik.Scene(box, contacts=[ik.Collision("box", "ground", margin=5e-4)])
    assert not ik.solve(wider, tilted(1.3e-3, 0.0), v).doubts


def test_a_body_that_just_does_not_touch_is_told():
    box = OVER_PLANE[0]
    scene = ik.Scene(box, contacts=[ik.Collision("box", "ground", name="sole", margin=1e-5)])
    v = box.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    with pytest.warns(ik.errors.SetupWarning):
        impact = ik.solve(scene, tilted(0.0, -5e-5), v)
    assert not impact.contacts[0].touching
    assert impact.doubts == (
        "sole: 4 points lie within 0.052 mm, outside margin 0.01 mm; margin=5.2e-05 includes them",
        "nothing strikes: no contact touches; the nearest, sole, is 5e-05 m away",
    )
    assert "points lie" not in " ".join(ik.solve(scene, tilted(0.0, -1e-3), v).doubts)
