"""Several contacts with friction: every answer satisfies the law, whichever it is."""

from dataclasses import replace

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.batch.inputs import batch_inputs
from impulsekit.batch.plans import plan_batch
from impulsekit.batch.run import BatchRun
from impulsekit.bench.problems.blocks import landing_blocks
from impulsekit.impact.contact_space import simultaneous
from impulsekit.laws.modes import residual_of
from impulsekit.laws.struck import strike_at_once
from tests.batch.compare import random_states
from tests.impact.contact_space.posed import posed
from tests.lawful import left_of_the_law

pytest.importorskip("numba")

CORNERS = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "restitution"), [(0.5, 0.0), (0.7, 0.1), (0.3, 0.3)])
@pytest.mark.parametrize("spread", [0.1, 1.5])
def test_eight_foot_points(monkeypatch, friction, restitution, spread):
    talos = ik.Robot.from_example("talos", root="freeflyer")
    contacts = [
        ik.Contact(sole, at=at, friction=friction, restitution=restitution)
        for sole in ("left_sole_link", "right_sole_link")
        for at in CORNERS
    ]
    scene = ik.Scene(talos, contacts=contacts)
    q, v = random_states(talos, 16, spread=spread)
    v *= 0.2
    v[:, 2] -= 1.0
    batch = ik.solve_batch(scene, q, v, outputs=("v_after", "contact_impulses"))
    assert batch.plan.kernel
    assert batch.valid.all()
    problems = []

    class Seen(Exception):
        pass

    def keep(problem, law):
        shifted = problem.velocity_free.copy()
        shifted[2::3] += problem.restitution * np.minimum(problem.velocity_before[2::3], 0.0)
        problems.append((problem.delassus, shifted, problem.friction))
        raise Seen

    # With friction and redundant points the law may have several answers, so each is held
    # against the law itself, on the matrices of the other way.
    monkeypatch.setattr(simultaneous, "solve_simultaneous", keep)
    # Compiled, it would be asked in one call, with the rows before it.
    monkeypatch.setattr(strike_at_once, "_code", None)
    monkeypatch.setattr(strike_at_once, "wait", lambda seconds: None)
    for i in range(16):
        with pytest.raises(Seen):
            _ = ik.solve(scene, q[i], v[i]).dv
        given = posed(*problems[-1], batch.contact_impulses[i].ravel())
        assert residual_of(*given) < 1e-9


def test_where_two_answers_differ_both_obey_the_law():
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    feet = ("FR_FOOT", "FL_FOOT", "HR_FOOT", "HL_FOOT")
    contacts = [ik.Contact(one, at=[0, 0, -0.01], friction=0.6, restitution=0.3) for one in feet]
    scene = ik.Scene(solo, contacts=contacts)
    q, v = random_states(solo, 300, seed=3)
    batch = ik.solve_batch(scene, q, v)
    apart = 0
    for i in range(300):
        impact = ik.solve(scene, q[i], v[i])
        size = np.abs(v[i]).max() + np.abs(impact.dv).max()
        if np.abs(batch.v_after[i] - impact.v_after).max() > 1e-12 * size:
            apart += 1
            # Not a matter of digits.
            assert np.abs(batch.v_after[i] - impact.v_after).max() > 1e-3 * size
            assert left_of_the_law(scene, q[i], v[i], batch.v_after[i]) < 1e-10
            assert left_of_the_law(scene, q[i], v[i], impact.v_after) < 1e-10
    assert apart <= 3


def test_states_that_only_fill_a_block_are_not_given_to_the_law():
    """A batch of one row costs one answer of its law, not one for each lane of a block."""
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    scene = ik.Scene(robot, contacts=[ik.Contact(foot) for foot in ("FL_FOOT", "HR_FOOT")])
    inputs = batch_inputs(scene, robot.neutral(), None, None, None, None, None)
    run = BatchRun(plan_batch(scene)[0], inputs, {}, np.zeros(1, dtype=np.int8))
    first, *others = run._inputs.codes.tolist()
    assert first == int(ik.Status.SOLVED) and len(others) >= 1
    assert set(others) == {int(ik.Status.OUT_OF_RANGE)}


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_a_block_that_lands_on_many_points_is_left_to_no_other(law):
    # v_n⁺ = −e v_n, |v_t⁺| = |v_t| − µ (1 + e) |v_n|: Coulomb's law on the whole block.
    problem = next(each for each in landing_blocks(False) if each.size == 32)
    scene = replace(problem.scene, law=ik.Law(law))
    turned = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, 4)
    v, truth = np.tile(problem.v, (4, 1)), np.tile(problem.answer, (4, 1))
    for own, angle in zip((*v, *truth), (*turned, *turned), strict=True):
        own[:2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]] @ own[:2]
    batch = ik.solve_batch(scene, problem.q, v)
    assert batch.plan.kernel
    assert not batch.single.any()
    assert (batch.status == ik.Status.NOT_UNIQUE).all()
    assert np.abs(batch.v_after - truth).max() < 1e-13
