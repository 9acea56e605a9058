"""Two capsules: across each other, side by side, end on end."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from impulsekit.geometry.collision import meeting_points, solid_of

PILL, THIN = coal.Capsule(0.5, 1.0), coal.Capsule(0.2, 3.0)


def at(x, y, z, *rpy):
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy) if rpy else np.eye(3), np.array([x, y, z], float))


def meet(a, place_a, b, place_b, margin=1e-6):
    return list(meeting_points([(solid_of(a), place_a)], [(solid_of(b), place_b)], margin))


LYING = (0.0, np.pi / 2, 0.0)


@pytest.mark.parametrize("tilt", [0.0, 1e-7, -1e-7])
def test_side_by_side_they_meet_at_both_ends_of_what_they_share(tilt):
    points = meet(PILL, at(0.2, 0, 1, 0, np.pi / 2 + tilt, 0), PILL, at(0, 0, 0, *LYING))
    assert sorted(round(point.position[0], 5) for point in points) == [-0.3, 0.5]
    for point in points:
        np.testing.assert_allclose(point.normal, [0, 0, 1], atol=1e-6)
        assert point.position[2] == pytest.approx(0.5, abs=1e-6)


def test_of_two_that_differ_the_shorter_one_ends_the_stretch():
    points = meet(THIN, at(0.2, 0, 0.7, *LYING), PILL, at(0, 0, 0, *LYING))
    np.testing.assert_allclose(sorted(p.position[0] for p in points), [-0.5, 0.5], atol=1e-12)
    np.testing.assert_allclose([p.position[2] for p in points], 0.5, atol=1e-12)
    np.testing.assert_allclose([p.gap for p in points], 0.0, atol=1e-12)


@pytest.mark.parametrize("angle", [0.1, 0.5, np.pi / 2])
def test_across_each_other_they_meet_in_one_point(angle):
    points = meet(PILL, at(0, 0, 1, 0, np.pi / 2, angle), PILL, at(0, 0, 0, *LYING))
    assert len(points) == 1
    np.testing.assert_allclose(points[0].position, [0, 0, 0.5], atol=1e-12)
    np.testing.assert_allclose(points[0].normal, [0, 0, 1], atol=1e-12)


def test_end_on_end_they_meet_as_balls_do():
    points = meet(PILL, at(1.0, 0, 1.6), PILL, at(0, 0, 0, 0.1, 0.2, 0), margin=1.0)
    way = np.array([1.0, 0, 1.1]) - at(0, 0, 0, 0.1, 0.2, 0).rotation @ [0, 0, 0.5]
    np.testing.assert_allclose(points[0].normal, way / np.linalg.norm(way), atol=1e-12)
    assert points[0].gap == pytest.approx(np.linalg.norm(way) - 1.0, abs=1e-12)


def test_what_is_further_apart_than_the_margin_does_not_meet():
    assert meet(PILL, at(0, 0, 1 + 2e-6, *LYING), PILL, at(0, 0, 0, *LYING)) == []
