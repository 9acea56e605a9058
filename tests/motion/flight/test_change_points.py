"""Linkages that lose rank where they are flat go on along the branch on which they came."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text


def rod(name: str, length: float) -> str:
    """A uniform rod of 1 kg along x, from its link's origin."""
    across = length**2 / 12.0
    return link_text(name, 1, (0.001, across, across), at=(length / 2, 0, 0))


def hinge(name: str, parent: str, child: str, x: float) -> str:
    return joint_text(name, "continuous", parent, child, "0 1 0", at=(x, 0, 0))


def cranks(crank: float, rail: float, count: int = 2) -> ik.Scene:
    """Cranks on one coupling rod, pivots ``rail`` apart: a parallelogram, a locomotive's rods."""
    parts = rod("crank_0", crank) + rod("coupler", (count - 1) * rail)
    parts += hinge("drive", "base", "crank_0", 0.0) + hinge("pin", "crank_0", "coupler", crank)
    for i in range(1, count):
        parts += rod(f"crank_{i}", crank) + hinge(f"axle_{i}", "base", f"crank_{i}", i * rail)
    robot = ik.Robot.from_urdf(robot_text("rods", link_text("base"), parts))
    pins = [
        ik.PointAnchor("coupler", f"crank_{i}", at=[i * rail, 0, 0], other_at=[crank, 0, 0])
        for i in range(1, count)
    ]
    return ik.Scene(robot, constraints=pins)


def turning(scene: ik.Scene, angle: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """All cranks at an angle against x, upwards, and turning down; the rod keeps level."""
    names = [name for name in scene.robot.joint_names if name != "pin"]
    q = scene.robot.configuration(**dict.fromkeys(names, -angle), pin=angle)
    return q, scene.robot.velocity(**dict.fromkeys(names, speed), pin=-speed)


def pendulum(crank: float, count: int, angle: float, speed: float, times: np.ndarray) -> np.ndarray:
    """(2, k) angle and speed of the only freedom, by an integration at 1e-13.

    ``count`` cranks of 1 kg turn, the rod of 1 kg is carried along:
    (count/3 + 1) a² φ̈ = (count/2 + 1) g a cos φ.
    """
    inertia, moment = (count / 3.0 + 1.0) * crank**2, (count / 2.0 + 1.0) * 9.81 * crank

    def rates(t, y):
        return [y[1], moment * np.cos(y[0]) / inertia]

    span = 0.0, float(times[-1])
    return solve_ivp(rates, span, [-angle, speed], "DOP853", times, rtol=1e-13, atol=1e-13).y


# A rhombus, which stopped at its second change point; a parallelogram; three cranks.
CASES = [(1.0, 1.0, 2, 20.0), (1.0, 1.0, 2, 6.0), (0.5, 1.3, 2, 12.0), (0.4, 1.1, 3, 9.0)]


@pytest.mark.slow
@pytest.mark.parametrize(("crank", "rail", "count", "speed"), CASES)
def test_cranks_turn_past_their_change_points(crank, rail, count, speed):
    scene = cranks(crank, rail, count)
    motion = ik.simulate(scene, *turning(scene, 1.2, speed), duration=2.0, accuracy="high")
    assert motion.status.name == "FINISHED"
    angles, speeds = pendulum(crank, count, 1.2, speed, motion.t)
    assert np.abs(np.diff(np.floor(angles / np.pi))).sum() >= 2
    drive = scene.robot.model.joints[scene.robot.joint_id("drive")]
    found = motion.q[:, drive.idx_q : drive.idx_q + 2]
    off = np.abs(found - np.column_stack([np.cos(angles), np.sin(angles)]))
    assert off[-1].max() < 1e-7
    assert off.max() < 2e-6
    assert abs(motion.v[-1, drive.idx_v] - speeds[-1]) < 1e-7 * speed
    for i in range(1, count):
        axle = scene.robot.model.joints[scene.robot.joint_id(f"axle_{i}")].idx_v
        assert np.abs(motion.v[:, axle] - motion.v[:, drive.idx_v]).max() < 1e-5 * speed


def crossed(crank: float, rail: float, angle: float, speed: float) -> tuple[ik.Scene, tuple]:
    """A parallelogram whose sides cross, its drive at an angle and speed; without weight.

    The rod's end is the origin mirrored where the crank's tip and the other pivot change places.
    """
    tip, pivot = crank * np.array([np.cos(angle), np.sin(angle)]), np.array([rail, 0.0])
    along = (pivot - tip) / np.linalg.norm(pivot - tip)
    end = np.dot(tip + pivot, along) * along
    rod_angle, other = (np.arctan2(y, x) for x, y in (end - tip, end - pivot))
    # Normals to crank, rod and other crank: ω (tip) + ω_rod (end − tip) = ω_other (end − pivot).
    normals = [np.array([-y, x]) for x, y in (tip, end - tip, end - pivot)]
    matrix = np.column_stack([normals[1], -normals[2]])
    rod_speed, other_speed = np.linalg.solve(matrix, -speed * normals[0])
    scene = cranks(crank, rail)
    scene = ik.Scene(scene.robot, constraints=scene.constraints, gravity=(0, 0, 0))
    q = scene.robot.configuration(drive=-angle, pin=angle - rod_angle, axle_1=-other)
    v = scene.robot.velocity(drive=-speed, pin=speed - rod_speed, axle_1=-other_speed)
    return scene, (q, v)


@pytest.mark.slow
def test_a_crossed_parallelogram_stays_crossed():
    scene, start = crossed(1.0, 2.0, 1.5, 6.0)
    motion = ik.simulate(scene, *start, duration=1.0, accuracy="high")
    assert motion.status.name == "FINISHED"
    drive, axle = (
        scene.robot.model.joints[scene.robot.joint_id(name)].idx_v for name in ("drive", "axle_1")
    )
    # The one turns against the other for good, and more than half a turn.
    assert (motion.v[:, drive] * motion.v[:, axle] < 0.0).all()
    assert motion.v[:, drive].mean() * motion.duration < -np.pi
    kinetic = motion.energy().kinetic
    assert np.ptp(kinetic) < 1e-6 * kinetic[0]


@pytest.mark.slow
def test_a_linkage_driven_into_a_dead_centre_is_told_to_stand():
    # A rod of .5 m holds the tip of a crank of 1 m to a slider, which is pulled away evenly.
    parts = rod("crank", 1.0) + rod("rod", 0.5) + rod("slide", 0.1)
    parts += hinge("drive", "base", "crank", 0.0) + hinge("pin", "crank", "rod", 1.0)
    parts += joint_text("rail", "prismatic", "base", "slide", far=9)
    robot = ik.Robot.from_urdf(robot_text("slider", link_text("base"), parts))
    loop = ik.PointAnchor("rod", "slide", at=[0.5, 0, 0])
    scene = ik.Scene(robot, constraints=[loop, ik.JointLock("rail", velocity=0.5)])
    # The rod slants down to the rail by as much as the crank rises.
    up, down = 0.3, np.arcsin(2.0 * np.sin(0.3))
    reach = np.cos(up) + 0.5 * np.cos(down)
    q = robot.configuration(drive=-up, pin=up + down, rail=reach)
    turn = 0.5 / (np.sin(up) + np.cos(up) * np.tan(down))
    v = robot.velocity(drive=turn, pin=-turn * (1.0 + 2.0 * np.cos(up) / np.cos(down)), rail=0.5)
    motion = ik.simulate(scene, q, v, duration=1.0, rtol=1e-6)
    # At full reach, 1.5 m, at the latest.
    assert motion.status.name in ("STEP_TOO_SMALL", "CONTRADICTION", "NOT_FINITE")
    assert motion.t[-1] == pytest.approx((1.5 - reach) / 0.5, abs=1e-5)
