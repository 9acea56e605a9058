"""Contact points that vary by row, against a scene of its own for each row."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, RangeError, ShapeError, UnknownNameError


def planar_scene(law):
    """A ball in the plane whose point may be anywhere."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="planar")
    tip = ik.Contact("ball", normal=[0, 1, 0], restitution=0.5, friction=0.3, name="tip")
    return ik.Scene(ball, contacts=[tip], law=law)


def test_what_is_given_wrongly_is_said():
    scene = planar_scene(ik.Law())
    q, v = scene.robot.neutral(), np.tile([0, -1.0, 0], (2, 1))
    with pytest.raises(UnknownNameError, match="foot"):
        ik.solve_batch(scene, q, v, points={"foot": [0, 0, 0]})
    with pytest.raises(ShapeError, match="tip"):
        ik.solve_batch(scene, q, v, points={"tip": [0, 0]})
    with pytest.raises(ShapeError, match="leading axes"):
        ik.solve_batch(scene, q, v, points={"tip": np.zeros((3, 3))})
    with pytest.raises(InputError, match="mapping"):
        ik.solve_batch(scene, q, v, points=[0, 0, 0])
    with pytest.raises(RangeError, match="points"):
        ik.solve_batch(scene, q, v, points={"tip": [np.nan, 0, 0]})
    batch = ik.solve_batch(scene, q, v, points={"tip": [[0.0, 0, 0], [np.nan, 0, 0]]})
    assert batch.valid.tolist() == [True, False]
    assert np.isfinite(batch.v_after[0]).all() and np.isnan(batch.v_after[1]).all()
