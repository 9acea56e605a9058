"""Struck linkages, catches and a door, against closed forms."""

import math

import numpy as np
import pinocchio as pin
import pytest

from tests.reference.models import mass_matrix

from . import printed, solved


def about(value, rel=1e-12):
    return pytest.approx(value, rel=rel, abs=1e-14)


def effective_mass(impact, frame, direction):
    """Of a point at a frame's origin along a direction, from crba and Jacobians [kg]."""
    model = impact.scene.robot.model
    data = model.createData()
    matrix = mass_matrix(model, impact.q)
    frame_id = impact.scene.robot.frame_id(frame)
    jacobian = pin.computeFrameJacobian(model, data, impact.q, frame_id, pin.LOCAL_WORLD_ALIGNED)
    row = np.asarray(direction) @ jacobian[:3]
    return 1 / (row @ np.linalg.solve(matrix, row))


def test_four_bar():
    impact = solved("four_bar")
    # Crank and rocker are parallel: all pins move at u, the coupler does not turn, and the
    # bars count as I/l² at their moving ends.
    crank, coupler, rocker = 0.054, 0.135, 0.135  # kg
    mass = coupler
    for m, length in ((crank, 0.2), (rocker, 0.5)):
        mass += m * (4 * length**2 + 0.02**2) / 12 / length**2
    u = 1 / mass
    assert impact.v_after == about([-u / 0.2, u / 0.2, -u / 0.5])
    assert impact.velocity_at("rocker", [0, 0.5, 0]).after == about([u, 0, 0])
    assert impact.energy.after == about(u / 2)
    far_pin = impact.constraints[0]
    # What the rocker takes in at its far pin.
    rocker_share = rocker * (4 * 0.5**2 + 0.02**2) / 12 / 0.5**2
    assert far_pin.impulse[0] == about(-rocker_share * u)
    assert far_pin.unique_rows == (True, True, False)
    assert far_pin.work == pytest.approx(0, abs=1e-14)


def test_rhombus():
    impact = solved("rhombus")
    # u = P/(4 m) (1 ± 3 sin² α), with α = 45° between side and diagonal (Routh).
    mean = 1 / (4 * 0.5)
    for link, wanted in (
        ("link_1", mean * 2.5),
        ("link_3", mean * -0.5),
    ):
        assert impact.velocity_at(link).after == about([wanted, 0, 0])
    assert impact.velocity_at("link_2").after == about([mean, 0.75, 0])
    assert impact.velocity_at("link_4").after == about([mean, -0.75, 0])
    assert impact.velocity_at("link_4", [0.5, 0, 0]).after == about([mean * 2.5, 0, 0])
    assert impact.energy.after == about(0.5 * mean * 2.5)


def test_caught_ball():
    impact = solved("caught_ball")
    grip = impact.constraints[0]
    assert grip.velocity_after == pytest.approx(np.zeros(6), abs=1e-13)
    assert grip.unique
    hand = impact.velocity_at("arm/panda_hand", _tool(impact)).after
    assert impact.velocity_at("ball/ball").after == pytest.approx(hand, abs=1e-13)
    # The ball gives what the grip gives it, and Carnot's loss is all that is lost.
    assert 0.17 * impact.bodies["ball/ball"].dv_com == about(grip.impulse[:3])
    assert impact.energy.change == about(-impact.energy.of_lost_velocities)
    assert impact.energy.work["grip"] == about(impact.energy.change)
    # A point mass that sticks to the hand would lose mM/(m + M) v²/2; the real ball also
    # has to turn with the hand, and is held across.
    arm = effective_mass(impact, "arm/panda_hand_tcp", [1, 0, 0])
    least = 0.17 * arm / (0.17 + arm) * 2**2 / 2
    assert least < -impact.energy.change < impact.energy.before


def _tool(impact):
    """The ball's centre in the hand's coordinates."""
    model = impact.scene.robot.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, impact.q)
    hand, ball = (
        data.oMf[impact.scene.robot.frame_id(name)] for name in ("arm/panda_hand", "ball/ball")
    )
    return hand.actInv(ball.translation)


def test_pendulum_peg():
    impact = solved("pendulum_peg")
    assert impact.v_after == about([0, 5 / 2])
    assert impact.energy.before == about(4 / 3)
    assert impact.energy.after == about(25 / 24)
    assert -impact.energy.change == about(impact.energy.of_lost_velocities)
    # Peg and upper pin share what stops the upper rod and slows the lower one.
    peg = impact.constraints[0].impulse
    total = 1.0 * (0.5 - 0.0) + 1.0 * (1.5 - 1.25)  # kg m/s, towards +x
    assert peg[0] + impact.reactions["joint_1"][0] == about(total)


def test_stopped_door():
    impact = solved("stopped_door")
    tips = impact.constraints[0]
    inertia = 20 * ((0.9**2 + 0.04**2) / 12 + 0.45**2)
    arm = effective_mass(impact, "arm/panda_hand_tcp", [1, 0, 0])
    lever = 0.75
    door = inertia / lever**2
    # Two masses that meet and stay together: m M/(m + M) times the speed of approach.
    shared = arm * door / (arm + door)
    assert tips.impulse == about([-shared * lever], rel=1e-10)
    assert impact.v_after[-1] == about(1 - shared * lever**2 / inertia, rel=1e-10)
    assert impact.energy.change == about(-shared * lever**2 / 2, rel=1e-10)
    tip = impact.velocity_at("arm/panda_hand_tcp").after
    assert tip[0] == about(-impact.v_after[-1] * lever, rel=1e-10)
    assert np.abs(tip[1:]).max() > 0.01  # along the leaf it may slide


@pytest.mark.slow
def test_door_stop_at_the_centre_of_percussion_spares_the_hinges():
    inertia = 20 * ((0.9**2 + 0.04**2) / 12 + 0.45**2)
    rows = [[float(x) for x in line] for line in printed("door_stop")[1:]]
    assert [row[0] for row in rows] == [0.3, 0.45, 0.6, 0.75, 0.9]
    for distance, stop, hinges in rows:
        wanted = 1.3 * 2 * inertia / distance
        # The leaf's momentum jumps by m w/2 (1 + e) ω; what the stop does not give it,
        # the hinges have to.
        assert stop == pytest.approx(wanted, abs=6e-4)
        assert hinges == pytest.approx(20 * 0.45 * 1.3 * 2 - wanted, abs=6e-4)
    assert abs(rows[2][2]) < 1e-3 * rows[2][1]
    assert math.copysign(1, rows[1][2]) != math.copysign(1, rows[3][2])
