"""Blocks of impacts in optimal control against differences and against Pinocchio."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.control import ImpactBlocks, ImpactCost
from impulsekit.errors import InputError, RangeError, ShapeError, UnknownNameError
from impulsekit.impact.derivatives import DerivativeStatus
from impulsekit.models import pendulum_urdf

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")

ROBOTS = {
    "solo12": ("freeflyer", ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")),
    "talos": ("freeflyer", ("left_sole_link", "right_sole_link", "gripper_left_base_link")),
    "panda": ("fixed", ("panda_hand", "panda_link4")),
}
LAWS = {
    "newton": ik.Law(),
    "poisson": ik.Law("poisson"),
    "stronge": ik.Law("stronge", "path", "sequential"),
}
COSTS = [
    ImpactCost("contact_impulses", 0.3, 0.1),
    ImpactCost("joint_loads", 0.02),
    ImpactCost("v_after"),
]


def scene_of(name, law=None, **changes):
    root, frames = ROBOTS[name]
    robot = ik.Robot.from_example(name, root=root)
    contacts = [
        ik.Contact(
            frame,
            at=[0.02 * i, 0.01, -0.03],
            normal=[0.1 * i, 0.2, 1],
            friction=(0.3, 0.8)[i % 2],
            restitution=(0.5, 0.2, 0.6, 0.3)[i],
        )
        for i, frame in enumerate(frames)
    ]
    return ik.Scene(robot, contacts=contacts, law=law or ik.Law(), **changes)


def states(robot, count, seed=0):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = pin.integrate(robot.model, robot.neutral(), rng.uniform(-1, 1, robot.nv))
        v = rng.normal(size=robot.nv)
        if robot.nq > robot.nv:
            v[:3] += pin.Quaternion(q[3:7]).matrix().T @ [0, 0, -1.5]
        yield q, v


def differences(scene, q, v, step=1e-4):
    """∂(v⁺, P)/∂(q, v) by Richardson's extrapolation, and how far two steps differ."""
    robot, moves = scene.robot, [k * s for k in (0.5, 1.0, 2.0) for s in (step, -step)]
    near = [
        (pin.integrate(robot.model, q, h * e[: robot.nv]), v + h * e[robot.nv :])
        for e in np.eye(2 * robot.nv)
        for h in moves
    ]
    Q, V = (np.array(each) for each in zip(*near, strict=True))
    found = ik.solve_batch(scene, Q, V, outputs=("v_after", "contact_impulses"))
    ends = np.hstack([found.v_after, found.contact_impulses.reshape(len(Q), -1)])
    ends = ends.reshape(2 * robot.nv, 3, 2, -1)
    slopes = (ends[:, :, 0] - ends[:, :, 1]) / (2 * step * np.array([0.5, 1, 2])[:, None])
    fine, coarse = ((4 * slopes[:, i] - slopes[:, i + 1]) / 3 for i in (0, 1))
    return fine.T, np.abs(fine - coarse).max()


def compare(name, law, count):
    """Blocks of many states against differences that have settled."""
    scene = scene_of(name, LAWS[law])
    blocks = ImpactBlocks(scene, ImpactCost("contact_impulses"))
    nv, modes, compared = scene.robot.nv, Counter(), 0
    for q, v in states(scene.robot, count):
        try:
            step = blocks.calc([*q, *v])
        except InputError as error:
            # Newton's law may gain energy with friction, which is no valid impact.
            assert "ENERGY_GAIN" in str(error)
            count -= 1
            continue
        try:
            found = blocks.calc_diff(step)
        except InputError as error:
            assert "Painlevé" in str(error)
            continue
        truth, unsettled = differences(scene, q, v)
        size = max(1.0, np.abs(truth).max())
        # What has no derivative within a step of 2e-4 is a corner.
        if found.status.exists and unsettled < 3e-8 * size:
            ours = np.vstack([found.fx[nv:], found.outputs["contact_impulses"]])
            assert np.abs(ours - truth).max() <= 1e-7 * size
            modes.update(contact.mode for contact in step.impact.contacts)
            compared += 1
    assert compared > 0.95 * count
    return modes


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ROBOTS)
def test_blocks_are_those_of_differences(name, law):
    compare(name, law, 12)


@pytest.mark.sweep
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ROBOTS)
def test_blocks_of_a_thousand_states_are_those_of_differences(name, law):
    modes = compare(name, law, 334)
    assert len(modes) >= 3, modes


@pytest.mark.parametrize("name", ROBOTS)
def test_costs_on_impulses_and_joint_loads(name):
    scene = scene_of(name)
    blocks, robot = ImpactBlocks(scene, COSTS), scene.robot
    q, v = next(states(robot, 1, 3))
    found = blocks.calc_diff(blocks.calc([*q, *v]))

    def near(move):
        return blocks.calc(
            [*pin.integrate(robot.model, q, move[: robot.nv]), *(v + move[robot.nv :])]
        )

    def slope(value):
        columns = []
        for e in np.eye(2 * robot.nv):
            pairs = [(value(near(h * e)) - value(near(-h * e))) / (2 * h) for h in (1e-4, 2e-4)]
            columns.append((4 * pairs[0] - pairs[1]) / 3)
        return np.array(columns).T

    for cost in COSTS:
        truth = slope(lambda step, of=cost.output: step.outputs[of])
        bar = 1e-8 * max(1.0, np.abs(truth).max())
        np.testing.assert_allclose(found.outputs[cost.output], truth, rtol=0, atol=bar)
    truth = slope(lambda step: step.cost)
    np.testing.assert_allclose(found.lx, truth, rtol=0, atol=1e-8 * np.abs(truth).max())
    tables = [(cost.weight, found.outputs[cost.output]) for cost in COSTS]
    hessian = sum(w * table.T @ table for w, table in tables)
    np.testing.assert_allclose(found.lxx, hessian, rtol=0, atol=1e-12 * np.abs(hessian).max())


def test_feet_held_without_restitution_are_pinocchios_impulse_dynamics():
    feet = ROBOTS["solo12"][1]
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    held = [ik.PointAnchor(foot, name=foot) for foot in feet]
    blocks, model, nv = ImpactBlocks(ik.Scene(solo, constraints=held)), solo.model, solo.nv
    models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    for foot in feet:
        frame = model.frames[model.getFrameId(foot)]
        place = frame.parentJoint, frame.placement, pin.LOCAL_WORLD_ALIGNED
        models.append(pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, *place))
        datas.append(models[-1].createData())
    for q, v in states(solo, 10, 5):
        data = model.createData()
        pin.initConstraintDynamics(model, data, models, datas)
        settings = pin.ProximalSettings(1e-14, 1e-14, 0.0, 1)
        after = pin.impulseDynamics(model, data, q, v, models, datas, 0.0, settings)
        pin.computeImpulseDynamicsDerivatives(model, data, models, datas, 0.0, settings)
        step = blocks.calc([*q, *v])
        fx, found = blocks.calc_diff(step).fx, ik.derivatives(step.impact)
        scale = np.abs(fx).max()
        assert np.abs(step.x_after[solo.nq :] - after).max() < 1e-10
        assert np.abs(fx[nv:, :nv] - data.ddq_dq).max() < 1e-10 * scale
        # Pinocchio's derivative by v is that of the jump.
        assert np.abs(fx[nv:, nv:] - data.ddq_dv - np.eye(nv)).max() < 1e-10 * scale
        for by, truth in (("q", data.dlambda_dq), ("v", data.dlambda_dv)):
            ours = np.concatenate([found[foot, by] for foot in feet])
            assert np.abs(ours - truth).max() < 1e-10 * max(1.0, np.abs(truth).max())


def test_the_impulse_of_a_joint_stop_is_one_number():
    arm = ik.Robot.from_urdf(pendulum_urdf(1))
    scene = ik.Scene(arm, contacts=[ik.JointStop("joint_1", lower=-1, upper=1, restitution=0.5)])
    blocks = ImpactBlocks(scene, ImpactCost("contact_impulses"))
    step = blocks.calc([1.0, 2.0])
    inertia = float(step.impact.mass_matrix[0, 0])
    np.testing.assert_allclose(step.outputs["contact_impulses"], [-3.0 * inertia, 0, 0])
    np.testing.assert_allclose(step.cost, 4.5 * inertia**2)
    table = blocks.calc_diff(step).outputs["contact_impulses"]
    np.testing.assert_allclose(table, [[0, -1.5 * inertia], [0, 0], [0, 0]], atol=1e-15)


def test_a_mode_edge_is_counted():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    blocks = ImpactBlocks(ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.5)]))
    found = blocks.calc_diff(blocks.calc([*ball.neutral(), *np.zeros(6)]))
    assert found.status is DerivativeStatus.MODE_EDGE and np.isfinite(found.fx).all()
    assert blocks.statuses == {DerivativeStatus.MODE_EDGE: 1}


def test_bad_input_is_one_sentence_each():
    scene = scene_of("panda")
    with pytest.raises(InputError, match="the scene has no contacts and no constraints"):
        ImpactBlocks(ik.Scene(scene.robot))
    with pytest.raises(UnknownNameError, match='did you mean "joint_loads"'):
        ImpactCost("joint_load")
    with pytest.raises(RangeError, match=r"weight must be 0 or more, got -1\.0"):
        ImpactCost("v_after", -1)
    with pytest.raises(InputError, match="each must be an ImpactCost, got str"):
        ImpactBlocks(scene, ["v_after"])
    with pytest.raises(ShapeError, match=r'reference of the cost on "v_after": expected shape'):
        ImpactBlocks(scene, ImpactCost("v_after", 1.0, [1.0, 2.0]))
    with pytest.raises(ShapeError, match=r"x: expected shape \(18,\), got \(9,\)"):
        ImpactBlocks(scene).calc(scene.robot.neutral())
