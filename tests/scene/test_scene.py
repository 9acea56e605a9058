"""A scene is plain frozen data, checked when it is made."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors, scene
from impulsekit.scene.entry import Checked, _checks_of


@pytest.fixture(scope="module")
def robot() -> ik.Robot:
    return ik.Robot.from_example("panda")


def test_entries_are_frozen_tuples_of_floats():
    blow = ik.AppliedImpulse("a", linear=np.array([0, 5, 0]), at=[1, 0, 0])
    assert blow.linear == (0.0, 5.0, 0.0)
    assert blow == ik.AppliedImpulse("a", linear=(0, 5, 0), at=(1, 0, 0))
    with pytest.raises(dataclasses.FrozenInstanceError):
        blow.frame = "b"


def test_defaults_are_what_their_checks_give():
    kinds = [kind for kind in vars(ik).values() if isinstance(kind, type)]
    kinds += [getattr(scene, name) for name in scene.__all__]
    seen = 0
    for kind in {kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Checked)}:
        for name, check, default in _checks_of(kind)[1]:
            if default not in (dataclasses.MISSING, None):
                kept = check(default, name)
                assert kept == default and type(kept) is type(default), (kind, name)
                seen += 1
    assert seen > 30


def test_an_array_without_an_axis_is_a_number():
    one = np.array(0.3)
    assert ik.JointImpulse("a", one).impulse == (0.3,)
    assert ik.JointCoupling("a", "b", ratio=one, velocity=one).ratio == (0.3,)
    assert ik.FrameAnchor("a", velocity=one).velocity == (0.3,) * 6
    assert ik.JointLock("a", velocity=one).velocity == 0.3


def test_entries_are_called_by_name_or_place(robot):
    scene = ik.Scene(
        robot,
        [ik.JointImpulse("panda_joint1", 1.0), ik.JointImpulse("panda_joint1", 1.0, name="kick")],
    )
    assert scene.entry_names("impulses") == ("impulses[0]", "kick")


def test_a_normal_is_kept_at_unit_length():
    assert ik.Contact("a", normal=[0, 3, 4]).normal == (0.0, 0.6, 0.8)


def test_a_table_is_linear_between_its_points_and_flat_beyond():
    table = ik.RestitutionTable([0.1, 1.0, 2.0], [1.0, 0.5, 0.2])
    assert table(0.0) == 1.0
    assert table(1.5) == pytest.approx(0.35)
    assert table(9.0) == 0.2


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


def test_velocities_follow_their_directions_when_these_are_put_in_order():
    anchor = ik.FrameAnchor("a", "b", directions=("rz", "x", "y"), velocity=(1.0, 2.0, 3.0))
    assert dict(zip(anchor.directions, anchor.velocity, strict=True)) == {"rz": 1, "x": 2, "y": 3}
    assert anchor.directions == ("x", "y", "rz")
