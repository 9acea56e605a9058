"""Transient contact with a person against springs followed in time and a table out of the house."""

import math

import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from impulsekit.compliance import ISO_TS_15066, BodyRegion, transient_contact
from impulsekit.models import pendulum_urdf

ROD = ik.Robot.from_urdf(pendulum_urdf(1))


def test_energy_and_force_are_those_of_two_masses_on_a_spring():
    """A rod of 1 kg and 1 m strikes with its tip, 1/3 kg there, against 0.6 kg on 75 kN/m."""
    found = transient_contact(
        ROD, [0.0], [4.5], "link_1", at=[0, 0, -1], body="hand", area=1e-4
    )  # fmt: skip
    assert found.robot_mass == pytest.approx(1 / 3, rel=1e-12)
    assert found.speed == pytest.approx(4.5, rel=1e-12)
    m, M, k = 1 / 3, 0.6, 75e3
    way = solve_ivp(
        lambda t, y: [y[1] - y[2], -k * y[0] / m, k * y[0] / M],
        [0, math.pi / math.sqrt(k * (1 / m + 1 / M))], [0, 4.5, 0], rtol=1e-11, atol=1e-14,
        dense_output=True,
    )  # fmt: skip
    middle = way.sol(0.5 * way.t[-1])
    assert found.force == pytest.approx(k * middle[0], rel=1e-8)
    assert found.energy == pytest.approx(0.5 * k * middle[0] ** 2, rel=1e-8)
    assert found.pressure == pytest.approx(found.force / 1e-4)
    assert not found.within_limits
    slow = transient_contact(
        ROD, [0.0], [0.999 * found.permitted_speed], "link_1", at=[0, 0, -1], body="hand", area=1e-4
    )
    assert slow.within_limits and slow.permitted_speed == pytest.approx(found.permitted_speed)


def test_the_limits_are_those_of_the_standard():
    """ISO/TS 15066:2016, tables A.2 and A.3, as the standard prints them: kg, N/mm, N, N/cm²."""
    printed = {
        "skull": (4.4, 150, 130, 110), "face": (4.4, 75, 65, 110), "neck": (1.2, 50, 150, 140),
        "back": (40, 35, 210, 160), "chest": (40, 25, 140, 120), "abdomen": (40, 10, 110, 140),
        "pelvis": (40, 25, 180, 210), "upper arm": (3, 30, 150, 190),
        "forearm": (2, 40, 160, 180), "hand": (0.6, 75, 140, 190), "thigh": (75, 50, 220, 220),
        "lower leg": (75, 60, 130, 210),
    }  # fmt: skip
    assert printed.keys() == ISO_TS_15066.keys()
    for name, row in printed.items():
        region = ISO_TS_15066[name]
        own = region.mass, region.stiffness / 1e3, region.force, region.pressure / 1e4
        assert own == pytest.approx(row)
        assert region.transient == (1.0 if name in ("skull", "face") else 2.0)
        assert "15066" in region.source


def test_the_pose_and_held_joints_count():
    arm = ik.Robot.from_example("panda")
    q, v = arm.configuration(panda_joint4=-1.5), arm.velocity(panda_joint1=0.5)
    free = transient_contact(arm, q, v)
    held = transient_contact(ik.Scene(arm, controlled=["panda_joint1"]), q, v, free.frame)
    assert held.robot_mass > free.robot_mass and held.force > free.force
    other = transient_contact(arm, arm.configuration(panda_joint4=-2.8), v, free.frame)
    assert other.robot_mass != pytest.approx(free.robot_mass, rel=1e-3)
    own = BodyRegion("dummy", mass=1e6, stiffness=1e4, force=1.0, pressure=1e4)
    assert transient_contact(arm, q, v, body=own).force_limit == 2.0
