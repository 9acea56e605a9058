"""Impacts of a motion are those that it met on its way: none is solved again to be read."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.impact import scene_jump
from impulsekit.impact.scene_jump import jump_of
from impulsekit.motion.record.impact_arrays import impacts_of, packed_impacts

from ..models import MODELS
from ..test_drops import thrown

LAWS = {
    "newton": ik.Law(),
    "poisson": ik.Law(restitution="poisson"),
    "stronge": ik.Law(restitution="stronge", slip="path", order="sequential"),
}


def limp_solo(law=None, seconds=0.3):
    """Solo12 dropped on its feet."""
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    feet = [f"{leg}_FOOT" for leg in ("FL", "FR", "HL", "HR")]
    contacts = [ik.Contact(foot, restitution=0.3, friction=0.3) for foot in feet]
    scene = ik.Scene(solo, contacts=contacts, law=law or ik.Law(restitution="poisson"))
    q = solo.neutral().copy()
    q[2] = 0.4
    v = 0.3 * np.random.default_rng(5).normal(size=solo.nv)
    return ik.simulate(scene, q, v, duration=seconds)


@pytest.mark.parametrize("law", LAWS)
def test_an_impact_is_bit_for_bit_one_solve_of_its_state(law):
    hits = limp_solo(LAWS[law]).impacts
    assert len(hits) >= 4
    for _, impact in hits:
        core = impact.solved.core
        again = (
            jump_of(impact.scene)
            .solve(impact.scene, impact.q, impact.v_before, set(core.rows.entries))
            .core
        )
        np.testing.assert_array_equal(impact.dv, again.solution.dv)
        impulse = core.solution.contact.impulse
        np.testing.assert_array_equal(impulse, again.solution.contact.impulse)


def test_impacts_and_their_derivatives_are_read_without_a_solve(monkeypatch):
    motion = limp_solo()
    monkeypatch.setattr(scene_jump, "solve_scene", None)
    assert len(motion.impacts) >= 4
    for _, impact in motion.impacts:
        assert impact.status.valid and impact.contacts[0].impulse.shape == (3,)
        assert ik.derivatives(impact)["v_after", "v"].shape == (18, 18)


def test_impacts_stay_when_a_simulation_goes_on():
    ball = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    floor = ik.Contact("ball", restitution=0.9, name="floor")
    start = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    sim = ik.Simulation(ik.Scene(ball, contacts=[floor]), start, ball.velocity())
    first = sim.next_impact()
    after, early = first.v_after.copy(), sim.trajectory()
    for _ in range(100):
        sim.next_impact()
    np.testing.assert_array_equal(early.impacts[0][1].v_after, after)
    np.testing.assert_array_equal(sim.impacts[0][1].v_after, after)
    assert len(early.impacts) == 1 and len(sim.impacts) == 101


@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_a_controlled_joint_yields_to_its_stop_in_a_motion(restitution):
    """As in one solve: the scene of the impact is without that joint's control."""
    panda = ik.Robot.from_example("panda")
    arm = [f"panda_joint{i}" for i in range(1, 8)]
    stop = ik.JointStop("panda_joint4", restitution=restitution)
    scene = ik.Scene(panda, contacts=[stop], controlled=arm, gravity=(0, 0, 0))
    q = panda.configuration(panda_joint4=panda.model.upperPositionLimit[3] - 0.01)
    v = panda.velocity(panda_joint4=0.5)
    (_, impact), *_ = ik.simulate(scene, q, v, duration=0.1).impacts
    assert "panda_joint4" not in impact.scene.controlled and len(impact.constraints) == 6
    assert impact.v_after[3] == pytest.approx(-restitution * impact.v_before[3], abs=1e-15)
    others = [i for i in range(7) if i != 3]
    np.testing.assert_allclose(impact.v_after[others], impact.v_before[others], atol=1e-14)
    alone = ik.solve(impact.scene, impact.q, impact.v_before)
    np.testing.assert_allclose(impact.dv, alone.dv, atol=1e-14)
    for ours, theirs in zip(impact.constraints, alone.constraints, strict=True):
        np.testing.assert_allclose(ours.impulse, theirs.impulse, atol=1e-13)
    ours, theirs = (ik.derivatives(one)["v_after", "v"] for one in (impact, alone))
    np.testing.assert_allclose(ours, theirs, atol=1e-12)
    assert impact.reactions.keys() == alone.reactions.keys()


def test_what_was_met_without_restitution_is_so_in_files(tmp_path):
    """A box that comes to rest is met softly in the end."""
    motion = ik.simulate(*thrown("ground", 0), duration=1.5)
    soft = [t for t, hit in motion.impacts if hit.scene.contacts[0].restitution == 0.0]
    assert 0 < len(soft) < len(motion.impacts)
    motion.save(tmp_path / "m.npz")
    again = ik.Trajectory.load(tmp_path / "m.npz", scene=motion.scene)
    for (_, ours), (_, theirs) in zip(motion.impacts, again.impacts, strict=True):
        assert ours.scene is theirs.scene
        np.testing.assert_array_equal(ours.dv, theirs.dv)
        np.testing.assert_array_equal(ours.dv, theirs.solved.core.solution.dv)


def test_nearly_dependent_rows_are_told_of_files_too():
    """Two locks of one hinge whose rows differ by 1e-8."""
    pendulum = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    locks = [
        ik.JointLock("joint_1"),
        ik.JointCoupling("joint_1", "joint_2", ratio=1e-8),
    ]
    scene = ik.Scene(pendulum, [ik.JointImpulse("joint_2", 1.0)], locks)
    impact = ik.solve(scene, pendulum.neutral(), pendulum.velocity())
    assert impact.status is ik.Status.NEARLY_DEPENDENT
    (_, again), *_ = impacts_of(scene, *packed_impacts(scene, [(0.0, impact)]))
    assert again.status is impact.status
