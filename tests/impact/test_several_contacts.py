"""Several plain contacts in one compiled call are what the general way finds."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.bench.problems.feet import CORNERS, FEET, SOLES
from impulsekit.impact.known import KnownImpulses
from impulsekit.impact.planning import reached_by
from impulsekit.impact.several_contacts import SeveralContactsJump, shortest_way
from impulsekit.laws.struck import strike_at_once
from impulsekit.laws.struck_in_turn import strike_in_turn

LAWS = [
    ik.Law(),
    ik.Law("poisson"),
    ik.Law(order="sequential"),
    ik.Law("stronge", slip="path", order="sequential"),
]
WALL = {"normal": (0.0, 0.6, 0.8), "against": "world"}


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    strike_at_once.compile()
    strike_in_turn.compile()


def way_of(scene):
    reached = reached_by(scene)
    return shortest_way(scene, KnownImpulses(scene, reached), reached, always_regular=True)


def scene_of(name, law):
    if name == "talos":
        robot = ik.Robot.from_example("talos", root="freeflyer")
        points = [(sole, at) for sole in SOLES for at in CORNERS]
    else:
        robot = ik.Robot.from_example("solo12", root="freeflyer")
        points = [(foot, (0.0, 0.0, 0.0)) for foot in FEET]
    contacts = [
        ik.Contact(frame, at=at, restitution=0.1 * i, friction=0.2 * i, **(WALL if i == 1 else {}))
        for i, (frame, at) in enumerate(points[:4])
    ]
    return ik.Scene(robot, contacts=contacts, law=law)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.order}")
@pytest.mark.parametrize("name", ["solo12", "talos"])
def test_one_call_is_the_general_way(name, law):
    scene = scene_of(name, law)
    way = way_of(scene)
    assert isinstance(way, SeveralContactsJump)
    rng = np.random.default_rng(7)
    quick = 0
    for _ in range(12):
        q, v = scene.robot.neutral(), rng.normal(size=scene.robot.nv)
        q[7:] += 0.2 * rng.normal(size=len(q) - 7)
        dv, outcome = way.solve(q, v)
        quick += callable(outcome)
        ours = outcome() if callable(outcome) else outcome
        dv_there, theirs = way._general.solve(q, v)
        here, there = ours.contacts, theirs.contacts
        assert here.status is there.status
        size = max(np.abs(v).max(), np.abs(dv_there).max())
        assert np.abs(dv - dv_there).max() <= 1e-12 * size
        for field in ("velocity_after", "velocity_start"):
            apart = np.abs(getattr(here, field) - getattr(there, field)).max()
            assert apart <= 1e-12 * size, field
        for field in ("impulse", "normal_work", "friction_work"):
            of_general = getattr(there, field)
            apart = np.abs(getattr(here, field) - of_general).max()
            assert apart <= 1e-11 * np.abs(of_general).max(), field
        assert here.residual <= (2e-15 if callable(outcome) else 1e-10)
        assert (here.iterations, here.tied) == (there.iterations, there.tied)
        np.testing.assert_array_equal(here.unique, there.unique)
        for a, b in zip(ours.touches, theirs.touches, strict=True):
            assert (a.entry, a.joint_ids, a.frame_ids) == (b.entry, b.joint_ids, b.frame_ids)
            np.testing.assert_array_equal(a.jacobian, b.jacobian)
            np.testing.assert_array_equal(a.axes, b.axes)
    assert quick >= 4


def test_it_takes_plain_contacts_alone():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    feet = [ik.Contact(foot, friction=0.5) for foot in FEET]
    blow = ik.AppliedImpulse("base_link", linear=[0, 0, 1])
    for scene in (
        ik.Scene(robot, [blow], contacts=feet),
        ik.Scene(robot, contacts=feet, constraints=[ik.JointLock("FL_KFE")]),
        ik.Scene(robot, contacts=[*feet, ik.Contact("base_link", friction=0.5, adhesion=0.1)]),
        ik.Scene(robot, contacts=[*feet, ik.Contact("base_link", friction=0.5, rolling=0.1)]),
        ik.Scene(robot, contacts=[*feet[:2], ik.Contact(FEET[2], against=FEET[3])]),
        ik.Scene(robot, contacts=[*feet[:3], ik.Contact(FEET[3], restitution=lambda u: 0.5)]),
    ):
        assert not isinstance(way_of(scene), SeveralContactsJump)
