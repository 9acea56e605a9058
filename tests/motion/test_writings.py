"""One motion written in several ways: a robot of all shapes that falls on a ground plane."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

ROBOT = """<mujoco><compiler angle="radian"/><worldbody><body name="trunk"><freejoint name="free"/>
<geom name="trunk" type="box" size=".2 .12 .05" mass="3"/>
<geom name="head" type="ellipsoid" pos=".25 0 .05" size=".08 .06 .05" mass=".5"/>
<body name="leg" pos=".15 .14 0"><joint name="hip" type="hinge" axis="0 1 0"/>
<geom name="leg" type="capsule" fromto="0 0 0 0 .02 -.2" size=".025" mass=".4"/>
<body name="foot" pos="0 .02 -.22"><joint name="ankle" type="hinge" axis="1 0 0"/>
<geom name="foot" type="cylinder" size=".05 .02" mass=".2"/></body></body>
<body name="tail" pos="-.2 0 0"><joint name="tail" type="hinge" axis="0 0 1"/>
<geom name="tail" type="sphere" pos="-.1 0 0" size=".04" mass=".2"/></body>
</body></worldbody></mujoco>"""
SHAPES = ("trunk", "head", "leg", "foot", "tail")
FALL = 0.45
HOW = {"restitution": 0.2, "friction": 0.5}


def fallen(world=None, *, order=1, swapped=False):
    """The trajectory of a fall in a world that is turned and moved, told in the plain one."""
    world = pin.SE3.Identity() if world is None else world
    up = world.rotation[:, 2]
    robot = ik.Robot.from_mjcf(ROBOT).with_ground(up.dot(world.translation), normal=up)
    pairs = [("ground", name) if swapped else (name, "ground") for name in SHAPES[::order]]
    contacts = [ik.Collision(*pair, **HOW) for pair in pairs]
    scene = ik.Scene(robot, contacts=contacts, gravity=-9.81 * up)
    turn = pin.Quaternion(pin.rpy.rpyToMatrix(0.3, -0.5, 0.4)).coeffs()
    place = world * pin.XYZQUATToSE3(np.r_[0.0, 0.0, 0.6, turn])
    q = robot.configuration(free=pin.SE3ToXYZQUAT(place), hip=0.4, ankle=-0.3, tail=0.5)
    motion = ik.simulate(scene, q, robot.velocity(), duration=FALL, samples=10)
    assert motion.status.finished, motion.detail
    back = [world.inverse() * pin.XYZQUATToSE3(q[:7]) for q in motion.q]
    own = [[*place.translation, *place.rotation.ravel()] for place in back]
    return motion, np.column_stack([own, motion.q[:, 7:]])


@pytest.fixture(scope="module")
def plain():
    return fallen()


TURNED = pin.SE3(pin.rpy.rpyToMatrix(0.7, -0.4, 1.1), np.array([3.0, -2.0, 5.0]))


@pytest.mark.slow
@pytest.mark.parametrize(
    "how", [{"world": TURNED}, {"order": -1}, {"swapped": True}], ids=["turned", "order", "swapped"]
)
def test_a_fall_does_not_hang_on_how_it_is_written(plain, how):
    motion, states = fallen(**how)
    assert len(motion.impacts) == len(plain[0].impacts) > 5
    times, own = ([t for t, _ in m.impacts] for m in (plain[0], motion))
    # Impacts multiply the errors of steps, 1e-8 of what moves.
    np.testing.assert_allclose(own, times, rtol=0, atol=1e-8)
    np.testing.assert_allclose(states, plain[1], rtol=0, atol=1e-7)


@pytest.mark.slow
def test_its_momentum_is_that_of_its_forces_and_no_piece_is_in_the_ground(plain):
    motion, _ = plain
    weight = 9.81 * motion.scene.robot.mass
    assert np.abs(motion.balance().residual).max() < 1e-8 * weight
    assert np.diff(motion.energy().total).max() < 1e-9 * weight
    for _, impact in motion.impacts:
        assert impact.energy.change < 1e-12 * weight
        # Nothing is met late: an impact came up to 1.5e-7 s late, with pieces in the ground.
        assert min(contact.gap for contact in impact.contacts) > -1e-9


ROD = """<mujoco><worldbody><geom name="rod" type="capsule" fromto="-.5 0 0 .5 0 0" size=".03"/>
<body name="bar"><freejoint name="free"/>
<geom name="bar" type="capsule" fromto="0 -.15 0 0 .15 0" size=".05" mass=".5"/>
</body></worldbody></mujoco>"""


@pytest.mark.parametrize("accuracy", ["normal", "high"])
def test_a_bar_leaves_a_rod_without_an_impact_however_the_pair_is_written(accuracy):
    """What is slower than the capture speed is no impact: rounding would say where it comes."""
    robot = ik.Robot.from_mjcf(ROD)
    q = robot.configuration(free=ik.pose([0.1, 0.05, 0.0801], rpy=[0.0, 0.0, 0.1]))
    v = robot.velocity(free=[0, 0, 0, 0, 0, 0.3])
    motions = []
    for pair in (("bar", "rod"), ("rod", "bar")):
        scene = ik.Scene(robot, contacts=[ik.Collision(*pair, restitution=0.3, friction=0.4)])
        motions.append(ik.simulate(scene, q, v, duration=0.6, accuracy=accuracy))
    one, other = motions
    assert one.status.finished and other.status.finished and one.q[-1, 2] < -0.8
    assert len(one.impacts) == len(other.impacts) == 6
    for _, impact in one.impacts:
        assert np.linalg.norm(impact.contacts[0].impulse) > 1e-7 * robot.mass
    bar = 1e-6 if accuracy == "normal" else 1e-8
    assert np.abs(one.q[-1] - other.q[-1]).max() < bar > np.abs(one.v[-1] - other.v[-1]).max()


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize(("yaw", "y"), [(1.3, 0.02), (1.3, 0.05), (1.5, 0.05)])
def test_a_bar_slides_off_its_end_however_the_pair_is_written(yaw, y, friction):
    """Where it touches the rod runs to its end, and on from there: the nearest points have a kink.

    Across the kink differences of them said how they move, and steps were 1e-8 s long.
    """
    robot = ik.Robot.from_mjcf(ROD)
    q = robot.configuration(free=ik.pose([0.1, y, 0.08], rpy=[0.0, 0.0, yaw]))
    motions = []
    for pair in (("bar", "rod"), ("rod", "bar")):
        scene = ik.Scene(robot, contacts=[ik.Collision(*pair, restitution=0.3, friction=friction)])
        motions.append(
            ik.simulate(scene, q, robot.velocity(), 0.6, accuracy="high", max_steps=1000)
        )
    one, other = motions
    assert one.status.finished and other.status.finished and one.q[-1, 2] < -0.5
    assert len(one.impacts) == len(other.impacts)
    assert np.abs(one.q[-1] - other.q[-1]).max() < 1e-7
    assert np.abs(one.v[-1] - other.v[-1]).max() < 1e-6
    assert np.diff(one.energy().total).max() < 1e-8
