"""Bodies with corners against closed forms and their separating axes."""

import itertools

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import brentq

import impulsekit as ik

from ...robots import one_body

CUBE = one_body("box", 1, 0.2**2 / 6.0, '<box size="0.2 0.2 0.2"/>')
FLOOR = '<robot name="floor"><link name="box"><collision><geometry><box size="9 9 0.2"/></geometry>'
FLOOR += "</collision></link></robot>"


def separation(places, half=0.1):
    """The largest gap of two cubes along an axis: negative where they overlap."""
    (first, middle), (second, other) = places
    axes = [*first.T, *second.T]
    axes += [np.cross(a, b) for a, b in itertools.product(first.T, second.T)]
    axes = [axis / np.linalg.norm(axis) for axis in axes if np.linalg.norm(axis) > 1e-9]
    reach = [half * (abs(a @ first).sum() + abs(a @ second).sum()) for a in axes]
    return max(abs(a @ (other - middle)) - r for a, r in zip(axes, reach, strict=True))


def two_cubes():
    cube = CUBE
    both = ik.combine(a=cube, b=cube)
    return ik.Scene(both, contacts=[ik.Collision("a/box", "b/box")], gravity=(0, 0, 0)), both


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_tumbling_cubes_touch_when_their_separation_is_gone(seed):
    scene, robot = two_cubes()
    rng = np.random.default_rng(seed)
    turns = [pin.exp3(rng.normal(size=3)) for _ in range(2)]
    spins, offset = rng.normal(size=(2, 3)) * 6.0, rng.uniform(-0.08, 0.08, size=3)
    # A cube turns about any axis for ever, and its middle goes straight on.
    starts = np.array([[-0.4, 0.0, 0.0], [0.4, *offset[1:]]])
    speeds = np.array([[1.0, 0.1, 0.0], [-1.0, 0.0, 0.1]])
    q, v = robot.configuration(), []
    for k in range(2):
        q[7 * k : 7 * k + 3] = starts[k]
        q[7 * k + 3 : 7 * k + 7] = pin.Quaternion(turns[k]).coeffs()
        v += [*turns[k].T.dot(speeds[k]), *turns[k].T.dot(spins[k])]
    motion = ik.simulate(scene, q, np.array(v), 0.5)

    def apart(t):
        return separation(
            [(pin.exp3(t * spins[k]) @ turns[k], starts[k] + t * speeds[k]) for k in range(2)]
        )

    times = np.linspace(0.0, 0.5, 2001)
    gaps = np.array([apart(t) for t in times])
    first = int(np.flatnonzero(gaps < 0.0)[0])
    exact = brentq(apart, times[first - 1], times[first], xtol=1e-14)
    assert motion.impacts[0][0] == pytest.approx(exact, abs=1e-9)
