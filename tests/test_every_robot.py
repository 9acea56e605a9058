"""Every example robot, under both roots: solved, checked, told and combined; and shown."""

from __future__ import annotations

import json

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import SingularMassError
from impulsekit.robot.examples import example_path, example_urdf

from .robots import random_state

ROOTS = ("fixed", "freeflyer")
# One of each kind: a root link called "world", links and joints of one name, moments of inertia
# that round below zero, mimic joints, a drone without any joint, the most links.
SOME = ("ur5", "z1", "so100", "anymal_c", "icub_reduced", "kinova", "hector", "baxter")
# Fingers and grippers without an <inertial>, the only ones: an impact has no answer there.
MASSLESS = {"romeo": 24, "romeo_laas_small": 2}


def first_names():
    """By each name that the same file has under another name before: that name."""
    names, found = {}, {}
    for name in (*SOME, *ik.models.example_names()):
        key = example_path(name), example_urdf(name)
        first = names.setdefault(key, name)
        if first != name:
            found[name] = first
    return found


OTHERS = first_names()
OTHER_ROBOTS = [n for n in ik.models.example_names() if n not in SOME and n not in OTHERS]


def struck_scene(robot, prefix=""):
    """Blows on the first and the last link that move; none where nothing does."""
    moved = [link for link in robot.links if link.joint_id > 0 and link.mass > 0.0]
    moved = [link.name for link in moved if link.name.startswith(prefix)]
    # A link called "world" moves with its joint, by whose name it can be struck.
    names = ["root_joint" if name == "world" else name for name in (*moved[:1], *moved[-1:])]
    blows = [
        ik.AppliedImpulse(name, linear=[1, 2, 3], angular=[0.1, 0.2, -0.1], at=[0.01, 0.02, 0.03])
        for name in dict.fromkeys(names)
    ]
    return ik.Scene(robot, blows)


def hold_up(scene, seed):
    """Solve at a random state; everything that an impact is asked for."""
    impact = ik.solve(scene, *random_state(scene.robot, seed))
    assert impact.is_valid(), impact.status
    check = ik.check(impact)
    assert check.agrees, check.report()
    assert all(np.isfinite(wrench).all() for wrench in impact.reactions.values())
    assert set(impact.bodies) == {link.name for link in scene.robot.links}
    json.dumps(impact.to_dict(), allow_nan=False)
    return impact


def everything(name, robot, shown=True):
    scene = struck_scene(robot)
    assert len(robot.massless_joints) == MASSLESS.get(name, 0)
    if robot.massless_joints:
        with pytest.raises(SingularMassError, match="moves no mass") as caught:
            hold_up(scene, 0)
        assert set(caught.value.joints) <= set(robot.massless_joints)
        return
    impact = hold_up(scene, 0)
    if shown:
        page = ik.replay(impact, reactions=True)
        assert set(page.arrows) >= set(scene.entry_names("impulses"))
    pair = ik.combine(a=robot, b=robot, placements={"b": [0, 1, 0]})
    assert (pair.nq, pair.nv) == (2 * robot.nq, 2 * robot.nv)
    hold_up(struck_scene(pair, "b/"), 1)


def under_both_roots(name, shown_under=ROOTS):
    # Together: meshes are read once while a robot that shows them is there.
    robots = [ik.Robot.from_example(name, root=root) for root in ROOTS]
    for root, robot in zip(ROOTS, robots, strict=True):
        everything(name, robot, root in shown_under)


@pytest.mark.slow
@pytest.mark.parametrize("name", SOME)
def test_some_robots(name):
    under_both_roots(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHER_ROBOTS)
def test_every_robot(name):
    # A root moves a picture as a whole, and most of the time goes into meshes.
    under_both_roots(name, shown_under=ROOTS[1:])


def test_a_robot_that_cannot_move_is_solved_all_the_same():
    hector = ik.Robot.from_example("hector")
    scene, q, v = ik.Scene(hector), hector.neutral(), hector.velocity()
    impact = ik.solve(scene, q, v)
    assert repr(impact.status).startswith("<Status.SOLVED")
    assert (ik.solve_batch(scene, [q] * 3, [v] * 3).status == 0).all()
    assert ik.simulate(scene, q, v, duration=0.1).energy().total[-1] == 0.0
    assert ik.plots.overview(impact).axes
