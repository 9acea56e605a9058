"""What holds and what closes, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.reference import Tree

from ..close import close
from ..motion.models import particle
from ..reference.models import joint, link, robot
from ..robots import random_blow, random_state

BALL_MASS, BALL_INERTIA = 0.5, 0.0005  # models/ball.urdf


def ball():
    return ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


def discs(*inertias, nested=False):
    """Discs that turn about z, side by side on the world or each on the one before."""
    parts = ['<link name="ground"/>']
    for i, inertia in enumerate(inertias):
        parts.append(link(f"disc_{i}", "1", inertia=f"1 0 0 1 0 {inertia}"))
        parent = f"disc_{i - 1}" if nested and i else "ground"
        parts.append(joint(f"axle_{i}", parent, f"disc_{i}", "continuous"))
    return ik.Robot.from_urdf(robot(*parts))


def solved(body, constraints, v, q=None, impulses=()):
    q = body.neutral() if q is None else q
    impact = ik.solve(ik.Scene(body, impulses, constraints), q, v)
    assert impact.is_valid()
    return impact


@pytest.mark.parametrize("depth", [0.3, 0.6, 0.9])
def test_a_ballistic_pendulum(depth):
    """(I + m d² + i) ω = m u d; the rod hangs along -z and turns about y."""
    mass, length, speed = 3.0, 0.9, 40.0
    both = ik.combine(ball=ball(), rod=ik.Robot.from_urdf(ik.models.pendulum_urdf(1, mass, length)))
    q = both.configuration({"ball/root_joint": (0, 0, -depth, 0, 0, 0, 1)})
    v = both.velocity({"ball/root_joint": (speed, 0, 0, 0, 0, 0)})
    rod = mass * length**2 / 3
    for anchor, inertia in (
        (ik.FrameAnchor("ball/ball", "rod/link_1"), BALL_INERTIA),
        (ik.PointAnchor("ball/ball", "rod/link_1"), 0.0),
    ):
        impact = solved(both, [anchor], v, q)
        rate = BALL_MASS * speed * depth / (rod + BALL_MASS * depth**2 + inertia)
        assert -impact.bodies["rod/link_1"].domega[1] == pytest.approx(rate, rel=1e-12)
        caught = impact.velocity_at("ball/ball").after
        close(caught, [rate * depth, 0, 0], 1e-12 * speed)
        kept = BALL_MASS * depth**2 / (rod + BALL_MASS * depth**2 + inertia)
        energy = 0.5 * BALL_MASS * speed**2
        assert impact.energy.after == pytest.approx(kept * energy, rel=1e-12)
        # The pivot bears what keeps the rod's near end where it is.
        pivot = impact.reactions["rod/joint_1"]
        momentum = mass * rate * length / 2 + BALL_MASS * rate * depth - BALL_MASS * speed
        close(pivot[:3], [momentum, 0, 0], 1e-12 * speed)
        # The ball receives what it loses, and the rod the opposite.
        received = impact.constraints[0].impulse
        lost = BALL_MASS * (rate * depth - speed)
        close(received[:3], [lost, 0, 0], 1e-12 * speed)


def test_a_wheel_s_axle_locks_in_flight():
    """Wheel and carriage share a mass centre and turn on as one, with all their spin."""
    inertias, spins = (0.8, 0.13), (0.5, 30.0)
    car = ik.Robot.from_urdf(
        robot(
            link("carriage", "5", inertia=f"1 0 0 1 0 {inertias[0]}"),
            link("wheel", "2", inertia=f"1 0 0 1 0 {inertias[1]}"),
            joint("axle", "carriage", "wheel", "continuous"),
        ),
        root="planar",
    )
    v = car.velocity(root_joint=(2, -1, spins[0]), axle=spins[1] - spins[0])
    impact = solved(car, [ik.JointLock("axle")], v)
    rate = np.dot(inertias, spins) / sum(inertias)
    close(impact.v_after, [2, -1, rate, 0], 1e-12)
    torque = inertias[1] * (rate - spins[1])
    np.testing.assert_allclose(impact.constraints[0].impulse, [torque], rtol=1e-12)


def test_a_box_that_lands_on_a_corner_without_rebound():
    """I_O ω⁺ = I ω + r x m v about the corner O, in three dimensions."""
    mass, corner = 4.0, np.array([0.3, -0.2, -0.5])
    inertia = np.diag([0.7, 0.5, 0.3])
    box = ik.Robot.from_urdf(robot(link("box", "4", inertia="0.7 0 0 0.5 0 0.3")), root="freeflyer")
    q, v = random_state(box, 3)
    impact = solved(box, [ik.PointAnchor("box", at=corner)], v, q)
    arm = -corner
    about_corner = inertia + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    spin = np.linalg.solve(about_corner, inertia @ v[3:] + mass * np.cross(arm, v[:3]))
    close(impact.v_after[3:], spin, 1e-12)
    close(impact.v_after[:3], np.cross(spin, arm), 1e-12)
    close(impact.velocity_at("box", corner).after, 0, 1e-12)


@pytest.mark.parametrize("ratio", [2.0, -0.25, 1e3])
def test_gears_that_engage(ratio):
    inertias, spins = (0.7, 0.2), (3.0, -11.0)
    body = discs(*inertias)
    impact = solved(body, [ik.JointCoupling("axle_0", "axle_1", ratio)], spins)
    rate = (inertias[0] * ratio * spins[0] + inertias[1] * spins[1]) / (
        inertias[0] * ratio**2 + inertias[1]
    )
    np.testing.assert_allclose(impact.v_after, [ratio * rate, rate], rtol=1e-12)
    torque = inertias[0] * (ratio * rate - spins[0])
    np.testing.assert_allclose(impact.constraints[0].impulse, [torque], rtol=1e-12)
    # Each shaft bears its own share.
    assert impact.reactions["axle_0"][5] == pytest.approx(torque, rel=1e-12)
    assert impact.reactions["axle_1"][5] == pytest.approx(-ratio * torque, rel=1e-12)


def test_a_differential():
    inertias, spins = np.array([0.7, 0.2, 0.4]), np.array([3.0, -11.0, 5.0])
    row = np.array([1, -0.5, -0.5])
    coupling = ik.JointCoupling("axle_0", ["axle_1", "axle_2"], ratio=[0.5, 0.5])
    impact = solved(discs(*inertias), [coupling], spins)
    torque = -(row @ spins) / (row**2 / inertias).sum()
    np.testing.assert_allclose(impact.v_after, spins + row * torque / inertias, rtol=1e-12)
    np.testing.assert_allclose(impact.constraints[0].impulse, [torque], rtol=1e-12)


@pytest.mark.parametrize("name", ["panda", "tiago_pro"])
def test_mimic_joints_as_couplings(name):
    """A robot whose mimic joints are coupled moves as one in which they have no speed."""
    free = ik.Robot.from_example(name)
    tied = ik.Robot.from_example(name, mimic=True)
    follows = {
        item.joint.name: (item.joint.mimics, item.joint.multiplier)
        for item in Tree.from_urdf(free.parts[0].urdf, mimic=True).bodies
        if item.joint.mimics
    }
    couplings = [ik.JointCoupling(joint, *leader) for joint, leader in follows.items()]
    assert couplings
    _, v_tied = random_state(tied, 1)
    place = {free.joint_names[i]: free.model.joints[i + 1] for i in range(len(free.joint_names))}
    # Both at rest in q, so that followers are where their leaders put them.
    q_free, q_tied, v_free = free.neutral(), tied.neutral(), np.zeros(free.nv)
    for i, joint_name in enumerate(tied.joint_names):
        item, own = tied.model.joints[i + 1], place[joint_name]
        if item.nv:
            v_free[own.idx_v : own.idx_v + own.nv] = v_tied[item.idx_v : item.idx_v + item.nv]
    for joint_name, (leader, ratio) in follows.items():
        v_free[place[joint_name].idx_v] = ratio * v_free[place[leader].idx_v]
    struck = [item.name for item in free.links if item.joint_id > 0][-1]
    blows = [random_blow(struck, 1), random_blow(struck, 2, "local")]
    coupled = solved(free, couplings, v_free, q_free, blows)
    whole = ik.solve(ik.Scene(tied, blows), q_tied, v_tied)
    for i, joint_name in enumerate(tied.joint_names):
        item, own = tied.model.joints[i + 1], place[joint_name]
        ours = coupled.v_after[own.idx_v : own.idx_v + own.nv]
        close(ours[: item.nv], whole.v_after[item.idx_v : item.idx_v + item.nv], 1e-11)
    for link_name, jump in whole.bodies.items():
        close(coupled.bodies[link_name].dv_com, jump.dv_com, 1e-11)
    assert coupled.energy.after == pytest.approx(whole.energy.after, rel=1e-12)


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("angle", [0.3, 1.2])
def test_energy_that_a_lock_and_a_contact_gain_together_is_told(law, angle):
    # A particle at (−1, 0, 0) m/s is stopped along x as it meets a plane that leans by an angle:
    # v⁺ = (0, 0, e cos/sin) by Newton's law, faster than before where the plane is steep.
    e, normal = 0.8, [np.cos(angle), 0, np.sin(angle)]
    scene = ik.Scene(
        particle(),
        constraints=[ik.JointLock("along_x")],
        contacts=[ik.Contact("z", normal=normal, restitution=e)],
        law=ik.Law(law),
    )
    v = np.array([-1.0, 0.0, 0.0])
    impact, batch = ik.solve(scene, np.zeros(3), v), ik.solve_batch(scene, [np.zeros(3)], [v])
    up = e / np.tan(angle) if law == "newton" else 0.0
    np.testing.assert_allclose(impact.v_after, [0.0, 0.0, up], atol=1e-14)
    wanted = "ENERGY_GAIN" if up > 1.0 else "SOLVED"
    assert impact.status.name == wanted
    assert impact.is_valid() == (up <= 1.0)
    assert batch.status[0] == impact.status


def test_what_is_driven_gives_energy_beside_a_contact():
    scene = ik.Scene(
        particle(), constraints=[ik.JointLock("along_x", velocity=2.0)], contacts=[ik.Contact("z")]
    )
    v = np.array([0.0, 0.0, -1.0])
    impact, batch = ik.solve(scene, np.zeros(3), v), ik.solve_batch(scene, np.zeros(3), v)
    np.testing.assert_allclose(impact.v_after, [2.0, 0.0, 0.0], atol=1e-15)
    assert impact.is_valid() and batch.valid.all()


IMPOSED = {
    "feet": [ik.FrameAnchor("left_sole_link"), ik.FrameAnchor("right_sole_link")],
    "hands": [ik.FrameAnchor("gripper_left_base_link", "gripper_right_base_link", axes="local"),
              ik.JointLock("torso_1_joint")],
    "gears": [ik.JointCoupling("arm_left_4_joint", ["arm_right_4_joint", "head_1_joint"],
                               ratio=[0.5, -2]),
              ik.PointAnchor("head_2_link", "gripper_left_base_link", at=(0, 0, 1))],
    "four corners": [ik.PointAnchor("left_sole_link", at=(x, y, 0))
                     for x in (0.1, -0.1) for y in (0.05, -0.05)],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("imposed", IMPOSED)
@pytest.mark.parametrize("seed", range(3))
def test_carnot_s_theorem(imposed, seed):
    """What imposed constraints take is the energy of the lost velocities."""
    talos = ik.Robot.from_example("talos", root="freeflyer")
    q, v = random_state(talos, seed)
    energy = solved(talos, IMPOSED[imposed], v, q).energy
    assert energy.before - energy.after == pytest.approx(energy.of_lost_velocities, rel=1e-11)
    assert energy.change == pytest.approx(-energy.of_lost_velocities, rel=1e-11)
    assert energy.of_lost_velocities > 0 and energy.imbalance < 1e-12
