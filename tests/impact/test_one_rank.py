"""Answers, their derivatives and what may be added to them decide alike on dependent rows.

Two pins of one point are one pin; written 1e-10 m apart they are it to all that
asks. What is true is the scene with one pin.
"""

import pathlib
import warnings

import numpy as np
import pytest

import impulsekit as ik

MODELS = pathlib.Path(__file__).parents[2] / "models"
PINNED = np.array([0.0, 0.0, 0.05])
# The two pins are so far apart [m].
APART = 1e-10


@pytest.fixture(scope="module")
def ball():
    return ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")


def impact_of(ball, pins, law, points):
    """A ball on a pin that turns into contacts; it moves as the pin lets it."""
    rng = np.random.default_rng(2)
    turning = rng.normal(size=3)
    contacts = []
    for _ in range(points):
        at = np.array([*rng.uniform(-0.03, 0.03, 2), 0.0])
        normal = np.cross(at - PINNED, rng.normal(size=3))
        approach = normal @ np.cross(turning, at - PINNED)
        normal *= -np.sign(approach) / np.linalg.norm(normal)
        contacts.append(ik.Contact("ball", at=at, normal=normal, friction=0.2, restitution=0.4))
    scene = ik.Scene(
        ball,
        constraints=[ik.PointAnchor("ball", at=(apart, 0.0, 0.05)) for apart in pins],
        contacts=contacts,
        law=ik.Law(**law),
    )
    v = ball.velocity(root_joint=[*-np.cross(turning, PINNED), *turning])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ik.solve(scene, ball.neutral(), v)


@pytest.mark.parametrize(
    ("law", "points"),
    [({"slip": "path"}, 1), ({"order": "sequential"}, 2)],
)
def test_derivatives_hit_by_hit_take_two_pins_of_one_point_for_one(ball, law, points):
    once, twice = (impact_of(ball, pins, law, points) for pins in ([0.0], [0.0, APART]))
    np.testing.assert_allclose(twice.v_after, once.v_after, atol=1e-6)
    true, found = (ik.derivatives(impact).dv_after_dv for impact in (once, twice))
    assert np.abs(true).max() > 0.1
    np.testing.assert_allclose(found, true, atol=1e-5)


def test_what_is_searched_beside_an_answer_is_free_where_the_answer_is(ball):
    once, twice = (impact_of(ball, pins, {}, 2) for pins in ([0.0], [0.0, APART]))
    jacobian = np.vstack([touch.jacobian for touch in once.outcome.touches])
    true = once.mechanics.responses(jacobian).delassus
    found = twice.mechanics.responses(jacobian).delassus
    # By hand: of a pinned ball W is J I⁻¹ Jᵀ, with the inertia about the pin.
    body = ball.model.inertias[1]
    arm = body.lever - PINNED
    about = body.inertia + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    turns = jacobian[:, 3:] - np.cross(PINNED, jacobian[:, :3])
    np.testing.assert_allclose(true, turns @ np.linalg.solve(about, turns.T), atol=1e-12)
    np.testing.assert_allclose(found, true, atol=1e-5 * np.abs(true).max())


def test_slip_along_a_lever_that_is_held_is_rounding(ball):
    """Followed along the path it would never end."""
    contact = ik.Contact("ball", at=[0, 0.05, 0], normal=[0, 1, 1], friction=0.3, restitution=0.4)
    law = ik.Law(slip="path", restitution="stronge")
    scene = ik.Scene(
        ball, constraints=[ik.PointAnchor("ball", at=PINNED)], contacts=[contact], law=law
    )
    v = ball.velocity(root_joint=[0, 0, 0, -2.0, 0.3, 0.1])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        impact = ik.solve(scene, ball.neutral(), v)
    assert ik.derivatives(impact).status.exists
