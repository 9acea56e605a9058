"""Thin, fast and turning bodies: each flight meets when its exact motion says so."""

import numpy as np
import pytest

from benchmarks.stress.flights import SWEEPS
from benchmarks.stress.run import jobs_of, solved_case
from benchmarks.truths.flown import first_meeting, from_box, from_segment, turned


@pytest.mark.slow
@pytest.mark.parametrize("sweep", SWEEPS, ids=lambda sweep: sweep.name)
def test_no_flight_is_missed(sweep):
    jobs = [(sweep.name, place, 0, 3) for place in range(len(sweep.values))]
    points = [point for job in jobs for point in solved_case(job)]
    assert len(points) >= len(jobs) - 2
    # A joint of two stops at 1000 rad/s hits them in one step too many: it says so.
    others = [point.verdict for point in points if point.verdict != "right"]
    assert set(others) <= {"said so"} and len(others) <= 1


@pytest.mark.slow
@pytest.mark.parametrize("sweep", SWEEPS, ids=lambda sweep: sweep.name)
def test_of_many_flights_none_is_missed(sweep):
    points = [point for job in jobs_of([sweep], seed=4, share=0.02) for point in solved_case(job)]
    assert all(point.verdict != "wrong" for point in points)


def test_the_truth_finds_the_first_of_many_dips():
    # 2 − 0.3 t − cos 50 t first comes to zero near the top of a turn, as fine steps tell, too.
    def gap(t):
        return 2.0 - 0.3 * t - np.cos(50.0 * t)

    t = np.linspace(0, 5, 2_000_001)
    first = t[np.argmax(gap(t) < 0)]
    assert first_meeting(gap, 50.3, 5.0) == pytest.approx(first, abs=3e-6)
    assert first_meeting(lambda t: 1.0 + t, 1.0, 5.0) == np.inf
    assert first_meeting(lambda t: (t - 1.0) ** 2, 2.0, 5.0) is None


def test_the_truth_knows_distances_and_turns():
    half = np.array([1.0, 2.0, 3.0])
    assert from_box(np.array([4.0, 6.0, 0.0]), half) == pytest.approx(5.0)
    assert from_box(np.array([0.5, 0.0, 0.0]), half) == pytest.approx(-0.5)
    assert from_segment(np.array([3.0, 0.0, 5.0]), 1.0, np.array([0, 0, 1.0])) == pytest.approx(5.0)
    quarter = turned(np.array([0.0, 0.0, 2.0]), np.pi / 4)
    np.testing.assert_allclose(quarter @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)
