"""The truth of single strikes and of sequences, to more digits than doubles have."""

from __future__ import annotations

import pytest

from benchmarks.stress.run import solved_case
from benchmarks.truths.numbers import truth_numbers
from benchmarks.truths.planar import planar_impulses
from benchmarks.truths.slip import followed

NUMBERS = truth_numbers()
LAWS = ("newton", "poisson", "stronge")


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
