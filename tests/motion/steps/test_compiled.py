"""The compiled tree, forces and steps against Pinocchio, scipy and closed forms; interpreted."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import DOP853

import impulsekit as ik
from impulsekit.bench.urdf import joint_text, link_text, robot_text
from impulsekit.motion.events import look as looking
from impulsekit.motion.flight import headway, stepper, strides
from impulsekit.motion.steps.compiled import attempt
from impulsekit.motion.travel import advance, journey, meet, mover
from impulsekit.motion.tree import bodies
from impulsekit.motion.tree.chart import Chart
from impulsekit.motion.tree.coordinates import write_configuration, write_rate
from impulsekit.motion.tree.memory import Memory
from impulsekit.motion.tree.of_model import room_of, tree_of

BOX = """<robot name="box"><link name="box"><inertial><mass value="2"/>
<inertia ixx=".02" iyy=".03" izz=".04" ixy=".001" ixz="0" iyz=".002"/></inertial></link></robot>"""


class Interpreted:
    """An entry whose code runs as Python, as if it were compiled."""

    is_compiled = True

    def __init__(self, entry):
        self.entry, self.calls = entry, 0

    def load(self):
        pass

    def wait(self, seconds):
        pass

    def __call__(self, *args):
        self.calls += 1
        with np.errstate(all="ignore"):
            return self.entry.py_func(*args)


@pytest.fixture
def stepped(monkeypatch):
    """Motions make their steps by the code that is compiled elsewhere."""
    step, look = Interpreted(attempt), Interpreted(looking.look)
    monkeypatch.setattr(stepper.CompiledStepper, "code", step)
    monkeypatch.setattr(stepper, "look", look)
    for name in ("begin_steps", "settle_points", "strike_point"):
        entry = Interpreted(getattr(mover, name))
        monkeypatch.setattr(mover, name, entry)
    for name in ("advance", "attempt", "begin_steps"):
        monkeypatch.setattr(journey, name, Interpreted(getattr(journey, name)))
    for name in ("settle_points", "accelerations_at"):
        monkeypatch.setattr(meet, name, Interpreted(getattr(meet, name)))
    stride = Interpreted(strides.travel)
    monkeypatch.setattr(strides, "travel", stride)
    return step, stride


def model_of_all_joints():
    """A tree with every kind of joint that compiled code knows, and armature."""
    model, rng = pin.Model(), np.random.default_rng(5)
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    joints = [
        pin.JointModelFreeFlyer(),
        pin.JointModelRX(),
        pin.JointModelRevoluteUnaligned(axis),
        pin.JointModelRUBZ(),
        pin.JointModelPY(),
        pin.JointModelPrismaticUnaligned(axis),
        pin.JointModelSpherical(),
        pin.JointModelPlanar(),
        pin.JointModelTranslation(),
    ]
    # Pinocchio wants every branch in one piece.
    for i, (parent, joint) in enumerate(zip((0, 1, 2, 3, 3, 5, 6, 0, 8), joints, strict=True)):
        place = pin.SE3(pin.SE3.Random().rotation, rng.normal(size=3))
        own = model.addJoint(parent, joint, place, f"joint{i}")
        body = pin.Inertia(rng.uniform(0.5, 2.0), rng.normal(size=3) / 5.0, np.eye(3) / 10.0)
        model.appendBodyToJoint(own, body, pin.SE3.Identity())
    model.armature = rng.uniform(0.0, 0.1, model.nv)
    model.gravity.linear = np.array([0.5, -1.0, -9.0])
    return model


def random_state(model, seed):
    rng = np.random.default_rng(seed)
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    return q, rng.normal(size=model.nv)


@pytest.mark.parametrize("seed", range(3))
def test_tree_against_pinocchio(seed):
    model = model_of_all_joints()
    q, v = random_state(model, seed)
    own, room, shown = tree_of(model), room_of(model), Memory(model)
    load = np.zeros(model.nv)
    bodies.look_at(own, room, q, v)
    bodies.write_jacobian(own, room)
    bodies.write_factor(own, room)
    bodies.begin_forces(own, room)
    bodies.take_forces(own, room, load)
    pin.forwardKinematics(model, shown.data, q, v, np.zeros(model.nv))
    pin.computeJointJacobians(model, shown.data)
    pin.crba(model, shown.data, q)
    pin.cholesky.decompose(model, shown.data)
    kinematics = room.kinematics
    for found, right in (
        (kinematics.places, shown.places),
        (kinematics.speeds, shown.speeds),
        (kinematics.rates, shown.rates),
        (kinematics.jacobian, shown.jacobian),
        (room.factor.pivots, shown.pivots),
        (np.tril(room.factor.factor, -1), np.tril(shown.factor, -1)),
        (-load, pin.nonLinearEffects(model, shown.data, q, v)),
    ):
        np.testing.assert_allclose(found[1:], right[1:], atol=3e-14 * np.abs(right).max())


@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.3, 0.4, 2.5])
def test_chart_against_pinocchio_and_differences(size):
    model = model_of_all_joints()
    q, v = random_state(model, 7)
    chart, own = Chart(model), tree_of(model)
    start = chart.centred(q)
    x = start + size * np.random.default_rng(1).uniform(-1.0, 1.0, model.nv) / np.sqrt(3.0)
    found, rate = np.zeros(model.nq), np.zeros(model.nv)
    write_configuration(own, chart.reference, x, found)
    right = pin.integrate(model, chart.reference, x)
    for joint in model.joints:
        if joint.shortname() == "JointModelPlanar":
            # Its place is in the world's axes, not in its own.
            at, angle = joint.idx_q, x[joint.idx_v + 2]
            right[at : at + 4] = *x[joint.idx_v : joint.idx_v + 2], np.cos(angle), np.sin(angle)
    np.testing.assert_allclose(found, right, atol=1e-14 * (1.0 + size))
    write_rate(own, x, found, v, rate)
    h, ends = 1e-5, np.zeros((2, model.nq))
    for end, sign in zip(ends, (1.0, -1.0), strict=True):
        write_configuration(own, chart.reference, x + sign * h * rate, end)
    moved = pin.difference(model, ends[1], ends[0]) / (2.0 * h)
    np.testing.assert_allclose(moved, v, atol=2e-8 * (1.0 + size**2))


def forced_scene():
    box = ik.Robot.from_urdf(BOX, root="freeflyer")
    both = ik.combine(box=box, arm=ik.Robot.from_urdf("models/double_pendulum.urdf"))
    shoulder, elbow = [name for name in both.joint_names if name.startswith("arm/")]
    forces = [
        ik.AppliedForce("box/box", linear=lambda t: (8 * np.cos(9 * t), 0, 1), at=[0.1, 0, 0]),
        ik.AppliedForce("box/box", linear=[1, 2, 3], angular=[0.1, 0, 0.2], axes="local"),
        ik.Spring("box/box", at=[0.1, 0.2, 0], other_at=[0, 0, 2], stiffness=50, damping=1),
        ik.Spring("box/box", at=[0, 0.2, 0], stiffness=90, rest_length=0.5),
        ik.JointSpring(shoulder, stiffness=3, damping=0.1, rest=0.2),
        ik.JointSpring(elbow, stiffness=80, damping=0.5, rest=0.1),
        ik.Actuator(shoulder, ik.PD(stiffness=5, damping=0.3, target=1, velocity=2, limit=1.5)),
        ik.Actuator(elbow, ik.TorqueTable([0, 0.1, 0.3], [0, 1, -1])),
        ik.Actuator(shoulder, 0.2),
    ]
    return ik.Scene(both, forces=forces)


@pytest.mark.slow
def test_all_forces_against_scipy(stepped):
    """The motion under all kinds of forces, against the dynamics of Pinocchio and scipy's loop."""
    scene = forced_scene()
    q, v = random_state(scene.robot.model, 3)
    settings = {"rtol": 1e-12, "atol": 1e-13}
    motion = ik.simulate(scene, q, v, duration=0.25, **settings)
    assert motion.status is ik.MotionStatus.FINISHED and stepped[0].calls > 3
    flow = PlainMotion(scene, q)
    # Steps end where the table has a corner, and no piece turns by half a turn.
    for start, end in pairwise(np.linspace(0.0, 0.25, 11).tolist()):
        flow.advance(start, end, v0=v if start == 0.0 else None)
    q_end, v_end = flow.state()
    np.testing.assert_allclose(motion.v[-1], v_end, atol=3e-10)
    np.testing.assert_allclose(
        pin.difference(scene.robot.model, motion.q[-1], q_end), 0, atol=1e-10
    )


class PlainMotion:
    """scipy's DOP853 on Pinocchio's accelerations, in Pinocchio's own tangent space."""

    def __init__(self, scene, q):
        from impulsekit.motion.dynamics.accelerations import Dynamics

        self.dynamics, self.q, self.model = Dynamics(scene), q, scene.robot.model

    def advance(self, start, end, v0=None):
        self.v = self.v if v0 is None else v0
        nv, reference, model = self.model.nv, self.q, self.model

        def rates(t, y):
            q = pin.integrate(model, reference, y[:nv])
            turn = pin.dDifference(model, reference, q, pin.ArgumentPosition.ARG1)
            return np.concatenate([turn @ y[nv:], self.dynamics.acceleration(t, q, y[nv:])])

        y = np.concatenate([np.zeros(nv), self.v])
        solver = DOP853(rates, start, y, end, rtol=1e-12, atol=1e-13)
        while solver.status == "running":
            solver.step()
        self.q, self.v = pin.integrate(model, reference, solver.y[:nv]), solver.y[nv:]

    def state(self):
        return self.q, self.v


def test_ball_bounces_as_in_closed_form(stepped):
    """Impacts of a ball at the times of the closed form, found within compiled steps."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    floor = ik.Contact("ball", normal=[0, 0, 1], restitution=0.5)
    drop = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    motion = ik.simulate(ik.Scene(ball, contacts=[floor]), drop, ball.velocity(), duration=1.2)
    first = np.sqrt(2.0 / 9.81)
    times = first + 2.0 * first * np.cumsum([0.0, 0.5, 0.25, 0.125])
    seen = [t for t, _ in motion.impacts]
    np.testing.assert_allclose(seen[:3], times[:3], atol=1e-12)
    assert stepped[1].calls


def test_sliding_block_stops_and_sticks_as_in_closed_form(stepped):
    """v²/2µg, found by steps with resting points whose events are compiled."""
    box = ik.Robot.from_urdf(BOX, root="freeflyer")
    corners = [
        ik.Contact("box", at=[x, y, -0.1], friction=0.5) for x in (-0.2, 0.2) for y in (-0.2, 0.2)
    ]
    q = box.configuration(root_joint=[0, 0, 0.1, 0, 0, 0, 1])
    v = box.velocity(root_joint=[1.0, 0, 0, 0, 0, 0])
    motion = ik.simulate(ik.Scene(box, contacts=corners), q, v, duration=0.3)
    assert motion.status is ik.MotionStatus.FINISHED and stepped[1].calls
    np.testing.assert_allclose(motion.q[-1][0], 0.5 / (0.5 * 9.81), atol=1e-9)
    np.testing.assert_allclose(motion.v[-1], 0.0, atol=1e-9)


@pytest.mark.slow
def test_a_tumbling_box_moves_as_step_by_step(stepped):
    """Tumbling, sliding and settling made many steps at once, against steps one by one."""
    box = ik.Robot.from_urdf(BOX, root="freeflyer")
    corners = [
        ik.Contact("box", at=[x, 0.1, z], friction=0.3, restitution=0.1)
        for x in (-0.2, 0.2)
        for z in (-0.1, 0.1)
    ]
    scene = ik.Scene(box, contacts=[*corners, ik.Contact("box", at=[0, -0.1, -0.1], friction=0.3)])
    q = box.configuration(root_joint=[0, 0, 0.25, 0.2, 0, 0, np.sqrt(0.96)])
    v = box.velocity(root_joint=[0.5, 0, 0, 0, 2.0, 0])
    motion = ik.simulate(scene, q, v, duration=0.35, samples=8)
    assert motion.status.finished and len(motion.impacts) >= 2 and motion.rests
    # Impacts of several points and what comes to rest are in few calls.
    assert 0 < stepped[1].calls <= 3
    # Asked for after every step it is the same to the last bit.
    told = ik.simulate(scene, q, v, duration=0.35, samples=8, progress=lambda t: None)
    assert np.array_equal(told.q, motion.q) and np.array_equal(told.v, motion.v)
    # scipy's own loop knows nothing of compiled steps.
    other = ik.simulate(scene, q, v, duration=0.35, samples=8, method="radau", rtol=1e-9)
    np.testing.assert_allclose(motion.q, other.q, atol=1e-6)
    for ours, theirs in zip(motion.impacts, other.impacts, strict=True):
        assert abs(ours[0] - theirs[0]) < 1e-6
    for _, impact in motion.impacts:
        assert impact.is_valid()


@pytest.mark.slow
def test_impacts_in_compiled_code_are_those_of_python(stepped, monkeypatch):
    """A box that falls on an edge and then its sole, with everything that is told of impacts."""
    box = ik.Robot.from_urdf(BOX, root="freeflyer")
    sides = (-0.2, 0.2)
    corners = [
        ik.Contact("box", at=[x, y, z], friction=0.3, restitution=0.3, name=f"c{k}")
        for k, (x, y, z) in enumerate((x, y, z) for x in sides for y in sides for z in (-0.1, 0.1))
    ]
    scene = ik.Scene(box, contacts=corners)
    q = box.configuration(root_joint=[0, 0, 0.14, 0, np.sin(0.1), 0, np.cos(0.1)])
    v = box.velocity(root_joint=[0.5, 0, 0, 0, 0.0, 0])
    motion = ik.simulate(scene, q, v, duration=0.12, samples=8, capture_speed=0.02)
    rules = strides.rules_of
    monkeypatch.setattr(strides, "rules_of", lambda now, **_: rules(now, changes=True))
    other = ik.simulate(scene, q, v, duration=0.12, samples=8, capture_speed=0.02)
    assert motion.status.finished and other.status.finished
    np.testing.assert_allclose(motion.q, other.q, atol=1e-10)
    assert len(motion.rests) == len(other.rests) and len(motion.impacts) == len(other.impacts) > 3
    at_once = 0
    for (t, ours), (when, theirs) in zip(motion.impacts, other.impacts, strict=True):
        assert abs(t - when) < 1e-10 and ours.is_valid()
        assert ours.status is theirs.status
        at_once += sum(len(contact.points) for contact in ours.contacts) > 1
        for mine, its in zip(ours.contacts, theirs.contacts, strict=True):
            np.testing.assert_allclose(mine.impulse, its.impulse, atol=1e-9)
            np.testing.assert_allclose(mine.velocity_after, its.velocity_after, atol=1e-9)
    assert at_once
    for ours, theirs in zip(motion.rests, other.rests, strict=True):
        assert ours.contact == theirs.contact
        np.testing.assert_allclose([ours.start, ours.end], [theirs.start, theirs.end], atol=1e-10)


@pytest.mark.parametrize(
    ("gap", "speed", "rate", "soon"),
    [
        (0.0, 2.0, -10.0, 0.4),
        (1.25, 0.0, -10.0, 0.5),
        (1.25, -4.0, 6.0, 0.5),
        (1.0, -1.0, 0.0, 1.0),
        (1.0, -1.0, 2.0, np.inf),
        (1.0, 1.0, 0.0, np.inf),
        (0.0, 1.0, 2.0, np.inf),
    ],
)
def test_a_parabola_tells_when_a_gap_closes(gap, speed, rate, soon):
    assert advance._falls_in(gap, speed, rate) == pytest.approx(soon, rel=1e-15)


def test_impacts_of_an_oscillator_are_as_accurate_as_its_steps(stepped):
    """A mass between a spring and a stop: m q̈ = −k (q − r), arc by arc in closed form."""
    slide = joint_text("x", "prismatic", "w", "b", "0 0 1", far=(0, 1e6))
    robot = ik.Robot.from_urdf(robot_text("o", link_text("w"), link_text("b", 1), slide))
    spring = ik.JointSpring("x", stiffness=4.0, rest=-0.5)
    stop = ik.JointStop("x", restitution=0.9)
    scene = ik.Scene(robot, contacts=[stop], forces=[spring], gravity=[0, 0, 0])
    # Over an arc q = r + R cos(2 t − φ), which falls to 0 at cos = 0.5/R.
    place, speed, t, times, speeds = 1.5, 0.0, 0.0, [], []
    for _ in range(12):
        size, phase = np.hypot(place, 0.5 * speed), np.arctan2(0.5 * speed, place)
        angle = np.arccos(0.5 / size)
        t += 0.5 * (angle + phase)
        times.append(t)
        place, speed = 0.5, 0.9 * 2.0 * size * np.sin(angle)
        speeds.append(speed)
    motion = ik.simulate(scene, [1.0], [0.0], duration=t + 0.01, samples=2)
    seen = [time for time, _ in motion.impacts]
    np.testing.assert_allclose(seen, times, rtol=1e-11)
    after = [impact.v_after[0] for _, impact in motion.impacts]
    np.testing.assert_allclose(after, speeds, rtol=1e-11)


def test_steps_made_at_once_are_no_standstill(stepped, monkeypatch):
    monkeypatch.setattr(strides, "MOST", 1)
    monkeypatch.setattr(headway, "MOST_STILL", 3)
    swing = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    motion = ik.simulate(
        ik.Scene(swing), swing.configuration(joint_1=1.0), np.zeros(2), duration=0.4
    )
    assert stepped[1].calls > 3
    assert motion.status is ik.MotionStatus.FINISHED


@pytest.mark.slow
def test_one_sided_springs_against_scipy(stepped):
    """Steps that end at kinks, many at once, against small steps over them."""
    box = ik.Robot.from_urdf(BOX, root="freeflyer")
    both = ik.combine(box=box, arm=ik.Robot.from_urdf("models/double_pendulum.urdf"))
    shoulder, elbow = [name for name in both.joint_names if name.startswith("arm/")]
    forces = [
        ik.JointSpring(shoulder, stiffness=90, damping=0.4, rest=0.1, acts="above"),
        ik.JointSpring(elbow, stiffness=80, rest=-0.1, acts="below"),
        ik.Spring("box/box", at=[0.1, 0.2, 0], stiffness=400, rest_length=1.0, acts="pull"),
        ik.Spring("box/box", other_at=[0, 0, -1], stiffness=900, rest_length=0.9, acts="push"),
    ]
    scene = ik.Scene(both, forces=forces)
    q, v = both.neutral().copy(), np.zeros(both.nv)
    v[:6], v[6:] = [0.5, 0.2, 0.3, 1.0, 2.0, 0.5], [3.0, -5.0]
    motion = ik.simulate(scene, q, v, duration=0.8)
    assert motion.status.finished and stepped[1].calls
    flow = PlainMotion(scene, q)
    for start, end in pairwise(np.linspace(0.0, 0.8, 81).tolist()):
        flow.advance(start, end, v0=v if start == 0.0 else None)
    q_end, v_end = flow.state()
    np.testing.assert_allclose(pin.difference(both.model, motion.q[-1], q_end), 0, atol=1e-8)
    np.testing.assert_allclose(motion.v[-1], v_end, atol=1e-7)
    told = ik.simulate(scene, q, v, duration=0.8, progress=lambda t: None)
    assert np.array_equal(told.q, motion.q) and np.array_equal(told.v, motion.v)
