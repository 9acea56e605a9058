"""The forces of a motion: what lies, hangs, slides and stands tells what holds it."""

import itertools
import pickle

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors

from ...robots import one_body
from ..models import GRAVITY, MODELS, sliders

FLOOR = ik.Robot.from_urdf(MODELS / "floor.urdf")
# A box without a lid, 0.4 m wide inside; it weighs 2.5 kg.
_WALLS = ((0, 0, -0.5, 2, 2, 1), (0.7, 0, 0.5, 1, 2, 1), (-0.7, 0, 0.5, 1, 2, 1))
_WALLS += ((0, 0.7, 0.5, 2, 1, 1), (0, -0.7, 0.5, 2, 1, 1))


def box_on_a_floor(turn=None, at=(0.0, 0.0, 0.0), gravity=(0.0, 0.0, -GRAVITY), **law):
    """A box that lies on a floor which is turned and moved, and its state."""
    place = pin.SE3(np.eye(3) if turn is None else turn, np.array(at))
    world = ik.combine(
        b=one_body("b", 1.7, (0.004, 0.005, 0.006), '<box size=".2 .3 .1"/>'),
        f=FLOOR,
        placements={"f": place},
    )
    scene = ik.Scene(
        world, contacts=[ik.Collision("b/b", "f/floor", name="floor", **law)], gravity=gravity
    )
    on_it = place * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.05]))
    q = world.configuration({"b/root_joint": pin.SE3ToXYZQUAT(on_it)})
    return scene, q, world.velocity()


@pytest.mark.parametrize(
    "turn", [None, pin.rpy.rpyToMatrix(0.3, -0.2, 1.0)], ids=["flat", "turned"]
)
def test_a_box_at_rest_tells_its_weight(turn):
    up = np.array([0.0, 0.0, 1.0]) if turn is None else turn[:, 2]
    scene, q, v = box_on_a_floor(turn, (1.0, -2.0, 0.5), -GRAVITY * up, friction=0.5)
    motion = ik.simulate(scene, q, v, duration=0.3, samples=3)
    weight = 1.7 * GRAVITY
    for t in (0.0, 0.11, 0.3):
        np.testing.assert_allclose(
            motion.contacts["floor"].force(t), weight * up, atol=1e-12 * weight
        )
    # At its four corners, a quarter each.
    places, forces = motion.contacts["floor"].points(0.2)
    np.testing.assert_allclose(forces @ up, np.full(4, weight / 4), rtol=1e-9)
    np.testing.assert_allclose(places.mean(axis=0), q[:3] - 0.05 * up, atol=1e-12)
    # The ground holds floor and box.
    np.testing.assert_allclose(
        motion.joints["f/root_joint"].reaction(0.2)[:3] @ up,
        weight + FLOOR.links[0].mass * GRAVITY,
        rtol=1e-12,
    )


def test_a_box_that_slides_is_braked_by_friction_and_one_on_a_slope_is_held():
    scene, q, v = box_on_a_floor(friction=0.4)
    v[0] = 1.0
    motion = ik.simulate(scene, q, v, duration=0.4, samples=3)
    weight, mu = 1.7 * GRAVITY, 0.4
    stops = 1.0 / (mu * GRAVITY)
    floor = motion.contacts["floor"]
    forces = floor.force([0.1, 0.2, stops + 0.01])
    np.testing.assert_allclose(
        forces, [[-mu * weight, 0, weight]] * 2 + [[0, 0, weight]], atol=1e-9 * weight
    )
    np.testing.assert_allclose(
        floor.power(0.1), -mu * weight * (1.0 - mu * GRAVITY * 0.1), rtol=1e-9
    )
    np.testing.assert_allclose(floor.work(), -0.5 * 1.7, rtol=1e-9)
    # A tilt of gravity within the cone.
    scene, q, v = box_on_a_floor(friction=0.4, gravity=(3.0, 1.0, -9.0))
    held = ik.simulate(scene, q, v, duration=0.1, samples=2).contacts["floor"].force(0.05)
    np.testing.assert_allclose(held, -1.7 * np.array([3.0, 1.0, -9.0]), atol=1e-11)


def test_reactions_of_a_standing_talos_are_those_of_newton_and_euler():
    talos = ik.Robot.from_example("talos", root="freeflyer")
    joints = [name for name in talos.joint_names if name != "root_joint"]
    corners = list(itertools.product((-0.1, 0.1), (-0.06, 0.06)))
    feet = ("left_sole_link", "right_sole_link")
    contacts = [
        ik.Contact(foot, at=[x, y, 0], friction=0.7, name=f"{foot} {x} {y}")
        for foot in feet
        for x, y in corners
    ]
    scene = ik.Scene(talos, constraints=[ik.JointLock(name) for name in joints], contacts=contacts)
    q = talos.neutral()
    model, data = talos.model, talos.model.createData()
    pin.framesForwardKinematics(model, data, q)
    q[2] -= data.oMf[model.getFrameId(feet[0])].translation[2]
    motion = ik.simulate(scene, q, talos.velocity(), duration=0.01, samples=2)
    t = 0.006
    q = motion.at(t)[0]
    pin.forwardKinematics(model, data, q)
    external = pin.StdVec_Force([pin.Force.Zero() for _ in range(model.njoints)])
    for contact in contacts:
        joint = model.frames[model.getFrameId(contact.frame)].parentJoint
        for place, force in zip(*motion.contacts[contact.name].points(t), strict=True):
            moment = np.cross(place, force)
            external[joint] += data.oMi[joint].actInv(pin.Force(force, moment))
    total = sum(motion.contacts[c.name].force(t)[2] for c in contacts)
    np.testing.assert_allclose(total, talos.mass * GRAVITY, rtol=1e-11)
    pin.rnea(model, data, q, np.zeros(model.nv), np.zeros(model.nv), external)
    for joint, name in enumerate(model.names):
        if joint > 1:
            turn = data.oMi[joint].rotation
            expected = np.concatenate([turn @ data.f[joint].linear, turn @ data.f[joint].angular])
            found = motion.joints[name].reaction(t)
            np.testing.assert_allclose(found, expected, atol=1e-10 * talos.mass * GRAVITY)
    # A lock gives its joint what the reaction has about the joint's axis.
    knee = motion.joints["leg_left_4_joint"].reaction(t)
    lock = motion.constraints[f"constraints[{joints.index('leg_left_4_joint')}]"].force(t)
    axis = data.oMi[model.getJointId("leg_left_4_joint")].rotation[:, 1]
    np.testing.assert_allclose(knee[3:] @ axis, lock[0], atol=1e-9)


def dropped(seed):
    """A box that falls, bounces, slides and lies down."""
    rng = np.random.default_rng(seed)
    scene, q, v = box_on_a_floor(restitution=0.3, friction=0.5)
    turn = rng.normal(size=4)
    q[:7] = [0, 0, 0.25, *(turn / np.linalg.norm(turn))]
    v[:6] = rng.normal(size=6)
    return ik.simulate(scene, q, v, duration=1.0, samples=5)


@pytest.mark.slow
def test_momentum_and_energy_are_those_that_forces_and_impulses_give():
    motion = dropped(3)
    assert motion.status.finished and len(motion.impacts) > 3 and motion.rests
    scale = np.abs(motion.balance().shares["weight"][:3]).max()
    middle = motion.impacts[2][0]
    for start, end in ((None, None), (0.2, 0.7), (None, middle), (middle, 1.0), (0.31, 0.3100001)):
        balance = motion.balance(start, end)
        # What parts more slowly than 1e-5 m/s is laid down.
        assert np.abs(balance.residual).max() < 5e-8 * scale
        floor = motion.contacts["floor"].impulse(start, end)
        np.testing.assert_allclose(balance.shares["floor"][:3], floor, atol=1e-12)
    # Two parts add up, whatever happens where they meet.
    whole = motion.contacts["floor"].impulse()
    parts = motion.contacts["floor"].impulse(None, middle) + motion.contacts["floor"].impulse(
        middle
    )
    np.testing.assert_allclose(parts, whole, atol=1e-12)
    energy = motion.energy().total
    np.testing.assert_allclose(motion.contacts["floor"].work(), energy[-1] - energy[0], atol=1e-7)


def test_the_books_of_a_linkage_with_springs_motors_and_a_stop_close():
    chain = ik.Robot.from_urdf(ik.models.pendulum_urdf(3))
    scene = ik.Scene(
        chain,
        [ik.AppliedImpulse("link_3", linear=[0.2, 0.1, 0.1], at=[0, 0, -1])],
        [ik.JointCoupling("joint_3", "joint_2", ratio=-0.5, name="gear")],
        [ik.JointStop("joint_1", lower=-0.2, upper=0.2, restitution=0.4, name="stop")],
        [
            ik.JointSpring("joint_2", stiffness=3.0, damping=0.2, name="spring"),
            ik.Actuator("joint_1", lambda t, q, v: 4.0 * np.sin(3.0 * t), name="motor"),
            ik.Spring(
                "link_3", "world", at=[0, 0, -1], other_at=[1, 1, 1], stiffness=5.0, name="bow"
            ),
            ik.AppliedForce("link_2", linear=lambda t: (t, 1.0, 0), axes="local", name="jet"),
        ],
    )
    motion = ik.simulate(scene, chain.neutral(), chain.velocity(), duration=1.5, samples=3)
    assert motion.status.finished and len(motion.contacts["stop"]) >= 1
    for start, end in ((None, None), (0.1, 1.2)):
        balance = motion.balance(start, end)
        assert np.abs(balance.residual).max() < 1e-8
    # Against rnea: the motor, the spring, the gear and the stop are all that turns the joints.
    for t in (0.2, 0.9, 1.4):
        q, v = motion.at(t)
        step = 1e-5
        rate = (motion.at(t + step)[1] - motion.at(t - step)[1]) / (2 * step)
        model = pin.Model(chain.model)
        data = model.createData()
        given = pin.rnea(model, data, q, v, rate)
        forces = motion.forces
        gear = motion.constraints["gear"].force(t)[0]
        told = np.zeros(3)
        told[0] += forces["motor"].force(t)[0] + motion.contacts["stop"].force(t)[0]
        told[1] += forces["spring"].force(t)[0] + 0.5 * gear
        told[2] += gear
        frames = [model.getFrameId(name) for name in ("link_3", "link_2")]
        wrench = np.array(forces["bow"].force(t)), np.array(forces["jet"].force(t))
        pin.computeJointJacobians(model, data, q)
        for frame, at, own in zip(frames, ([0, 0, -1], [0, 0, 0]), wrench, strict=True):
            item = model.frames[frame]
            place = item.placement * pin.SE3(np.eye(3), np.array(at, dtype=float))
            rows = pin.getFrameJacobian(
                model, data, item.parentJoint, place, pin.LOCAL_WORLD_ALIGNED
            )
            told += own @ rows
        np.testing.assert_allclose(told, given, atol=1e-6)
    # What all entries gave in energy is what the motion has gained since the blow.
    works = sum(force.work() for force in motion.forces.values())
    works += motion.contacts["stop"].work(0.0, 1.5)
    works += motion.constraints["gear"].work(0.0, 1.5)
    model, data = chain.model, chain.model.createData()
    after, before = (
        pin.computeKineticEnergy(model, data, *motion.at(t))
        + pin.computePotentialEnergy(model, data, motion.at(t)[0])
        for t in (1.5, 0.0)
    )
    np.testing.assert_allclose(works, after - before, atol=1e-8)


def test_motions_that_were_saved_or_sent_tell_the_same_forces(tmp_path):
    motion = dropped(5)
    assert motion.status.finished
    times = np.linspace(0.0, motion.duration, 23)
    told = motion.contacts["floor"].force(times)
    assert np.abs(told).max() > 1.0
    motion.save(tmp_path / "m.npz")
    for again in (pickle.loads(pickle.dumps(motion)), ik.Trajectory.load(tmp_path / "m.npz")):
        np.testing.assert_allclose(again.contacts["floor"].force(times), told, atol=1e-9)


def test_events_are_a_table():
    pytest.importorskip("xarray")
    motion = dropped(3)
    table = motion.events()
    assert table["impact_time"].values.tolist() == [time for time, _ in motion.impacts]
    for i, (_, impact) in enumerate(motion.impacts):
        own = table.isel(impact=i)
        np.testing.assert_array_equal(
            own["impulse"].sel(contact="floor"), impact.contacts[0].impulse
        )
        assert own["energy_change"] == impact.energy.change
        assert impact.status.valid
        assert own["touching"].sel(contact="floor")
        assert str(own["status"].values) == impact.status.name
    rests = [(rest.contact, rest.start, rest.end) for rest in motion.rests]
    columns = (table[name].values.tolist() for name in ("rest_contact", "rest_start", "rest_end"))
    assert list(zip(*columns, strict=True)) == rests


def test_what_is_asked_wrongly_is_told():
    robot = sliders(1)
    scene = ik.Scene(robot, contacts=[ik.JointStop("z00", lower=0.0, name="ground")])
    motion = ik.simulate(scene, robot.neutral(), robot.velocity(), duration=0.5, samples=2)
    ground = motion.contacts["ground"]
    np.testing.assert_allclose(ground.force([0.1, 0.4]), [[GRAVITY], [GRAVITY]], rtol=1e-14)
    with pytest.raises(ValueError):
        ground.force(0.1)[0] = 1.0
    for name in ("contacts", "constraints", "forces", "joints"):
        with pytest.raises(errors.UnknownNameError, match="floor"):
            getattr(motion, name)["floor"]
    for wrong in (-0.1, 0.6, float("nan")):
        with pytest.raises((errors.RangeError, errors.NotFiniteError)):
            ground.force(wrong)
    with pytest.raises(errors.RangeError):
        ground.impulse(0.4, 0.2)
    with pytest.raises(errors.ShapeError):
        ground.force([[0.1]])
