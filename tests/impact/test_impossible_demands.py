"""Demands that cannot be: contradictions, and constraints that fit no robot."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import (
    ContradictionError,
    InputError,
    NotFiniteError,
    RangeError,
    ShapeError,
    UnknownNameError,
)

from ..close import close
from ..robots import random_state, relative
from .test_constraints import discs, solved


def test_demands_that_contradict_each_other_are_named():
    panda = ik.Robot.from_example("panda")
    q, v = random_state(panda, 1)
    still = ik.PointAnchor("panda_hand", name="still")
    going = ik.PointAnchor("panda_hand", velocity=(1, 0, 0), name="going")
    with pytest.raises(ContradictionError, match=r"still\.x.*going\.x") as caught:
        ik.solve(ik.Scene(panda, [], [still, going, ik.JointLock("panda_joint7")]), q, v)
    assert set(caught.value.rows) == {"still.x", "going.x"}
    # Out of its plane a chain cannot go.
    chain = ik.Robot.from_urdf(ik.models.chain_urdf(3), root="planar")
    out = ik.FrameAnchor("link_3", directions=("x", "z"), velocity=(0, 1), name="out")
    with pytest.raises(ContradictionError, match=r"out\.z") as caught:
        ik.solve(ik.Scene(chain, [], [out]), chain.neutral(), chain.velocity())
    assert caught.value.rows == ("out.z",)
    # Rates that a gear rules out.
    gears = discs(1, 1)
    rates = [ik.JointLock("axle_0", 1.0), ik.JointLock("axle_1", 1.0),
             ik.JointCoupling("axle_0", "axle_1", -1)]  # fmt: skip
    with pytest.raises(ContradictionError, match="cannot hold together"):
        ik.solve(ik.Scene(gears, [], rates), gears.neutral(), [0, 0])
    agreeing = [*rates[:1], ik.JointLock("axle_1", -1.0), rates[2]]
    close(solved(gears, agreeing, [0, 0]).v_after, [1, -1], 1e-14)


def test_repeated_demands_that_agree_are_no_contradiction():
    panda = ik.Robot.from_example("panda")
    q, v = random_state(panda, 1)
    scene = [ik.PointAnchor("panda_hand", velocity=(1, 2, 3)) for _ in range(3)]
    assert solved(panda, scene, v, q).constraints[0].velocity_after == pytest.approx([1, 2, 3])
    kept = [ik.PointAnchor("panda_hand", velocity="kept") for _ in range(2)]
    assert relative(solved(panda, kept, v, q).dv, v) < 1e-12


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: ik.PointAnchor("hand", "hand"), InputError, "anchored to itself"),
        (lambda: ik.FrameAnchor("world"), InputError, "anchored to itself"),
        (lambda: ik.PointAnchor("hand", at=(1, 2)), ShapeError, "at"),
        (lambda: ik.PointAnchor("hand", at=(1, 2, np.nan)), NotFiniteError, r"at\[2\]"),
        (lambda: ik.PointAnchor("hand", velocity=(1, 2)), ShapeError, "velocity"),
        (lambda: ik.PointAnchor("hand", velocity=np.inf), NotFiniteError, "velocity"),
        (lambda: ik.PointAnchor("hand", velocity="keep"), RangeError, "kept"),
        (lambda: ik.FrameAnchor("hand", directions=("x", "w")), RangeError, "directions"),
        (lambda: ik.FrameAnchor("hand", directions=()), RangeError, "directions"),
        (lambda: ik.FrameAnchor("hand", axes="body"), RangeError, "axes"),
        (
            lambda: ik.FrameAnchor("hand", directions=("x", "rz"), velocity=(1, 2, 3)),
            ShapeError,
            "2",
        ),
        (lambda: ik.JointLock("elbow", velocity=np.nan), NotFiniteError, "velocity"),
        (lambda: ik.JointLock(""), InputError, "name"),
        (lambda: ik.JointCoupling("a", "a"), InputError, "other joints"),
        (lambda: ik.JointCoupling("a", ["b", "c"], ratio=[1]), ShapeError, "ratio"),
        (lambda: ik.JointCoupling("a", "b", ratio=np.nan), NotFiniteError, "ratio"),
    ],
)
def test_constraints_that_make_no_sense(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize(
    ("constraint", "error", "words"),
    [
        (ik.PointAnchor("panda_hnd"), UnknownNameError, "panda_hand"),
        (ik.PointAnchor("panda_hand", "wrld"), UnknownNameError, "wrld"),
        (ik.FrameAnchor("panda_hand", "panda_link8"), InputError, "one rigid body"),
        (ik.PointAnchor("panda_link0"), InputError, "the world"),
        (ik.JointLock("panda_joint8"), InputError, "fixed"),
        (ik.JointLock("panda_joint9"), UnknownNameError, "panda_joint"),
        (ik.JointLock("panda_joint1", velocity=(1, 2)), ShapeError, "panda_joint1"),
        (ik.JointCoupling("panda_joint1", "panda_hand_joint"), InputError, "fixed"),
        ("panda_hand", InputError, "PointAnchor, FrameAnchor, .* or GapConstraint"),
    ],
)
def test_constraints_that_do_not_fit_the_robot(constraint, error, words):
    panda = ik.Robot.from_example("panda")
    with pytest.raises(error, match=words) as caught:
        ik.Scene(panda, [], [constraint])
    assert "constraints[0]" in str(caught.value)


def test_a_coupling_takes_joints_with_one_degree_of_freedom():
    talos = ik.Robot.from_example("talos", root="freeflyer")
    with pytest.raises(InputError, match="6 degrees of freedom"):
        ik.Scene(talos, [], [ik.JointCoupling("torso_1_joint", "root_joint")])
