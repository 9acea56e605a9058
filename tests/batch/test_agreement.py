"""Random scenes on the example robots, against ``solve``."""

import numpy as np
import pytest

from benchmarks.agreement.agreement import agreement, all_robots, random_scene
from benchmarks.stress.bodies import random_state
from impulsekit import Robot

pytest.importorskip("numba")

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


# The command, python -m benchmarks.agreement, takes 10 000 rows each.
@pytest.mark.slow
def test_all_robots():
    rng = np.random.default_rng(2)
    above, robots = {}, 0
    for robot in all_robots():
        robots += 1
        for kind, rows in (("blows", 150), ("contact", 100)):
            found = agreement(random_scene(robot, kind, rng), *random_state(robot, rng, rows))
            if found.worst > 1e-12 or found.statuses:
                above[robot.name, kind] = found
    assert robots > 85
    assert not above
