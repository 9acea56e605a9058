"""The jobs of a first hour, run as scripts and held against closed forms."""

import runpy

import numpy as np
import pytest

import impulsekit as ik

from . import EXAMPLES

JOBS = (
    "wall_hit_by_ur5",
    "ball_in_moving_gripper",
    "car_crash",
    "golf_swing",
    "arm_against_hand",
)


def ran(name):
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


@pytest.mark.parametrize("name", JOBS)
def test_a_job_is_short_and_knows_no_pinocchio(name):
    text = (EXAMPLES / f"{name}.py").read_text()
    assert len(text.splitlines()) <= 40
    assert "pinocchio" not in text


def test_a_slip_free_wall_takes_the_effective_mass(capsys):
    found = ran("wall_hit_by_ur5")
    speed = found["speed"]
    for robot in (found["bare"], found["geared"]):
        masses = ik.design.impact_ellipsoid(robot, found["q"], "tool0", found["PAYLOAD"])
        contact = ik.Contact(
            "tool0", at=found["PAYLOAD"], origin=found["face"], normal=-speed, name="wall"
        )
        impact = ik.solve(ik.Scene(robot, contacts=[contact]), found["q"], found["v"])
        # Without friction and restitution: P = m_eff u.
        wanted = masses.effective_mass(speed) * np.linalg.norm(speed)
        impulse = np.linalg.norm(impact.contacts["wall"].impulse)
        assert impulse == pytest.approx(wanted, rel=1e-12)
    # The rotors add to the diagonal of M, so no point gets lighter.
    lines = [line.split()[2] for line in capsys.readouterr().out.splitlines() if "wall" in line]
    assert float(lines[1]) > float(lines[0])


def test_the_ball_goes_with_the_gripper_and_momentum_is_kept():
    found = ran("ball_in_moving_gripper")
    impact, robot = found["impact"], found["robot"]
    hand = impact.velocity_at("arm/panda_hand", found["GRIP"]).after
    assert impact.velocity_at("ball/ball").after == pytest.approx(hand, abs=1e-13)
    jump = 0.17 * impact.bodies["ball/ball"].dv_com
    assert impact.constraints["grip"].impulse[:3] == pytest.approx(jump, abs=1e-13)
    assert impact.constraints["grip"].gap < 1e-15
    assert robot.placement(found["q"], "ball/ball").position == pytest.approx(
        robot.placement(found["q"], "arm/panda_hand").point(found["GRIP"]), abs=1e-15
    )


def test_two_cars_keep_momentum_and_moment_of_momentum():
    found = ran("car_crash")
    impact, robot, q = found["impact"], found["robot"], found["q"]
    a, b = impact.bodies["a/car"], impact.bodies["b/car"]
    assert a.dv_com == pytest.approx(-b.dv_com, abs=1e-13)
    # About the point of contact no moment acts: I dω + r × m dv = 0 for each car.
    for name, at, jump in (("a/car", found["CORNER"], a), ("b/car", found["DOOR"], b)):
        placement = robot.placement(q, name)
        arm = placement.position - placement.point(at)
        moment = 2936.25 * jump.domega + np.cross(arm, 1500.0 * jump.dv_com)
        assert moment[2] == pytest.approx(0.0, abs=1e-9)
    door = impact.contacts["door"]
    normal = door.points[0].normal
    assert normal @ door.velocity_after == pytest.approx(-0.1 * normal @ door.velocity_before)
    assert impact.contacts["door"].gap == pytest.approx(0.0, abs=1e-15)


def test_the_golf_ball_leaves_as_two_effective_masses_say():
    found = ran("golf_swing")
    impact, robot, q = found["impact"], found["robot"], found["q"]
    face = impact.contacts["face"]
    normal = face.points[0].normal
    approach, parting = (normal @ u for u in (face.velocity_before, face.velocity_after))
    assert parting == pytest.approx(-0.83 * approach, rel=1e-12)
    # What ball and club get is equal and opposite; along the shaft only the pin takes part.
    ball = 0.04593 * impact.bodies["ball/ball"].dv_com
    assert ball == pytest.approx(face.impulse, abs=1e-13)
    at = -found["RADIUS"] * found["normal"]
    head = ik.design.impact_ellipsoid(robot, q, "golfer/head", found["face"]).mobility
    free = ik.design.impact_ellipsoid(robot, q, "ball/ball", at).mobility
    jump = face.velocity_after - face.velocity_before
    assert (head + free) @ face.impulse == pytest.approx(jump, abs=1e-11)


def test_the_hand_gets_the_energy_of_the_reduced_mass():
    found = ran("arm_against_hand")
    speed = found["speed"]
    assert found["masses"][1] == pytest.approx(0.6, rel=1e-12)
    wanted = 0.5 * found["reduced"] * speed @ speed
    assert found["lost"] == pytest.approx(wanted, rel=1e-11)
    impulse = np.linalg.norm(found["impact"].contacts["hand"].impulse)
    assert impulse == pytest.approx(found["reduced"] * np.linalg.norm(speed), rel=1e-11)
