"""Two bodies that meet: planes that move, anchors whose second point follows from the pose."""

import numpy as np
import pytest

import impulsekit as ik
from tests.batch.compare import random_states, worst_difference

pytest.importorskip("numba")


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


@pytest.fixture(scope="module")
def arm_and_box():
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    return ik.combine(arm=ik.Robot.from_example("panda"), box=box)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.3, -0.8, 0.1)])
def test_a_foot_on_a_plane_of_the_same_robot(solo, normal):
    contact = ik.Contact(
        "FR_FOOT", at=[0, 0.01, 0], normal=normal, against="HL_UPPER_LEG", friction=0.5,
        restitution=0.2,
    )  # fmt: skip
    blow = ik.AppliedImpulse("base_link", [0.3, -0.2, -1])
    q, v = random_states(solo, 50)
    worst, _batch = worst_difference(ik.Scene(solo, [blow], contacts=[contact]), q, v)
    assert worst < 1e-12


@pytest.mark.parametrize("order", [("box/box", "arm/panda_hand"), ("arm/panda_hand", "box/box")])
def test_bodies_of_two_robots(arm_and_box, order):
    frame, against = order
    contact = ik.Contact(
        frame, at=[0.02, 0, 0.1], normal=[0.1, 1, 0.2], against=against, friction=0.4,
        restitution=0.5,
    )  # fmt: skip
    q, v = random_states(arm_and_box, 50)
    worst, _batch = worst_difference(ik.Scene(arm_and_box, contacts=[contact]), q, v)
    assert worst < 1e-12


def test_the_ground_touches_the_robot(solo):
    contact = ik.Contact("world", at=[0.1, 0, 0], against="FR_FOOT", normal=[0, 0, -1])
    q, v = random_states(solo, 30)
    worst, _batch = worst_difference(ik.Scene(solo, contacts=[contact]), q, v)
    assert worst < 1e-12


def test_anchors_where_the_bodies_stand(solo, arm_and_box):
    anchors = [
        ik.PointAnchor("FR_FOOT", "HL_FOOT"),
        ik.FrameAnchor(
            "FL_FOOT", "HR_UPPER_LEG", at=[0, 0, 0.02], directions=["x", "rz"], axes="local"
        ),
    ]
    blow = ik.AppliedImpulse("base_link", [0.3, -0.2, -1])
    q, v = random_states(solo, 40)
    worst, _ = worst_difference(ik.Scene(solo, [blow], anchors), q, v)
    assert worst < 1e-11
    grip = ik.FrameAnchor("arm/panda_hand", "box/box", at=[0, 0, 0.1])
    q, v = random_states(arm_and_box, 40)
    worst, _batch = worst_difference(ik.Scene(arm_and_box, constraints=[grip]), q, v)
    assert worst < 1e-12


def test_rows_that_move_nothing_are_left_to_the_single_path():
    linkage = ik.Robot.from_urdf("models/four_bar.urdf")
    blow = ik.AppliedImpulse("coupler", linear=[1, 0, 0], at=[0.25, 0, 0])
    loop = ik.PointAnchor("coupler", "rocker", at=[0.5, 0, 0], other_at=[0, 0.5, 0])
    scene = ik.Scene(linkage, [blow], constraints=[loop])
    q = np.tile(linkage.neutral(), (9, 1))
    worst, _ = worst_difference(scene, q, np.zeros((9, linkage.nv)))
    assert worst < 1e-12
