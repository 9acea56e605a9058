"""Quaternions in the other order and lengths in mm are refused, not followed in silence."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import InputError
from impulsekit.measured import Recording, calibrate, find_impacts
from tests.measured.bodies import ball_scene, bouncing_ball

SCENE = ik.load_scene("examples/cube_tosses.toml").scene
TOSSES = [
    Recording(each.robot, each.t, each.q, name=each.name)
    for each in ik.measured.load_recordings("examples/cube_tosses.npz", SCENE.robot)[:6]
]


@pytest.mark.parametrize("ask", [calibrate, find_impacts])
@pytest.mark.parametrize("order", [(3, 0, 1, 2), (1, 2, 3, 0)], ids=["w first", "w last"])
def test_quaternions_in_the_other_order_are_told_by_the_floor(ask, order):
    wrong = []
    for each in TOSSES:
        q = each.q.copy()
        q[:, 3:7] = q[:, 3:7][:, list(order)]
        wrong.append(replace(each, q=q))
    with pytest.raises(InputError, match=f"{ask.__name__}: .*the other one, xyzw or wxyz"):
        ask(wrong, SCENE)


def test_velocities_given_to_a_recording_tell_the_order_too():
    scene = ik.Scene(SCENE.robot, gravity=SCENE.gravity)
    t = np.arange(40) / 200
    q, v = np.zeros((40, 7)), np.zeros((40, 6))
    q[:, 3], q[:, 6], v[:, 3] = np.sin(3 * t), np.cos(3 * t), 6.0
    q[:, :3] = [0.0, 0.0, 1.0]
    q[:, 2] -= 0.5 * 9.81 * t**2
    turned = pin.exp3(np.array([0.4, 1.1, -0.7]))
    for k, row in enumerate(q):
        axes = turned @ pin.Quaternion(row[3:].copy()).matrix()
        row[3:], v[k, :3] = pin.Quaternion(axes).coeffs(), axes.T @ [0.0, 0.0, -9.81 * t[k]]
    right = Recording(SCENE.robot, t, q, v=v)
    assert not find_impacts(right, scene, sigma=1e-4).impacts
    wrong = replace(right, q=q[:, [0, 1, 2, 4, 5, 6, 3]])
    with pytest.raises(InputError, match=r"find_impacts: .*the other one, xyzw or wxyz"):
        find_impacts(wrong, scene, sigma=1e-4)


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "mm"), (1e2, "cm")])
def test_lengths_in_another_unit_are_told_by_free_fall(factor, unit):
    scene = ball_scene()
    recording, _ = bouncing_ball(scene, 0.5, 0.6, 200, 0.8)
    q = recording.q.copy()
    q[:, :3] *= factor
    with pytest.raises(InputError, match=f'find_impacts: bodies fall.*length="{unit}"'):
        find_impacts(replace(recording, q=q), scene, sigma=1e-4)
    assert find_impacts(recording, scene, sigma=np.full(6, 1e-4)).impacts
