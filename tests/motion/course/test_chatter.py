"""Bounces that accumulate, and hops too low to be told from rest, end in rest after few impacts."""

import numpy as np
import pytest

import impulsekit as ik

from ...robots import one_body
from ..models import GRAVITY, MODELS


@pytest.mark.parametrize("place", [0.0, 100.0, 1e4])
@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_a_ball_comes_to_rest_wherever_the_floor_is(place, restitution):
    ball = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    up = np.array([1.0, 2.0, 2.0]) / 3.0
    origin = place * np.array([1.0, -1.0, 1.0])
    floor = ik.Contact("ball", normal=up, origin=origin, restitution=restitution)
    q = ball.configuration(root_joint=[*(origin + up), 0, 0, 0, 1])
    scene = ik.Scene(ball, contacts=[floor], gravity=-GRAVITY * up)
    # The fall, and the geometric series of the bounces.
    fall = np.sqrt(2.0 / GRAVITY)
    lies = fall * (1.0 + 2.0 * restitution / (1.0 - restitution))
    motion = ik.simulate(scene, q, ball.velocity(), duration=lies + 1.0, samples=2, accuracy="high")
    assert motion.status.finished, motion.detail
    (rest,) = motion.rests
    # Hops within the rounding of the gap are not followed.
    hop = np.sqrt(2.0 * GRAVITY * 1e-14 * max(place, 1.0))
    assert abs(rest.start - lies) < 2e-6 + 2.0 * hop / GRAVITY / (1.0 - restitution)
    assert rest.end == np.inf
    assert len(motion.impacts) < 2 + np.log(fall * GRAVITY / 1e-7) / -np.log(restitution)


@pytest.mark.slow
def test_an_edge_whose_ends_lift_each_other_in_turn_comes_to_rest():
    """Without an end to it this took 6191 impacts of 2e-5 m/s in 0.1 s."""
    half = np.array([0.36, 0.294, 0.357])
    moments = [float(half @ half - x * x) / 3.0 for x in half]
    size = " ".join(repr(float(2 * x)) for x in half)
    box = one_body("b", 1, moments, f'<box size="{size}"/>')
    world = ik.combine(a=box, f=ik.Robot.from_urdf(MODELS / "floor.urdf"))
    pair = ik.Collision("a/b", "f/floor", restitution=0.0, friction=1.0)
    scene = ik.Scene(world, contacts=[pair], law=ik.Law("poisson"))
    turn = np.array([-0.12544, 0.23631, -0.46802, 0.84225])
    q = np.r_[0, 0, 1.55893, turn / np.linalg.norm(turn)]
    v = np.array([-0.49119, 1.1013, 0.33634, 4.56639, -4.41573, 3.12167])
    motion = ik.simulate(scene, q, v, duration=2.5, max_impacts=300, accuracy="high")
    assert motion.status.finished
    assert np.abs(motion.v[-1]).max() < 1e-10
    assert np.diff(motion.energy().total).max() < 1e-9
