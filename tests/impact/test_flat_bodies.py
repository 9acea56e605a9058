"""Flat bodies that collide are carried by all their corners, though some are deeper than others."""

import warnings

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ..robots import one_body

SIDES = ("left", "right")


def landing_talos():
    """Talos over the ground, its soles some tenths of a millimetre inside, and its foot frames."""
    robot = ik.Robot.from_example("talos", root="freeflyer").with_ground()
    q = robot.neutral()
    q[2] += 0.107 - robot.placement(q, "leg_left_6_link").position[2]
    return robot, q, robot.velocity(root_joint=[0, 0, -1, 0, 0, 0])


def soles(robot, q):
    """Four corners of each sole: those of the box around what of the foot is below 1 mm."""
    for side in SIDES:
        link = f"leg_{side}_6_link"
        place = robot.placement(q, link)
        (item,) = (
            item
            for item in robot.collision_model.geometryObjects
            if robot.model.frames[item.parentFrame].name == link
        )
        points = np.array(item.geometry.vertices())
        own = robot.model.frames[item.parentFrame].placement.actInv(item.placement)
        points = points @ own.rotation.T + own.translation
        low = points[points @ place.rotation[2] + place.position[2] < 1e-3]
        (x, y, z), (u, w, _) = low.min(axis=0), low.max(axis=0)
        yield from ((link, corner) for corner in ((x, y, z), (x, w, z), (u, y, z), (u, w, z)))


def test_flat_feet_get_the_impulse_of_their_corners():
    robot, q, v = landing_talos()
    links = [f"leg_{side}_6_link" for side in SIDES]
    feet = [ik.Collision(link, "ground", friction=0.7) for link in links]
    corners = [ik.Contact(link, at=at, friction=0.7) for link, at in soles(robot, q)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        by_bodies = ik.solve(ik.Scene(robot, contacts=feet), q, v)
        by_points = ik.solve(ik.Scene(robot, contacts=corners), q, v)
    wanted = np.array([c.impulse for c in by_points.contacts]).reshape(2, 4, 3).sum(axis=1)
    got = np.array([c.impulse for c in by_bodies.contacts])
    assert got[:, 2] == pytest.approx(wanted[:, 2], rel=0.02)


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
        "sole: 2 more points are close by and left out, beyond the margin of the Collision; "
        "a larger one lets them touch",
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
        "sole: 4 points are close by and left out, beyond the margin of the Collision; "
        "a larger one lets them touch",
        "nothing strikes: no contact touches; the nearest, sole, is 5e-05 m away",
    )
    assert "close by" not in " ".join(ik.solve(scene, tilted(0.0, -1e-3), v).doubts)
