"""Painlevé's rod: friction jams a sliding end, which an impact without collision stops."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ..models import GRAVITY, MODELS

# Of a slender rod of 1 kg and 1 m: where its mass is, and its inertia there.
HALF, INERTIA = 0.5, 1.0 / 12.0
MU = 5.0 / 3.0  # Glocker's: jams between 45 and 76 degrees, where tan²θ − 5 tan θ + 4 <= 0
LAWS = [
    ik.Law(),
    ik.Law("poisson"),
    ik.Law(slip="path"),
    ik.Law("stronge", slip="path"),
    ik.Law(order="sequential"),
]


@pytest.fixture(scope="module")
def rod():
    return ik.Robot.from_urdf(MODELS / "rod.urdf", root="freeflyer")


def sliding(rod, angle, slip, spin, *, turn=None, shift=(0.0, 0.0, 0.0), **contact):
    """Scene, q and v of a rod whose near end slides over a floor in a turned and moved world."""
    turn = np.eye(3) if turn is None else turn
    along = np.array([np.cos(angle), 0.0, np.sin(angle)])
    attitude = turn @ np.column_stack([along, [0, 1, 0], np.cross(along, [0, 1, 0])])
    q = rod.configuration(root_joint=pin.SE3ToXYZQUAT(pin.SE3(attitude, turn @ shift)))
    velocity = attitude.T @ turn @ [slip, 0, 0]
    v = rod.velocity(root_joint=[*velocity, *(attitude.T @ turn @ [0, -spin, 0])])
    contact = {"friction": MU, **contact}
    law = contact.pop("law", ik.Law())
    floor = ik.Contact("rod", normal=turn @ [0, 0, 1], origin=turn @ shift, **contact)
    return ik.Scene(rod, contacts=[floor], gravity=turn @ [0, 0, -GRAVITY], law=law), q, v


def about_the_end(angle, slip, spin):
    """ω when the sliding end is stopped: angular momentum about it is kept."""
    r = HALF * np.array([np.cos(angle), np.sin(angle)])
    x, y = slip - spin * r[1], spin * r[0]
    return (INERTIA * spin + r[0] * y - r[1] * x) / (INERTIA + HALF**2)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.restitution}-{law.slip}-{law.order}")
@pytest.mark.parametrize("degrees", [45.0, 45.01, 50.0, 60.0, 75.9])
def test_a_jammed_end_stops_at_once_and_the_motion_goes_on(rod, degrees, law):
    angle = np.radians(degrees)
    for slip, spin in ((-2.0, 0.0), (-0.3, 1.0), (-2.0, -1.0)):
        scene, q, v = sliding(rod, angle, slip, spin, law=law, restitution=0.6)
        motion = ik.simulate(scene, q, v, duration=0.1, samples=51, accuracy="high")
        assert motion.status.finished, motion.detail
        time, jam = motion.impacts[0]
        assert time == 0.0
        assert jam.status is ik.Status.SOLVED
        end = jam.velocity_at("rod")
        np.testing.assert_allclose(end.before, [slip, 0, 0], atol=1e-10)
        np.testing.assert_allclose(end.after, 0.0, atol=1e-12)
        spin_after = -(pin.XYZQUATToSE3(q).rotation @ jam.v_after[3:])[1]
        assert spin_after == pytest.approx(about_the_end(angle, slip, spin), abs=1e-12)
        assert np.diff(motion.energy().total).max() < 1e-9


@pytest.mark.parametrize("degrees", [30.0, 44.99, 75.98, 85.0])
@pytest.mark.parametrize("slip", [-2.0, 2.0])
def test_outside_these_angles_nothing_jams_at_the_start(rod, degrees, slip):
    scene, q, v = sliding(rod, np.radians(degrees), slip, 0.0)
    motion = ik.simulate(scene, q, v, duration=1e-3, accuracy="high")
    assert motion.status.finished
    assert not motion.impacts


def test_a_rod_that_slides_into_the_angle_of_jams_goes_on(rod):
    # At 40 degrees with spin enough to come to 45 while it slides.
    for spin in (0.5, 2.0, 4.0):
        scene, q, v = sliding(rod, np.radians(40.0), -6.0, spin)
        motion = ik.simulate(scene, q, v, duration=0.5, accuracy="high")
        assert motion.status.finished, motion.detail
        assert np.diff(motion.energy().total).max() < 1e-8


def opening(q, v):
    """How the end accelerates away from the floor without its force: l ω² sin θ − g."""
    attitude = pin.XYZQUATToSE3(q).rotation
    spin = -(attitude @ v[3:])[1]
    return HALF * spin**2 * attitude[2, 0] - GRAVITY


@pytest.mark.parametrize("duration", [0.2, 1.0])
@pytest.mark.parametrize(
    ("degrees", "slip", "spin"), [(40, -6, 0.5), (30, -6, 2.0), (40, -6, 4.0), (44, -6, 0.1)]
)
def test_a_slide_that_comes_to_the_singular_point_lets_go(rod, degrees, slip, spin, duration):
    # There the end would open without its force, and W is zero: it need not be stopped.
    scene, q, v = sliding(rod, np.radians(degrees), slip, spin)
    motion = ik.simulate(scene, q, v, duration=duration, accuracy="high")
    end = motion.rests[0].end
    q, v = motion.at(end)
    angle = np.degrees(np.arcsin(pin.XYZQUATToSE3(q).rotation[2, 0]))
    assert motion.status.finished and end < 0.2
    # Only when it comes down again there is an impact.
    assert all(time > 0.5 for time, _ in motion.impacts)
    assert 45.0 - 1e-5 < angle < 45.01 and -1e-6 < opening(q, v) < 0.01
    assert np.diff(motion.energy().total).max() < 1e-8


@pytest.mark.slow
def test_feet_of_a_robot_that_jam_one_after_the_other():
    """A quadruped lands on stiff joints: a foot that friction jams while it hardly slides stops."""
    robot = ik.Robot.from_example("anymal", root="freeflyer")
    feet = ["LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"]
    q = robot.neutral()
    height = min(robot.placement(q, foot).position[2] for foot in feet)
    q = robot.configuration(root_joint=[0, 0, 0.05 - height, 0, 0, 0, 1])
    joints = list(robot.model.names)[2:]
    springs = [ik.JointSpring(name, stiffness=3000.0, damping=0.5) for name in joints]
    contacts = [ik.Contact(foot, friction=0.6) for foot in feet]
    scene = ik.Scene(robot, contacts=contacts, forces=springs)
    motion = ik.simulate(scene, q, robot.velocity(), duration=0.21, samples=43, accuracy="high")
    assert motion.status is ik.MotionStatus.FINISHED
    # Nothing drives it: energy only falls, up to what integration leaves.
    energy = motion.energy().total
    assert np.diff(energy).max() < 1e-6 * energy.max() and len(motion.impacts) > 15
