"""What is compiled beforehand is what a scene calls, and no more."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.impact.warm import compile_laws, laws_of
from impulsekit.laws.compiled import ENTRIES

LAWS = [ik.Law(), ik.Law("poisson"), ik.Law("stronge", "path"), ik.Law(order="sequential")]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.slip}-{law.order}")
def test_no_law_runs_interpreted_after_a_warm_up(law, monkeypatch):
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    contact = ik.Contact("FR_FOOT", friction=0.4, restitution=0.3)
    scene = ik.Scene(robot, contacts=[contact], law=law)
    compile_laws(scene)
    for entry in ENTRIES.values():
        monkeypatch.setattr(entry, "_interpret", None)
    rng = np.random.default_rng(1)
    for _ in range(20):
        assert ik.solve(scene, robot.neutral(), rng.normal(size=robot.nv)).status


def test_scenes_in_which_something_turns_need_its_law():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    for rolling in (0.0, 1e-3):
        scene = ik.Scene(ball, contacts=[ik.Contact("ball", rolling=rolling)])
        assert ("product_cones" in laws_of(scene)) == bool(rolling)


def test_a_blow_alone_needs_none():
    robot = ik.Robot.from_example("panda")
    assert laws_of(ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])])) == ()
