"""Contacts of a scene are checked when they are made."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors


@pytest.fixture(scope="module")
def robot() -> ik.Robot:
    return ik.Robot.from_example("panda")


def test_a_normal_is_kept_at_unit_length():
    assert ik.Contact("a", normal=[0, 3, 4]).normal == (0.0, 0.6, 0.8)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda: ik.Contact("a", restitution=1.2),
            errors.RangeError,
            "restitution must be 0 to 1, got 1.2",
        ),
        (lambda: ik.Contact("a", restitution=-0.1), errors.RangeError, "0 to 1"),
        (lambda: ik.Contact("a", stiffness=np.array([])), errors.NotFiniteError, "a number"),
        (lambda: ik.Contact("a", stiffness=-np.float32(np.inf)), errors.NotFiniteError, "finite"),
        (
            lambda: ik.Contact("a", friction=-1),
            errors.RangeError,
            "friction must be 0 or more, got -1",
        ),
        (lambda: ik.Contact("a", normal=[0, 0, 0]), errors.RangeError, "length of normal"),
        (lambda: ik.Contact("a", normal=[0, math.nan, 1]), errors.NotFiniteError, r"normal\[1\]"),
        (lambda: ik.Contact("a", tangential_restitution=2), errors.RangeError, "-1 to 1"),
        (lambda: ik.Contact("a", against="a"), errors.InputError, "does not touch itself"),
        (lambda: ik.Contact("a", restitution="much"), errors.InputError, "RestitutionTable"),
        (lambda: ik.JointStop("a", lower=2, upper=1), errors.RangeError, "at most upper"),
        (lambda: ik.JointStop("a", restitution=7), errors.RangeError, "0 to 1"),
        (lambda: ik.Collision("a", "a"), errors.InputError, "itself"),
        (lambda: ik.Collision("a", "b", margin=-1), errors.RangeError, "0 to 1 m"),
        (lambda: ik.Restitution(0.5, capture_speed=-1), errors.RangeError, "capture_speed"),
        (lambda: ik.Restitution(1.5), errors.RangeError, "0 to 1"),
        (lambda: ik.RestitutionTable([0, 1], [1]), errors.ShapeError, "values"),
        (lambda: ik.RestitutionTable(None, [1]), errors.InputError, "must be a list of numbers"),
        (lambda: ik.RestitutionTable([1, 0], [1, 1]), errors.RangeError, "each above the last"),
        (lambda: ik.RestitutionTable([0, 1], [1, 2]), errors.RangeError, "0 to 1"),
    ],
)
def test_a_wrong_contact_is_one_clear_error(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize(
    ("contact", "error", "words"),
    [
        (ik.Contact("panda_hnd"), errors.UnknownNameError, r"contacts\[0\].*panda_hand"),
        (ik.Contact("panda_hand", against="table"), errors.UnknownNameError, "table"),
        (ik.Contact("panda_hand", against="panda_link7"), errors.InputError, "one rigid body"),
        (ik.Contact("panda_link0"), errors.InputError, "both belong to the world"),
        (ik.JointStop("elbow"), errors.UnknownNameError, "joint"),
        (ik.Collision("panda_hand", "nothing"), errors.UnknownNameError, "nothing"),
        (ik.Collision("panda_hand", "panda_hand_tcp"), errors.InputError, "no collision geometry"),
        ("a wall", errors.InputError, r"contacts\[0\] must be .*got a str"),
    ],
)
def test_a_contact_that_does_not_fit_its_robot_is_refused(robot, contact, error, words):
    with pytest.raises(error, match=words):
        ik.Scene(robot, contacts=[contact])


def test_a_stop_needs_a_joint_with_one_coordinate():
    model = ik.Robot.from_example("double_pendulum_continuous")
    with pytest.raises(errors.InputError, match="has no limits"):
        ik.Scene(model, contacts=[ik.JointStop(model.joint_names[0])])


def test_only_a_law_is_taken_for_a_law(robot):
    with pytest.raises(errors.InputError, match="not a Law"):
        ik.Scene(robot, law="newton")


def test_a_table_is_linear_between_its_points_and_flat_beyond():
    table = ik.RestitutionTable([0.1, 1.0, 2.0], [1.0, 0.5, 0.2])
    assert table(0.0) == 1.0
    assert table(1.5) == pytest.approx(0.35)
    assert table(9.0) == 0.2


def test_scenes_with_contacts_travel_by_pickle(robot):
    scene = ik.Scene(
        robot,
        contacts=[
            ik.Contact("panda_hand", restitution=ik.Restitution(0.8, 0.1)),
            ik.JointStop("panda_joint1", restitution=ik.RestitutionTable([0, 1], [1, 0])),
            ik.Collision("panda_hand", "panda_link1"),
        ],
        law=ik.Law(restitution="poisson"),
    )
    twin = pickle.loads(pickle.dumps(scene))
    assert twin.contacts == scene.contacts
    assert twin.law == scene.law


@pytest.mark.parametrize(
    "law",
    [
        ik.Law("poisson"),
        ik.Law("newton", "path"),
        ik.Law("stronge", "path"),
        ik.Law("poisson", order="sequential"),
    ],
)
def test_tangential_restitution_goes_with_newton_and_slip_at_the_end(robot, law):
    """Refused when the scene is made, whether or not that contact ever approaches."""
    plain = ik.Contact("panda_hand", friction=0.3)
    skid = ik.Contact("panda_hand", friction=0.3, tangential_restitution=0.5)
    with pytest.raises(errors.InputError, match=r"contacts\[1\]: tangential restitution"):
        ik.Scene(robot, contacts=[plain, skid], law=law)
    assert ik.Scene(robot, contacts=[plain], law=law)
    assert ik.Scene(robot, contacts=[plain, skid], law=ik.Law(order="sequential"))
