"""Masses a million times apart: what double precision cannot hold is said to be inaccurate."""

import pytest

from benchmarks.stress.run import solved_case, sweep_named


@pytest.mark.parametrize("ratio, repeat", [(1e6, 6), (1e6, 13), (1e8, 29)])
def test_contacts_whose_impulses_lose_digits_are_not_called_solved(ratio, repeat):
    place = sweep_named("contact-mass-ratio").values.index(pytest.approx(ratio))
    points = solved_case(("contact-mass-ratio", place, repeat, 0))
    assert {point.verdict for point in points} == {"right", "said so"}
    assert {point.status for point in points if point.verdict == "said so"} == {"INACCURATE"}
