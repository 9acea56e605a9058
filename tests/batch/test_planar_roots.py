"""Bodies that move in a plane and rub on a line: in the kernels, by the textbook's two modes."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik

from ..robots import one_body

MASS, MOMENT, ARM = 0.0485, 2.9e-5, np.array([0.01, -0.04])


def right(v, e, mu):
    """(3,) v⁺ of a plate: it sticks where |P_t| ≤ µ P_n then, else it slides on as it slid."""
    rows = np.array([[1.0, 0.0, -ARM[1]], [0.0, 1.0, ARM[0]]])
    inverse = np.diag([1.0 / MASS, 1.0 / MASS, 1.0 / MOMENT])
    W = rows @ inverse @ rows.T
    u = rows @ v
    b = np.array([u[0], (1.0 + e) * u[1]])
    if u[1] >= 0.0:
        return v
    sticking = -np.linalg.solve(W, b)
    if abs(sticking[0]) <= mu * sticking[1]:
        return v + inverse @ rows.T @ sticking
    for s in (1.0, -1.0):
        pressed = -b[1] / (W[1, 1] - mu * s * W[0, 1])
        impulse = np.array([-mu * s * pressed, pressed])
        if pressed > 0.0 and s * (b[0] + W[0] @ impulse) > 0.0:
            return v + inverse @ rows.T @ impulse
    raise AssertionError("no mode")


@pytest.mark.parametrize("by_row", [False, True])
def test_planar_roots_with_friction_stay_in_the_kernels(by_row):
    robot = one_body("b", MASS, MOMENT, root="planar")
    rng = np.random.default_rng(0)
    v = np.c_[rng.normal(size=64), -1.0 - rng.random(64), 10.0 * rng.normal(size=64)]
    e, mu = (rng.uniform(0, 1, 64), rng.uniform(0.05, 0.6, 64)) if by_row else (0.4, 0.12)
    contact = ik.Contact("b", at=[*ARM, 0], normal=[0, 1, 0], restitution=0.4, friction=0.12)
    given = {"restitution": e[:, None], "friction": mu[:, None]} if by_row else {}
    batch = ik.solve_batch(ik.Scene(robot, contacts=[contact]), robot.neutral(), v, **given)
    truth = [right(*row) for row in zip(v, *np.broadcast_arrays(e, mu, v[:, 0])[:2], strict=True)]
    live = batch.valid
    assert live.sum() > 48
    np.testing.assert_allclose(batch.v_after[live], np.array(truth)[live], atol=1e-11)
