"""Random scenes of one to three example robots, against Kane's equations and the laws."""

import pytest

from benchmarks.stress.robots import LAWS, SWEEPS
from benchmarks.stress.run import solved_case


@pytest.mark.parametrize(
    "place",
    range(len(LAWS)),
    ids=lambda i: f"{LAWS[i].restitution}-{LAWS[i].slip}-{LAWS[i].order}",
)
@pytest.mark.parametrize(
    "count",
    [
        pytest.param(3, id="few"),
        pytest.param(30, id="many", marks=[pytest.mark.slow, pytest.mark.sweep]),
    ],
)
def test_valid_answers_are_those_of_kane_and_keep_the_law(place, count):
    jobs = [(SWEEPS[0].name, place, repeat, count) for repeat in range(count)]
    points = [point for job in jobs for point in solved_case(job)]
    assert [point for point in points if point.verdict == "wrong"] == []
    assert sum(point.verdict == "right" for point in points) >= count // 3
