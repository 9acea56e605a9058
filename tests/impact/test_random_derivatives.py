"""Derivatives of random scenes against differences of ``solve``, under every law and order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from tests.robots_with_armature import (
    IN_KERNELS,
    LEFT_TO_SOLVE,
    random_configuration,
    random_robot,
)

LAWS = [
    ik.Law(restitution=restitution, slip=slip, order=order)
    for restitution in ("newton", "poisson", "stronge")
    for slip in ("end", "path")
    for order in ("simultaneous", "sequential")
    if not (restitution == "stronge" and slip == "end")
]
# Whatever differs by more between two steps is no derivative: a mode changes within the step.
STEADY, RIGHT = 1e-5, 1e-4


def random_scene(rng, law):
    robot = random_robot(rng, ["free", *rng.choice(list(IN_KERNELS), 3)])
    one_at_a_time = law.slip == "path" and law.order == "simultaneous"
    count = 1 if one_at_a_time else int(rng.integers(1, 3))
    contacts = []
    for k in range(count):
        normal = rng.normal(size=3)
        contacts.append(
            ik.Contact(
                f"link_{rng.integers(0, 4)}",
                at=0.2 * rng.normal(size=3),
                normal=normal / np.linalg.norm(normal),
                restitution=float(rng.uniform(0.1, 0.9)),
                friction=float(rng.choice([0.0, 0.2, 1.0])),
                name=f"contact {k}",
            )
        )
    blows = [ik.AppliedImpulse("link_2", linear=rng.normal(size=3), at=[0.1, 0, 0], name="blow")]
    holds = [ik.FrameAnchor("link_1", directions=("x",))]
    return ik.Scene(
        robot,
        blows if rng.random() < 0.7 else [],
        holds if rng.random() < 0.4 else [],
        contacts,
        law=law,
    )


def parameters(scene, rng):
    """Ways to change a scene and its state: of each the change by h and the derivative by h."""
    nv = scene.robot.nv
    along = rng.normal(size=nv)
    yield (
        lambda h, q, v: (scene, q, v + h * along),
        lambda found: found.dv_after_dv @ along,
    )
    yield (
        lambda h, q, v: (scene, pin.integrate(scene.robot.model, q, h * along), v),
        lambda found: found.dv_after_dq @ along,
    )
    for entry in scene.impulses:
        turn = rng.normal(size=3)

        def struck(h, q, v, entry=entry, turn=turn):
            other = replace(entry, linear=tuple(np.array(entry.linear) + h * turn))
            return replace(scene, impulses=[other]), q, v

        yield struck, lambda found, turn=turn: found.dv_after_dimpulse["blow"][:, :3] @ turn
    for i, entry in enumerate(scene.contacts):

        def bounced(h, q, v, i=i, entry=entry):
            other = list(scene.contacts)
            other[i] = replace(entry, restitution=entry.restitution + h)
            return replace(scene, contacts=other), q, v

        yield bounced, lambda found, entry=entry: found.dv_after_drestitution.get(entry.name, 0.0)


def largest_error(scene, q, v, rng):
    """Of the derivatives that exist, relative to their size; None where they do not."""
    impact = ik.solve(scene, q, v)
    if not impact.is_valid(1e-12):
        return None
    try:
        found = ik.derivatives(impact)
    except ik.errors.InputError:
        return None
    if not found.status.exists:
        return None
    worst = 0.0
    for change, derivative in parameters(scene, rng):
        ours = derivative(found)
        both = []
        for h in (2e-6, 1e-6):
            up, down = (ik.solve(*change(s * h, q, v)).v_after for s in (1.0, -1.0))
            both.append((up - down) / (2.0 * h))
        size = max(1.0, np.abs(both[1]).max())
        if np.abs(both[0] - both[1]).max() < STEADY * size:
            worst = max(worst, float(np.abs(both[1] - ours).max()) / size)
    return worst


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.slip}-{law.order}")
@pytest.mark.parametrize(
    "count", [pytest.param(3, id="few"), pytest.param(20, id="many", marks=pytest.mark.slow)]
)
def test_what_exists_is_what_differences_give(law, count):
    rng = np.random.default_rng(count)
    judged = 0
    for _ in range(count):
        scene = random_scene(rng, law)
        q = random_configuration(scene.robot, rng)
        error = largest_error(scene, q, rng.normal(size=scene.robot.nv), rng)
        if error is not None:
            judged += 1
            assert error < RIGHT
    assert judged >= count // 3


@pytest.mark.parametrize("blow", [0.7, -0.7, -3.0])
@pytest.mark.parametrize("order", ["simultaneous", "sequential"])
def test_a_ball_that_is_struck_as_it_lands_has_two_laws_and_their_slopes(order, blow):
    """Together: v⁺ = e v⁻ (or as the blow parts it). In turn: v⁺ = −e (v⁻ + P/m)."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    mass, e, speed = ball.model.inertias[1].mass, 0.5, 1.0
    scene = ik.Scene(
        ball,
        [ik.AppliedImpulse("ball", linear=[0, 0, blow], name="blow")],
        contacts=[
            ik.Contact("ball", at=[0, 0, -0.05], normal=[0, 0, 1], restitution=e, name="floor")
        ],
        law=ik.Law(order=order),
    )
    v = ball.velocity(root_joint=[0, 0, -speed, 0, 0, 0])
    found = ik.derivatives(ik.solve(scene, ball.neutral(), v))
    thrown = -speed + blow / mass
    parted = thrown > (e * speed if order == "simultaneous" else 0.0)
    if parted:
        by_blow, by_e, by_v = 1.0 / mass, 0.0, 1.0
    elif order == "simultaneous":
        by_blow, by_e, by_v = 0.0, speed, -e
    else:
        by_blow, by_e, by_v = -e / mass, -thrown, -e
    assert found.dv_after_dimpulse["blow"][2, 2] == pytest.approx(by_blow, abs=1e-12)
    assert found.dv_after_drestitution["floor"][2] == pytest.approx(by_e, abs=1e-12)
    assert found.dv_after_dv[2, 2] == pytest.approx(by_v, abs=1e-12)


@pytest.mark.parametrize("seed", [5, 20])
@pytest.mark.parametrize("order", ["simultaneous", "sequential"])
def test_what_comes_back_of_a_load_that_may_be_shared_has_no_derivative(order, seed):
    """An interval of impulses holds a contact in compression: v⁺ is that of a rule."""
    law = ik.Law(restitution="poisson", order=order)
    rng = np.random.default_rng(seed)
    shared = 0
    for _ in range(20):
        scene = random_scene(rng, law)
        q, v = random_configuration(scene.robot, rng), rng.normal(size=scene.robot.nv)
        if not all(contact.unique for contact in ik.solve(scene, q, v).contacts):
            shared += 1
            assert not ik.derivatives(ik.solve(scene, q, v)).status.exists
        error = largest_error(scene, q, v, rng)
        assert error is None or error < RIGHT
    assert shared


@pytest.mark.parametrize("kind", [kind for kind in LEFT_TO_SOLVE if kind != "ellipsoid"])
def test_armature_of_joints_put_as_chains_counts(kind):
    """A joint of several axes is differentiated as a chain, each with its own rotor."""
    rng = np.random.default_rng(5)
    robot = random_robot(rng, ["free", kind], armature=False)
    model = pin.Model(robot.model)
    model.armature = np.linspace(0.1, 0.9, model.nv)
    robot = ik.Robot.from_model(model)
    blow = ik.AppliedImpulse("link_1", linear=[1, 2, 3], at=[0.1, 0, 0.2], name="blow")
    hold = ik.FrameAnchor("link_1", directions=("x",))
    for scene in (ik.Scene(robot, [blow]), ik.Scene(robot, [blow], [hold])):
        q = random_configuration(robot, rng)
        error = largest_error(scene, q, rng.normal(size=robot.nv), rng)
        assert error is not None and error < 1e-6


def test_armature_of_a_joint_that_others_mimic_counts_once():
    parts = [link_text(f"link_{k}", k + 1, (0.1, 0.2, 0.15), at="0.1 0.2 0.3") for k in range(3)]
    for k, mimic in ((1, ""), (2, '<mimic joint="j1" multiplier="-0.7"/>')):
        ends, axis = (f"link_{k - 1}", f"link_{k}"), (0, k - 1, 1)
        parts.append(
            joint_text(f"j{k}", "revolute", *ends, axis, at="0.3 0 0.1", far=2, more=mimic)
        )
    text = robot_text("m", *parts)
    robot = ik.Robot.from_urdf(text, mimic=True).with_armature({"j1": 0.4})
    blow = ik.AppliedImpulse("link_2", linear=[1, 2, 3], at=[0.1, 0, 0.2], name="blow")
    floor = ik.Contact("link_2", at=[0.2, 0, 0], normal=[1, 0, 0], restitution=0.4, name="floor")
    rng = np.random.default_rng(1)
    for scene in (ik.Scene(robot, [blow]), ik.Scene(robot, contacts=[floor])):
        error = largest_error(scene, robot.configuration(j1=0.3), np.ones(1), rng)
        assert error is not None and error < 1e-6
