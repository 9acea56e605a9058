"""What impacts cannot change, and the worst of a box, against impacts solved one by one."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.design import impact_invariant, worst_impact
from impulsekit.models import pendulum_urdf


def walker():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    q = robot.configuration(root_joint=[0, 0, 0.25, 0, 0, 0, 1])
    rng = np.random.default_rng(5)
    q[7:] += rng.normal(scale=0.4, size=robot.nv - 6)
    feet = [
        ik.Contact(f, restitution=e, friction=9.0) for f, e in (("FL_FOOT", 0.3), ("HR_FOOT", 0.0))
    ]
    return ik.Scene(robot, contacts=feet, gap_bound=np.inf), q


def test_no_impulse_at_the_feet_changes_what_is_kept():
    scene, q = walker()
    found = impact_invariant(scene, q)
    nv = scene.robot.nv
    assert found.basis.shape == (nv - 6, nv)
    rng = np.random.default_rng(1)
    for _ in range(5):
        v = rng.normal(size=nv)
        impact = ik.solve(scene, q, v)
        assert np.abs(found.basis @ impact.dv).max() <= 1e-10 * np.abs(impact.dv).max()
        assert np.abs(found.project(impact.v_after) - found.project(v)).max() < 1e-9
        # Blows at a foot, known to no contact law.
        blow = ik.AppliedImpulse("FL_FOOT", linear=rng.normal(size=3))
        struck = ik.solve(ik.Scene(scene.robot, [blow]), q, v)
        assert np.abs(found.basis @ struck.dv).max() < 1e-10 * np.abs(struck.dv).max()


def test_rows_after_the_impact_are_those_of_sticking_feet():
    scene, q = walker()
    found = impact_invariant(scene, q)
    rng = np.random.default_rng(2)
    stuck = 0
    for _ in range(60):
        v = rng.normal(size=scene.robot.nv)
        impact = ik.solve(scene, q, v)
        if all(
            contact.mode == "sticking" and contact.velocity_before[2] < 0
            for contact in impact.contacts
        ):
            stuck += 1
            assert np.abs(found.after @ v - impact.v_after).max() < 1e-9 * np.abs(v).max() * 10
    assert stuck >= 5


def test_errors_that_an_impact_explains_are_not_acted_on():
    scene, q = walker()
    found = impact_invariant(scene, q)
    rng = np.random.default_rng(3)
    v, rows = rng.normal(size=scene.robot.nv), rng.normal(size=(9, scene.robot.nv))
    jump = found.moved @ rng.normal(size=found.moved.shape[1])
    own = rng.normal(size=9)
    assert np.abs(found.corrected(rows, rows @ (v + jump), v)).max() < 1e-9
    left = found.corrected(rows, rows @ (v + jump) + own, v)
    assert left == pytest.approx(found.corrected(rows, rows @ v + own, v), abs=1e-9)
    assert np.abs((rows @ found.moved).T @ left).max() < 1e-9 * np.abs(rows @ found.moved).max()


@pytest.mark.slow
def test_the_worst_of_a_box_is_that_of_a_fine_grid():
    arm = ik.Robot.from_urdf(pendulum_urdf(2))
    wall = ik.Contact("link_2", at=[0, 0, -1], normal=[-1, 0, 0], friction=0.3)
    scene = ik.Scene(arm, contacts=[wall], gap_bound=9.0)
    q, v = np.array([0.3, 0.5]), np.array([-1.0, -0.6])
    worst = worst_impact(
        scene, q, v, "joint_1", restitution=(0.1, 0.7), pose={"joint_2": (-0.6, 0.6)}, samples=32
    )
    most = 0.0
    for e in (0.1, 0.4, 0.7):
        for offset in np.linspace(-0.6, 0.6, 25):
            contact = ik.Contact(
                "link_2", at=[0, 0, -1], normal=[-1, 0, 0], friction=0.3, restitution=e
            )
            impact = ik.solve(
                ik.Scene(arm, contacts=[contact], gap_bound=9.0), q + np.array([0, offset]), v
            )
            if impact.is_valid():
                most = max(most, float(np.linalg.norm(impact.reactions["joint_1"][:3])))
    assert worst.impulse >= most * (1 - 1e-6) and worst.impulse < 1.05 * most
    assert worst.impulse == pytest.approx(np.linalg.norm(worst.reaction[:3]))
