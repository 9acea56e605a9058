"""Contact points that vary by row, against a scene of its own for each row."""

from dataclasses import replace

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, RangeError, ShapeError, UnknownNameError

OUTPUTS = ("v_after", "contact_impulses", "energy_change")


def planar_scene(law):
    """A ball in the plane whose point may be anywhere."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="planar")
    tip = ik.Contact("ball", normal=[0, 1, 0], restitution=0.5, friction=0.3, name="tip")
    return ik.Scene(ball, contacts=[tip], law=law)


def test_a_rod_struck_at_its_end_and_at_its_middle():
    # e = 1 at r from the mass centre: P = 2 m u / (1 + r²/k²), k² = I/m.
    scene = planar_scene(ik.Law())
    free = replace(scene, contacts=[replace(scene.contacts[0], restitution=1.0, friction=0.0)])
    inertia = scene.robot.model.inertias[1]
    square = inertia.inertia[2, 2] / inertia.mass
    at = np.array([[0.0, 0, 0], [0.03, 0, 0], [-0.05, 0, 0]])
    batch = ik.solve_batch(
        free, scene.robot.neutral(), [0, -1.0, 0], points={"tip": at}, outputs=OUTPUTS
    )
    found = batch.contact_impulses[:, 0, 1]
    assert found == pytest.approx(2 * inertia.mass / (1 + at[:, 0] ** 2 / square), rel=1e-13)


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
