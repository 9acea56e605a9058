"""The truth of single strikes and of sequences, to more digits than doubles have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.stress.run import solved_case, sweep_named
from benchmarks.stress.strikes import Strikes
from tests.truths.numbers import truth_numbers
from tests.truths.planar import planar_impulses
from tests.truths.slip import followed
from tests.truths.strike import Block, strikes

NUMBERS = truth_numbers()
LAWS = ("newton", "poisson", "stronge")


def _contact(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 4))
    u = rng.normal(size=3)
    u[2] = -abs(u[2])
    return NUMBERS.array(root @ root.T), NUMBERS.array(u)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(3))
def test_turning_slip_does_not_know_in_which_axes_it_is_told(law, seed):
    W, u = _contact(seed)
    c, s = NUMBERS.cos(NUMBERS.number(1)), NUMBERS.sin(NUMBERS.number(1))
    turn = NUMBERS.eye(3)
    turn[0, 0], turn[0, 1], turn[1, 0], turn[1, 1] = c, -s, s, c
    half, mu = NUMBERS.number(0.5), NUMBERS.number(0.6)
    here = followed(NUMBERS, W, u, half, mu, law)
    there = followed(NUMBERS, turn @ W @ turn.T, turn @ u, half, mu, law)
    assert max(abs(turn @ here - there)) < 1e-20


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("across", [0.0, 1e-3])
def test_slip_in_a_plane_is_the_planar_answer(law, across):
    # All but in the plane it turns there, and the answer is as near.
    W = NUMBERS.array([[3.0, 0.0, 0.7], [0.0, 2.0, 0.0], [0.7, 0.0, 2.0]])
    u = NUMBERS.array([1.0, across, -1.0])
    half, mu = NUMBERS.number(0.5), NUMBERS.number(0.3)
    data = [W[0, 0], W[0, 2], W[2, 2], u[0], u[2]]
    ((tangential, normal),) = planar_impulses(data, half, mu, law, "path")
    found = followed(NUMBERS, W, u, half, mu, law)
    bound = max(1e-45, 3 * across)
    assert abs(found[0] - tangential) < bound
    assert abs(found[2] - normal) < bound


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_friction_along_the_path_takes_energy_and_stays_in_its_cone(law):
    for seed in range(4):
        W, u = _contact(seed)
        mu = NUMBERS.number(0.4)
        P = followed(NUMBERS, W, u, NUMBERS.number(1), mu, law)
        assert NUMBERS.norm(P[:2]) <= mu * P[2]
        gain = P @ (u + u + W @ P) / 2
        # e = 1 by the work of the normal impulse alone gives back no more than it took.
        if law == "stronge":
            assert gain < 0


@pytest.mark.parametrize("restitution", ["newton", "poisson"])
def test_each_impulse_at_the_end_obeys_coulombs_law(restitution):
    mu, half = NUMBERS.number(0.5), NUMBERS.number(0.5)
    for seed in range(6):
        W, u = _contact(seed)
        law = ik.Law(restitution)
        for P in strikes(Block(NUMBERS, W, half, mu), u, law):
            after = u + W @ P
            slip = NUMBERS.norm(after[:2])
            if restitution == "newton":
                assert abs(after[2] + u[2] / 2) < 1e-40
                if slip > 1e-40:
                    assert max(abs(P[:2] * slip + mu * P[2] * after[:2])) < 1e-40
            assert NUMBERS.norm(P[:2]) <= mu * P[2] * (1 + 1e-40)


def test_what_gives_nothing_back_is_struck_once():
    none, mu = NUMBERS.number(0), NUMBERS.number(3)
    for seed in range(16):
        W, u = _contact(seed)
        block = Block(NUMBERS, W, none, mu)
        newton, poisson = (strikes(block, u, ik.Law(law)) for law in ("newton", "poisson"))
        assert len(newton) == len(poisson)
        assert all(max(abs(a - b)) < 1e-40 for a, b in zip(newton, poisson, strict=True))


@pytest.mark.parametrize("restitution", ["newton", "poisson"])
def test_the_condition_is_that_of_friction_too_small_to_matter(restitution):
    case = sweep_named("sequence-friction").cases(0.0, np.random.default_rng(4))
    scene = replace(case.scene, law=ik.Law(restitution, "end", "sequential"))
    rough = replace(scene, contacts=[replace(c, friction=1e-40) for c in scene.contacts])
    without, with_it = (Strikes(each).at(case.q[0], case.v[0]).exact() for each in (scene, rough))
    assert max(abs(without.dv - with_it.dv)) < 1e-30
    assert without.condition == pytest.approx(with_it.condition, rel=1e-6)


def test_three_equal_balls_pass_the_blow_on():
    case = sweep_named("sequence-balls").cases
    for repeat in range(30):
        made = case(1.0, np.random.default_rng(repeat))
        scene = made.scene
        if {c.restitution for c in scene.contacts} == {1.0} and not scene.impulses:
            break
    count = scene.robot.nv
    v = np.zeros(count)
    v[0] = 1.0
    exact = Strikes(scene).at(scene.robot.neutral(), v).exact()
    after = (exact.dv + NUMBERS.array(v)).astype(float)
    assert after == pytest.approx([*np.zeros(count - 1), 1.0], abs=1e-30)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("sequence-balls", 2),
        ("sequence-friction", 4),
        ("turning-slip", 3),
        ("slow-slip", 8),
        ("balls-meet", 2),
        ("ball-on-slab", 3),
        pytest.param("box-on-box", 4, marks=pytest.mark.slow),
    ],
)
def test_no_answer_in_sequence_along_the_path_or_of_shapes_is_silently_wrong(name, place):
    points = solved_case((name, place, 0, 0))
    assert points
    assert not [p for p in points if p.verdict == "wrong"]
    assert all(p.momentum < 1e-14 for p in points if p.verdict == "right")
