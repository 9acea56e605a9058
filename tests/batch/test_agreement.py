"""Random scenes on the example robots, against ``solve``."""

import numpy as np
import pytest

from benchmarks.agreement import agreement, random_scene
from benchmarks.stress.bodies import random_state
from impulsekit import Robot

FEW = {"panda": "fixed", "solo12": "freeflyer", "talos": "freeflyer", "allegro_right_hand": "fixed"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["blows", "contact"])
@pytest.mark.parametrize("name", FEW)
def test_some_robots(name, kind):
    robot = Robot.from_example(name, root=FEW[name])
    rng = np.random.default_rng(1)
    found = agreement(random_scene(robot, kind, rng), *random_state(robot, rng, 60))
    assert found.worst < 1e-12
    assert found.harder == found.statuses == 0
