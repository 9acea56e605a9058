"""Trees that Pinocchio's data could not hold."""

import math

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.long import long_chain, long_tree
from impulsekit.reference.whittaker import struck_chain
from tests.batch.compare import random_states


def struck(links):
    chain = long_chain(links)
    return chain.solve([ik.AppliedImpulse(f"link_{links}", linear=[0, 5, 0], at=[1, 0, 0])])


def point_speeds(impact):
    """(n + 1,) of all points across the chain, from the struck end on."""
    twists = impact.twists_after[::-1]
    return np.append(twists[:, 1] + twists[:, 5], twists[-1, 1])


def test_against_exact_fractions():
    exact = struck_chain(200, impulse=5)
    speeds = np.array([float(u) for u in exact.point_velocities])
    impact = struck(200)
    assert np.abs(point_speeds(impact) - speeds).max() < 1e-14 * np.abs(speeds).max()
    borne = np.array([float(s) for s in exact.pin_impulses])
    # A pin's parent is the link further from the blow.
    assert np.abs(impact.reactions[1:, 1][::-1] + borne[1:-1]).max() < 1e-12


def test_a_hundred_thousand_links_against_the_closed_form():
    speeds = point_speeds(struck(100_000))
    # u_k = (2√3 P/m) (−(2 − √3))ᵏ, which leaves the doubles near k = 560.
    expected = 10 * math.sqrt(3) * (-(2 - math.sqrt(3))) ** np.arange(500)
    assert np.abs(speeds[:500] - expected).max() < 1e-10 * expected[0]
    assert np.abs(speeds[500:]).max() < 1e-10 * expected[0]


@pytest.mark.parametrize("name", ["talos", "solo12"])
def test_a_robot_by_the_same_code(name):
    robot = ik.Robot.from_example(name, root="freeflyer")
    joint = robot.joint_names[5]
    impulses = [
        ik.AppliedImpulse(robot.links[-1].name, [0.3, -1, 0.2], [0.1, 0, 0.1], at=[0.1, 0, 0]),
        ik.AppliedImpulse(robot.links[0].name, [1, 2, 3], axes="local"),
        ik.JointImpulse(joint, 0.4),
    ]
    (q,), (v,) = random_states(robot, 1)
    theirs = ik.solve(ik.Scene(robot, impulses), q, v)
    ours = long_tree(robot).solve(impulses, q, v)
    assert np.abs(ours.dv - theirs.dv).max() < 1e-12 * np.abs(theirs.dv).max()
    link = robot.links[-1].name
    after = theirs.velocity_at(link, [0.1, 0.2, 0.3]).after
    assert ours.velocity_at(link, [0.1, 0.2, 0.3]) == pytest.approx(after, rel=1e-10)
    for i, one in enumerate(robot.joint_names):
        size = np.abs(theirs.reactions[one]).max()
        assert np.abs(ours.reactions[i] - theirs.reactions[one]).max() < 1e-10 * max(size, 1.0)


def test_a_random_tree_keeps_momentum_and_balances_every_body():
    rng = np.random.default_rng(0)
    n = 3000
    parents = np.array([-1, *(rng.integers(max(0, k - 20), k) for k in range(1, n))])
    axes = rng.normal(size=(n, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    tree = long_tree(
        parents,
        masses=rng.uniform(1, 2, n),
        centres=rng.normal(size=(n, 3)),
        inertias=np.array([np.diag(d) for d in rng.uniform(1, 1.5, (n, 3))]),
        translations=rng.normal(size=(n, 3)),
        joints=["freeflyer", *rng.choice(["revolute", "prismatic", "spherical"], n - 1)],
        axes=axes,
    )
    q = tree.neutral()
    impact = tree.solve([ik.AppliedImpulse(f"link_{n}", [1, 2, 3], [0.1, 0.2, 0.3])], q)
    # A root that is free bears nothing: all that comes to it balances.
    assert np.abs(impact.reactions[0]).max() < 1e-8
    assert np.abs(impact.dv).max() > 0
