"""A scene is plain frozen data, checked when it is made."""

from __future__ import annotations

import dataclasses
import math
import pickle

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors


@pytest.fixture(scope="module")
def robot() -> ik.Robot:
    return ik.Robot.from_example("panda")


def test_entries_are_frozen_tuples_of_floats():
    blow = ik.AppliedImpulse("a", linear=np.array([0, 5, 0]), at=[1, 0, 0])
    assert blow.linear == (0.0, 5.0, 0.0)
    assert blow == ik.AppliedImpulse("a", linear=(0, 5, 0), at=(1, 0, 0))
    with pytest.raises(dataclasses.FrozenInstanceError):
        blow.frame = "b"


def test_an_array_without_an_axis_is_a_number():
    one = np.array(0.3)
    assert ik.JointImpulse("a", one).impulse == (0.3,)
    assert ik.JointCoupling("a", "b", ratio=one, velocity=one).ratio == (0.3,)
    assert ik.FrameAnchor("a", velocity=one).velocity == (0.3,) * 6
    assert ik.JointLock("a", velocity=one).velocity == 0.3


def test_a_scene_travels_by_pickle_and_gives_the_same_answer(robot):
    scene = ik.Scene(
        robot,
        [ik.AppliedImpulse("panda_hand", [0, 0, 1]), ik.JointImpulse("panda_joint2", 0.4)],
    )
    q, v = robot.configuration(panda_joint4=-1.5), robot.velocity(panda_joint1=0.2)
    twin = pickle.loads(pickle.dumps(scene))
    assert twin.impulses == scene.impulses
    np.testing.assert_array_equal(ik.solve(twin, q, v).dv, ik.solve(scene, q, v).dv)


def test_entries_are_called_by_name_or_place(robot):
    scene = ik.Scene(
        robot,
        [ik.JointImpulse("panda_joint1", 1.0), ik.JointImpulse("panda_joint1", 1.0, name="kick")],
    )
    assert scene.entry_names("impulses") == ("impulses[0]", "kick")


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda: ik.AppliedImpulse("a", [1, 2]),
            errors.ShapeError,
            r"linear: expected shape \(3,\), got \(2,\)",
        ),
        (lambda: ik.AppliedImpulse("a", 3.0), errors.ShapeError, "three numbers"),
        (lambda: ik.AppliedImpulse("a", [0, math.nan, 0]), errors.NotFiniteError, r"linear\[1\]"),
        (lambda: ik.AppliedImpulse("a", at=[0, 0, math.inf]), errors.NotFiniteError, r"at\[2\]"),
        (lambda: ik.AppliedImpulse("a", [1e200, 0, 0]), errors.RangeError, "1e[+]100"),
        (lambda: ik.Law(restitution=np.array([])), errors.RangeError, '"newton" or'),
        (lambda: ik.AppliedImpulse("a", axes="body"), errors.RangeError, '"world" or "local"'),
        (lambda: ik.AppliedImpulse(""), errors.InputError, "must be a non-empty name"),
        (lambda: ik.AppliedImpulse("a", ["x", 0, 0]), errors.NotFiniteError, '"x"'),
        (lambda: ik.JointImpulse("a", math.nan), errors.NotFiniteError, r"impulse\[0\]"),
    ],
)
def test_a_wrong_entry_is_one_clear_error(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize(
    ("impulses", "error", "words"),
    [
        ([ik.AppliedImpulse("panda_hnd")], errors.UnknownNameError, r'impulses\[0\].*"panda_hand"'),
        ([ik.JointImpulse("elbow", 1.0)], errors.UnknownNameError, "unknown joint"),
        ([ik.AppliedImpulse("world", [1, 0, 0])], errors.InputError, "the world moves nothing"),
        ([ik.AppliedImpulse("panda_link0")], errors.InputError, "fixed to the world"),
        (
            [ik.JointImpulse("panda_joint1", [1, 2])],
            errors.ShapeError,
            r"expected shape \(1,\), got \(2,\)",
        ),
        (["a blow"], errors.InputError, r"impulses\[0\] must be .*got a str"),
        (3, errors.InputError, "must be a list"),
        (
            [ik.JointImpulse("panda_joint1", 1.0, name="x")] * 2,
            errors.InputError,
            '2 entries have the name "x"',
        ),
    ],
)
def test_a_scene_that_does_not_fit_its_robot_is_refused(robot, impulses, error, words):
    with pytest.raises(error, match=words):
        ik.Scene(robot, impulses)


def test_only_a_robot_is_taken_for_a_robot():
    with pytest.raises(errors.InputError, match="not a Robot"):
        ik.Scene("panda")
