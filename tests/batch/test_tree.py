"""Axes of bodies: a joint turns its body about z, and most constant turns are nothing."""

import numpy as np
import pinocchio as pin
import pytest

from impulsekit import Robot
from impulsekit.batch.kernels import layout
from impulsekit.batch.tree import Tree, part_turns, tree_of
from impulsekit.bench.stress.judge import BACKWARD, BOUND
from impulsekit.bench.stress.run import solved_case


def about_z(cosine: float, sine: float) -> np.ndarray:
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def about_x(cosine: float, sine: float) -> np.ndarray:
    return np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])


def tables(rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Those of one body on a joint that turns it."""
    ints = np.zeros((2, layout.BODY_INTS), dtype=np.int64)
    floats = np.zeros((2, layout.BODY_FLOATS))
    floats[1, :9] = rotation.ravel()
    part_turns(ints, floats)
    return ints[1], floats[1]


def rotation_of(ints: np.ndarray, floats: np.ndarray) -> np.ndarray:
    """What the kernels make of the tables where the joint itself has not turned."""
    found = about_z(floats[4], floats[5])
    if ints[8] & layout.ABOUT_X:
        found = about_x(floats[2], floats[3]) @ found
    return about_z(floats[0], floats[1]) @ found if ints[8] & layout.ABOUT_Z else found


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-9, 1e-5, 0.3, np.pi / 2, np.pi - 1e-9, np.pi])
def test_three_turns_make_the_rotation_of_a_joint_however_small_its_angles(angle):
    rng = np.random.default_rng(1)
    for _ in range(20):
        axis = rng.normal(size=3)
        rotation = pin.exp3(angle * axis / np.linalg.norm(axis))
        np.testing.assert_allclose(rotation_of(*tables(rotation)), rotation, atol=6e-16)


def test_turns_that_are_nothing_are_marked_so():
    assert tables(np.eye(3))[0][8] == 0
    assert tables(about_x(0.0, 1.0))[0][8] == layout.ABOUT_X
    assert tables(np.diag([1.0, -1.0, -1.0]))[0][8] == layout.ABOUT_X
    assert tables(about_z(1.0, 1e-9) @ about_x(0.0, 1.0))[0][8] == layout.ABOUT_X | layout.ABOUT_Z


def whole_tree(name: str) -> Tree:
    model = Robot.from_example(name).model
    return tree_of(model, range(1, model.njoints))


@pytest.mark.parametrize("name", ["panda", "talos", "icub", "allegro_right_hand"])
def test_the_axes_of_a_body_are_orthogonal_and_its_joint_is_their_z(name):
    for turn in whole_tree(name).turns:
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=5e-16)


def test_in_a_chain_no_body_is_turned_about_z_a_second_time():
    marks = whole_tree("panda").ints.reshape(-1, layout.BODY_INTS)[:, 8]
    assert not (marks & layout.ABOUT_Z).any()


@pytest.mark.parametrize(("size", "points"), [(0.1, False), (1e-3, True)])
def test_a_ball_far_from_its_joint_is_all_but_a_point_if_it_is_small(size, points):
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "joint")
    ball = pin.Inertia.FromSphere(1.0, size)
    model.appendBodyToJoint(joint, ball, pin.SE3(np.eye(3), np.array([0.5, 0.0, 0.0])))
    assert tree_of(model, [1]).has_points is points


@pytest.mark.parametrize(
    "job",
    [
        # Thin links, and arms stretched out: what turns easily beside what does not.
        ("inertia", 2, 70, 0),
        ("singularity", 4, 34, 0),
        ("singularity", 2, 49, 0),
        # A joint 1e-9 from being aligned with the one before.
        ("example-robots", 5, 0, 0),
    ],
)
def test_small_inertias_about_joints_keep_their_digits_beside_large_ones(job):
    answers = [point for point in solved_case(job) if point.method == "batch"]
    assert answers
    for answer in answers:
        assert answer.verdict == "right"
        assert answer.share < 3.0
        assert answer.momentum < 1e-15


def test_bodies_that_are_all_but_points_are_refined():
    for answer in solved_case(("inertia", 4, 84, 2)):
        if answer.method == "batch":
            assert answer.verdict == "right"
            # 11.6 without it; the rounding is not the same in every process.
            assert answer.share < BOUND / 2
            assert answer.momentum < BACKWARD
