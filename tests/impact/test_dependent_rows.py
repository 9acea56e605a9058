"""Bilateral rows that repeat, contradict or all but repeat each other, in every writing."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from tests.laws.rows import slides

from ..robots import random_blow, random_state, relative
from .test_constraints import solved as held_impact

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")


def solved(rows, v, wanted=0.0, contacts=()):
    """The impact of unit masses on slides whose rows (m, nv) get velocities (m,)."""
    rows = np.array(rows, dtype=float)
    wanted = np.broadcast_to(wanted, len(rows))
    held = [
        ik.GapConstraint(
            lambda q, row=row: row @ q, lambda q, row=row: [row], velocity=float(u), name=f"row {i}"
        )
        for i, (row, u) in enumerate(zip(rows, wanted, strict=True))
    ]
    scene = ik.Scene(slides(rows.shape[1]), constraints=held, contacts=contacts)
    return ik.solve(scene, np.zeros(rows.shape[1]), v)


def impulses(impact):
    return np.array([constraint.impulse[0] for constraint in impact.constraints])


def random_rows(seed, m=3, nv=6):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(m, nv)), rng.normal(size=nv), rng


@pytest.mark.parametrize("still", [[1], [0, 3], [3]])
def test_rows_of_zeros_bear_nothing_and_leave_the_others_as_they_are(still):
    rows, v, _ = random_rows(0)
    wide = np.zeros((3 + len(still), 6))
    moving = np.setdiff1d(np.arange(len(wide)), still)
    wide[moving] = rows
    found, alone = solved(wide, v), solved(rows, v)
    np.testing.assert_array_equal(impulses(found)[still], 0.0)
    np.testing.assert_allclose(impulses(found)[moving], impulses(alone), rtol=1e-12)
    assert [one.unique for one in found.constraints] == [i in moving for i in range(len(wide))]


@pytest.mark.parametrize("factors", [(1, 1, 1, 1), (1e6, 1, 1, 1), (1, 1e-6, 1e6, 1)])
def test_repeated_rows_share_what_one_bears_whatever_their_scale(factors):
    rows, v, _ = random_rows(1)
    alone = impulses(solved(rows, v))
    found = solved(np.array(factors)[:, None] * np.vstack([rows, rows[1]]), v)
    shares = impulses(found) * factors
    np.testing.assert_allclose(shares, [alone[0], alone[1] / 2, alone[2], alone[1] / 2], rtol=1e-9)
    assert [one.unique for one in found.constraints] == [True, False, True, False]


def test_rows_that_contradict_each_other_are_named():
    rows, v, _ = random_rows(2)
    twice = np.vstack([rows, rows[0] + rows[2]])
    assert solved(twice, v, [1.0, 0.0, 2.0, 3.0]).is_valid()
    with pytest.raises(ik.errors.ContradictionError, match="row 3"):
        solved(twice, v, [1.0, 0.0, 2.0, 2.0])
    with pytest.raises(ik.errors.ContradictionError, match="row 1"):
        solved([rows[0], np.zeros(6)], v, [0.0, 1.0])


def test_rows_all_but_dependent_are_told_and_not_imposed():
    """Within 1e-7 the difference is an inaccuracy of the model: valid, with a word of its own."""
    rows, v, rng = random_rows(3)
    exact, near, apart = (
        solved(np.vstack([rows, rows[0] + off * rng.normal(size=6)]), v) for off in (0, 1e-9, 1e-4)
    )
    assert near.is_valid() and near.status is not exact.status
    np.testing.assert_allclose(near.v_after, exact.v_after, atol=1e-6)
    assert np.abs(apart.v_after - exact.v_after).max() > 1e-3


# -- one grip of a ball by an arm, in many words


GRIP = ("near/ball/ball", "near/arm/panda_hand")
NEAR = ik.combine(
    arm=ik.Robot.from_example("panda"),
    ball=ik.Robot.from_urdf("models/ball.urdf", root="freeflyer"),
    placements={"arm": [0.2, -0.1, 0.4]},
)
WORLD = ik.combine(near=NEAR, dog=ik.Robot.from_example("solo12", root="freeflyer"))
BLOWS = [random_blow("near/arm/panda_hand", 1), random_blow("dog/FR_FOOT", 2)]


def grasped(constraints):
    """v⁺, and what the joint of the hand carries, which knows of resultants alone."""
    impact = ik.solve(ik.Scene(WORLD, BLOWS, constraints), *random_state(WORLD, 7))
    assert impact.is_valid()
    return impact.v_after, impact.reactions["near/arm/panda_joint7"]


def other_ways():
    hand, held = GRIP[1], GRIP[0]
    whole = ik.FrameAnchor(held, hand, name="a")
    rows = [ik.FrameAnchor(held, hand, directions=(d,), name=d)
            for d in ("x", "y", "z", "rx", "ry", "rz")]  # fmt: skip
    away = {"at": (0.3, -0.2, 0.1)}
    return {
        "in local axes": [ik.FrameAnchor(held, hand, axes="local")],
        "from the other side": [ik.FrameAnchor(hand, held, at=(1, 0, 0))],
        "from the other side, in its axes": [ik.FrameAnchor(hand, held, axes="local")],
        "about another point": [ik.FrameAnchor(held, hand, **away)],
        "row by row, backwards": rows[::-1],
        "twice": [whole, ik.FrameAnchor(held, hand, name="b")],
        "twice, in two frames": [whole, ik.FrameAnchor(hand, held, axes="local", **away, name="b")],
        "by points": [ik.PointAnchor(held, hand, at=at)
                      for at in ((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3))],
        "once too often": [whole, rows[1], rows[5]],
    }  # fmt: skip


@pytest.mark.parametrize("way", other_ways())
def test_a_demand_may_be_written_in_many_ways(way):
    rope = ik.PointAnchor("dog/FL_FOOT", GRIP[1], at=(0.01, 0, 0), other_at=(0.1, 0, 0.1), name="r")
    plain = [ik.FrameAnchor(*GRIP, name="a"), rope]
    for changed, original in (
        (other_ways()[way], plain[:1]),
        ([rope, *other_ways()[way]], plain),
    ):
        (v, wrench), (v_plain, wrench_plain) = grasped(changed), grasped(original)
        assert relative(v - v_plain, v_plain) < 1e-10
        assert relative(wrench - wrench_plain, wrench_plain) < 1e-10


# -- demands on real robots that cannot be, and some that can


def test_demands_that_contradict_each_other_are_named():
    panda = ik.Robot.from_example("panda")
    q, v = random_state(panda, 1)
    still = ik.PointAnchor("panda_hand", name="still")
    going = ik.PointAnchor("panda_hand", velocity=(1, 0, 0), name="going")
    with pytest.raises(ik.errors.ContradictionError, match=r"still\.x.*going\.x") as caught:
        ik.solve(ik.Scene(panda, [], [still, going, ik.JointLock("panda_joint7")]), q, v)
    assert set(caught.value.rows) == {"still.x", "going.x"}
    # Out of its plane a chain cannot go.
    chain = ik.Robot.from_urdf(ik.models.chain_urdf(3), root="planar")
    out = ik.FrameAnchor("link_3", directions=("x", "z"), velocity=(0, 1), name="out")
    with pytest.raises(ik.errors.ContradictionError, match=r"out\.z") as caught:
        ik.solve(ik.Scene(chain, [], [out]), chain.neutral(), chain.velocity())
    assert caught.value.rows == ("out.z",)


def test_repeated_demands_that_agree_are_no_contradiction():
    panda = ik.Robot.from_example("panda")
    q, v = random_state(panda, 1)
    scene = [ik.PointAnchor("panda_hand", velocity=(1, 2, 3)) for _ in range(3)]
    assert held_impact(panda, scene, v, q).constraints[0].velocity_after == pytest.approx([1, 2, 3])
    kept = [ik.PointAnchor("panda_hand", velocity="kept") for _ in range(2)]
    assert relative(held_impact(panda, kept, v, q).dv, v) < 1e-12
