"""The plan is made once per scene and says why."""

from __future__ import annotations

import pytest

import impulsekit as ik
from impulsekit.impact import ImpactSolver
from impulsekit.models import chain_urdf
from tests.robots import random_blow


@pytest.mark.parametrize(
    ("robot", "frame", "axes", "algorithm"),
    [
        (lambda: ik.Robot.from_example("panda"), "panda_hand", "world", "crba"),
        (lambda: ik.Robot.from_example("panda"), "panda_hand", "local", "aba"),
        (
            lambda: ik.Robot.from_urdf(chain_urdf(40), root="planar"),
            "link_40",
            "world",
            "aba",
        ),
        (lambda: ik.Robot.from_example("panda", mimic=True), "panda_hand", "world", "dense"),
    ],
)
def test_the_algorithm_follows_the_model_and_the_blow(robot, frame, axes, algorithm):
    plan = ImpactSolver(ik.Scene(robot(), [random_blow(frame, 0, axes)])).plan
    assert plan.algorithm == algorithm
    assert plan.why


def test_a_scene_without_impulse_needs_nothing():
    plan = ImpactSolver(ik.Scene(ik.Robot.from_example("panda"))).plan
    assert (plan.algorithm, plan.joints) == ("none", 0)


def test_a_model_whose_joints_all_move_inertia_is_always_regular():
    panda = ik.Scene(ik.Robot.from_example("panda"), [random_blow("panda_hand", 0)])
    assert ImpactSolver(panda).plan.always_regular
