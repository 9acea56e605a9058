"""Impacts on the way: none missed, none doubled, however many, near or fast."""

import numpy as np
import pytest

import impulsekit as ik

from ..models import GRAVITY, bounces, hits, sliders


@pytest.mark.slow
def test_fifty_bouncing_bodies_at_once():
    robot = sliders(50)
    rng = np.random.default_rng(1)
    heights, restitutions = rng.uniform(0.2, 2.0, 50), rng.uniform(0.3, 0.8, 50)
    contacts = [ik.Contact(f"b{i:02d}", restitution=restitutions[i]) for i in range(50)]
    scene = ik.Scene(robot, contacts=contacts)
    motion = ik.simulate(scene, heights, np.zeros(50), duration=1.2, samples=101)
    assert motion.status.finished
    assert motion.q.min() > -1e-12
    for i in range(50):
        wanted = bounces(heights[i], restitutions[i], 1.2, slowest=1e-3)
        np.testing.assert_allclose(hits(motion, i, 1e-3), wanted, rtol=0, atol=1e-8)


@pytest.mark.parametrize("apart", [0.0, 3e-10, 1e-9, 1e-8, 1e-6])
def test_three_hits_close_together_are_three_hits(apart):
    robot = sliders(3)
    contacts = [ik.Contact(f"b{i:02d}", restitution=0.5) for i in range(3)]
    times = 0.4 + apart * np.arange(3)
    heights = 0.5 * GRAVITY * times**2
    motion = ik.simulate(ik.Scene(robot, contacts=contacts), heights, np.zeros(3), duration=0.5)
    for i in range(3):
        (hit,) = hits(motion, i, 1e-6)
        assert hit == pytest.approx(times[i], abs=2e-9)
    np.testing.assert_allclose(motion.v[-1], 0.5 * GRAVITY * 0.4 - GRAVITY * 0.1, atol=1e-4)
    if apart < 4e-10:
        assert len(motion.impacts) == 1


@pytest.mark.parametrize(
    ("clearance", "count"), [(1e-6, 0), (1e-9, 0), (0.0, 0), (-1e-9, 1), (-1e-6, 1)]
)
def test_a_grazing_contact(clearance, count):
    robot = sliders(1)
    ceiling = 0.5 * 3.0**2 / GRAVITY + clearance
    contact = ik.Contact("b00", normal=[0, 0, -1], origin=[0, 0, ceiling], restitution=1.0)
    motion = ik.simulate(ik.Scene(robot, contacts=[contact]), [0], [3.0], duration=0.6)
    assert len(motion.impacts) == count
    assert motion.q.max() <= ceiling + 1e-12
    if count:
        ((time, impact),) = motion.impacts
        speed = np.sqrt(2.0 * GRAVITY * -clearance)
        assert impact.v_before[0] == pytest.approx(speed, rel=1e-5)
        assert time == pytest.approx((3.0 - speed) / GRAVITY, abs=1e-9)
