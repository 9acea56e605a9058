"""Batches tell of several v⁺ as ``solve`` does."""

import numpy as np
import pytest

import impulsekit as ik
from tests.impact.test_uniqueness import bodies_in_a_plane

VERDICTS = ("proven", "not proven", "several")


def agree(scene, q, V):
    """How many rows of a batch have several v⁺; each row is as ``solve`` has it."""
    batch = ik.solve_batch(scene, q, V)
    for row, v in enumerate(V):
        impact = ik.solve(scene, q, v)
        assert impact.status == batch.status[row]
        if impact.status.valid or impact.status is ik.Status.MANY_SOLUTIONS:
            assert VERDICTS[batch.uniqueness[row]] == impact.uniqueness.verdict
    assert batch.valid[batch.uniqueness == 2].sum() == 0
    return int((batch.uniqueness == 2).sum())


def test_rows_of_bodies_in_a_plane_are_told_as_by_solve():
    several = 0
    rng = np.random.default_rng(1)
    for seed in range(6):
        scene, v, _ = bodies_in_a_plane(seed)
        V = rng.normal(size=(12, len(v)))
        several += agree(scene, scene.robot.neutral(), V)
    assert several > 0


@pytest.mark.slow
def test_rows_in_space_are_told_as_by_solve():
    robot = ik.Robot.from_example("panda")
    rng = np.random.default_rng(2)
    contacts = [
        ik.Contact(link, at=rng.normal(size=3) * 0.1, normal=rng.normal(size=3), friction=mu)
        for link, mu in (("panda_hand", 0.9), ("panda_link5", 0.7))
    ]
    scene = ik.Scene(robot, contacts=contacts)
    q = robot.configuration(panda_joint2=0.4, panda_joint4=-1.5, panda_joint6=1.0)
    agree(scene, q, rng.normal(size=(40, robot.nv)))


@pytest.mark.slow
@pytest.mark.parametrize("restitution", ["newton", "poisson"])
def test_rows_of_redundant_contacts_in_space_are_told_as_by_solve(restitution):
    # An arm's second link has two motions, so that a contact may be held by many shares.
    robot = ik.Robot.from_example("panda")
    rng = np.random.default_rng(5)
    for _ in range(4):
        contacts = [
            ik.Contact(
                "panda_link2", at=rng.normal(size=3), normal=rng.normal(size=3), friction=mu,
                restitution=e,
            )
            for mu, e in zip(rng.choice([0.6, 1.5], 2), rng.choice([0.0, 0.5], 2), strict=True)
        ]  # fmt: skip
        law = ik.Law(restitution=restitution)
        scene = ik.Scene(robot, contacts=contacts, law=law)
        agree(scene, robot.neutral(), rng.normal(size=(8, robot.nv)))


def test_rows_show_answers_without_a_gain_of_energy_as_solve_does():
    scene, v, _ = bodies_in_a_plane(5041, frictions=(0.0, 1.0, 3.0, 10.0))
    rows = v * np.linspace(0.99, 1.01, 40)[:, None]
    batch = ik.solve_batch(scene, scene.robot.neutral(), rows)
    for row in (0, 39):
        impact = ik.solve(scene, scene.robot.neutral(), rows[row])
        assert ik.Status(batch.status[row]) is impact.status is ik.Status.MANY_SOLUTIONS
        assert np.allclose(batch.v_after[row], impact.v_after, rtol=0, atol=1e-14)
    assert not (batch.status == ik.Status.ENERGY_GAIN).any()
