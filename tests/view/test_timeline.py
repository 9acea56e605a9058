"""Playback time against motion time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from impulsekit.view.timeline import Timeline

TIMES = st.floats(0.0, 10.0)


def test_as_it_is():
    line = Timeline.of(1.0, 3.0)
    assert line.duration == 2.0
    frames = line.frames(30.0)
    assert len(frames) == 61
    assert line.to_motion(frames)[[0, -1]].tolist() == [1.0, 3.0]


def test_slow_around_impacts_and_overlapping_windows():
    line = Timeline.of(0.0, 2.0, [1.0, 1.05], slow_motion=0.5, window=0.1, speed=2.0)
    # 0.25 s are slowed to the speed 1, the rest runs at 2.
    assert line.duration == pytest.approx(1.75 / 2.0 + 0.25)
    assert line.to_motion(line.to_playback(1.02)) == pytest.approx(1.02)


def test_impacts_get_a_frame_of_their_own_once():
    line = Timeline.of(0.0, 1.0)
    frames = line.frames(10.0, [0.25, 0.5])
    assert len(frames) == 12
    assert 0.25 in frames


def test_a_duration_that_is_no_whole_number_of_frames_ends_exactly():
    frames = Timeline.of(0.0, 0.95).frames(10.0)
    assert frames[-1] == 0.95
    assert len(frames) == 11
    assert Timeline.of(2.0, 2.0).frames(60.0).tolist() == [0.0]


@given(TIMES, TIMES, st.lists(TIMES, max_size=6), st.floats(0.05, 1.0), st.floats(0.0, 1.0))
def test_both_ways_lead_back(a, b, impacts, slow, window):
    start, end = min(a, b), max(a, b)
    line = Timeline.of(start, end, impacts, slow_motion=slow, window=window)
    assert (np.diff(line.played) >= 0.0).all()
    assert end - start <= line.duration + 1e-9
    assert line.duration <= (end - start) / slow + 1e-9
    middle = 0.5 * (start + end)
    assert line.to_motion(line.to_playback(middle)) == pytest.approx(middle, abs=1e-6)
