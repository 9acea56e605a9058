"""The method step by step on Pinocchio gives what the core gives, for every entry and law."""

import numpy as np
import pytest

import impulsekit as ik
from tests.conformance import scenes
from tests.conformance.entries import ENTRIES
from tests.robots import random_blow, random_state

LAWS = [
    ik.Law(),
    ik.Law("poisson"),
    ik.Law(order="sequential"),
    ik.Law("poisson", order="sequential"),
]
CASES = {
    make.__name__: make
    for make in (scenes.one, scenes.two, scenes.apart, scenes.four, scenes.held, scenes.flat)
}
SAME = 1e-12


def assert_same(scene, q, v):
    impact = ik.solve(scene, q, v)
    problem = ik.contact_problem(scene, q, v)
    found = problem.solve()
    size = max(np.abs(impact.dv).max(), np.abs(v).max(), 1e-300)
    assert found.status == impact.status or not len(problem.names)
    assert np.abs(found.dv - impact.dv).max() <= SAME * size
    return impact, problem, found


@pytest.mark.parametrize("name", ENTRIES)
def test_every_entry_of_the_vocabulary(name):
    entry = ENTRIES[name]
    assert_same(entry.scene, entry.q, entry.v)


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("name", CASES)
def test_every_law_of_many_contacts(name, law):
    case = CASES[name]()
    scene = case.scene.replace(law=law)
    impact, problem, found = assert_same(scene, case.q, case.v)
    assert found.impulses[2 : 3 * len(problem.names) : 3].min(initial=0.0) >= -1e-12
    momentum = problem.mass_matrix @ found.dv - problem.generalized_impulse
    momentum -= problem.jacobian.T @ found.impulses
    momentum -= problem.constraint_matrix.T @ found.constraint_impulses
    assert np.abs(momentum).max() <= SAME * max(1.0, np.abs(problem.mass_matrix).max())
    assert impact.is_valid() == found.status.valid


ROBOTS = ["panda", "ur5", "solo12", "talos", "hyq", "anymal", "tiago"]


@pytest.mark.parametrize("axes", ["world", "local"])
@pytest.mark.parametrize("name", ROBOTS)
def test_known_impulses_alone(name, axes):
    if name not in ik.models.example_names():
        pytest.skip(f"no {name} in this version of example-robot-data")
    robot = ik.Robot.from_example(name, root="freeflyer")
    joint = next(j for j in reversed(robot.joint_names) if robot.model.nvs[robot.joint_id(j)] == 1)
    blows = [random_blow(link.name, i, axes) for i, link in enumerate(robot.links[-3:])]
    scene = ik.Scene(robot, [*blows, ik.JointImpulse(joint, 0.4)])
    assert ik.impact.ImpactSolver(scene).plan.algorithm == "articulated"
    assert_same(scene, *random_state(robot, 4))


@pytest.mark.parametrize("name", ROBOTS)
def test_robots(name):
    if name not in ik.models.example_names():
        pytest.skip(f"no {name} in this version of example-robot-data")
    robot = ik.Robot.from_example(name, root="freeflyer")
    q, v = random_state(robot, 3)
    frames = [link.name for link in robot.links][-1:]
    touching = [ik.Contact(frames[0], normal=[0.6, 0, 0.8], restitution=0.4, friction=0.5)]
    scene = ik.Scene(robot, [random_blow(frames[0], 5)], contacts=touching)
    assert_same(scene, q, v)


def test_the_residual_tells_impulses_that_obey_newtons_law_from_others():
    case = scenes.two()
    problem = ik.contact_problem(case.scene, case.q, case.v)
    found = problem.solve(ik.Law())
    assert problem.residual(found.impulses) < 1e-12
    assert problem.residual(1.01 * found.impulses) > 1e-4
    assert problem.residual(np.zeros_like(found.impulses)) > 1e-2
    with pytest.raises(ik.errors.ShapeError, match="impulses"):
        problem.residual([1.0])


def test_a_mass_matrix_that_is_singular_is_told():
    text = """<robot name="r"><link name="a"/><link name="b"/><joint name="hinge"
    type="continuous"><parent link="a"/><child link="b"/></joint></robot>"""
    robot = ik.Robot.from_urdf(text)
    scene = ik.Scene(robot, [ik.AppliedImpulse("b", angular=[0, 0, 1])])
    with pytest.raises(ik.errors.SingularMassError, match="singular"):
        ik.contact_problem(scene, robot.neutral(), robot.velocity())
