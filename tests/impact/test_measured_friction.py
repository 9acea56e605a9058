"""Static and kinetic µ, µ by slip speed and by direction, at impacts, by closed forms."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ..robots import one_body

BOX = one_body("block", 2, 1)
M = 2.0


def struck(blow, friction, v=(0, 0, -1.0), **more):
    """A block on rails of rotation: its mass centre meets the floor."""
    floor = ik.Contact("block", friction=friction, **more)
    scene = ik.Scene(BOX, [ik.AppliedImpulse("block", linear=blow)], contacts=[floor])
    return ik.solve(scene, BOX.neutral(), BOX.velocity(root_joint=[*v, 0, 0, 0]))


@pytest.mark.parametrize(
    ("push", "left"), [(1.1, 0.0), (1.3, (1.3 - 0.3 * 2) / 2), (0.7, 0.0), (3.0, (3 - 0.6) / 2)]
)
def test_static_and_kinetic(push, left):
    """P_n = 2 N s: it sticks up to 1.2 N s along the floor, and slips against 0.6."""
    for friction in ((0.6, 0.3), ik.StaticKinetic(0.6, 0.3)):
        impact = struck([push, 0, 0], friction)
        assert impact.is_valid() and impact.v_after[0] == pytest.approx(left, abs=1e-12)
        assert impact.contacts[0].mode == ("sliding" if left else "sticking")
        assert abs(impact.energy.imbalance) < 1e-13 and ik.check(impact).agrees


def test_by_slip_speed():
    """m (u − u⁻) = −µ(u) P_n with µ = .6 − .3 u: u (m − .3 P_n) = m u⁻ − .6 P_n."""
    table = ik.FrictionTable([0.0, 1.0], [0.6, 0.3])
    speed = (M * 1.0 - 0.6 * 2.0) / (M - 0.3 * 2.0)
    for friction in (table, lambda u: 0.6 - 0.3 * min(u, 1.0)):
        impact = struck([0, 0, 0], friction, v=(0.6, 0.8, -1.0))
        assert impact.is_valid()
        assert impact.v_after[:2] == pytest.approx(speed * np.array([0.6, 0.8]), abs=1e-12)
        assert impact.outcome.contacts.friction[0] == pytest.approx(0.6 - 0.3 * speed, rel=1e-12)
    assert struck([0, 0, 0], table, v=(0.5, 0, -1.0)).v_after[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0])
def test_by_direction(angle):
    """Slip is opposed along (µ₁² ξ₁, µ₂² ξ₂)/√(µ₁² ξ₁² + µ₂² ξ₂²) in axes of a turned floor."""
    floor = ik.Robot.from_urdf("models/floor.urdf")
    turned = pin.SE3(pin.rpy.rpyToMatrix(0, 0, angle), np.zeros(3))
    world = ik.combine(a=BOX, floor=floor, placements={"floor": turned})
    ribs = ik.EllipticFriction(0.5, 0.1, along=[1, 0, 0.3])
    contact = ik.Contact("a/block", against="floor/floor", friction=ribs)
    v = world.velocity({"a/root_joint": [2.0, 1.0, -1.0, 0, 0, 0]})
    impact = ik.solve(ik.Scene(world, contacts=[contact]), world.neutral(), v)
    point = impact.contacts[0].points[0]
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    slip, P = turn.T @ point.velocity_after[:2], turn.T @ point.impulse[:2]
    mu = np.array([0.5, 0.1])
    assert impact.is_valid() and point.mode == "sliding"
    wanted = -2.0 * mu**2 * slip / np.linalg.norm(mu * slip)
    assert pytest.approx(wanted, rel=1e-9) == P
    assert np.linalg.norm(P / mu) == pytest.approx(2.0, rel=1e-12)
    held = struck([0, 0, 0], ik.EllipticFriction(5.0, 4.0), v=(2.0, 1.0, -1.0))
    assert held.contacts[0].mode == "sticking" and np.abs(held.v_after).max() < 1e-12


def test_four_boxes():
    """DART's boxes under a pull along x and y: full friction, none, one axis without, the other.

    What the pull along an axis without friction moves goes on; along the other it is held.
    """
    pulls = np.array([0.5, 0.3, 0.0])
    for friction, moves in (
        (1.0, (False, False)),
        (0.0, (True, True)),
        (ik.EllipticFriction(0.0, 1.0), (True, False)),
        (ik.EllipticFriction(1.0, 0.0), (False, True)),
    ):
        v = struck(pulls, friction).v_after[:2]
        assert v == pytest.approx(np.where(moves, pulls[:2] / M, 0.0), abs=1e-12)


def test_what_adheres_slips_by_its_kinetic_friction_while_it_is_pulled():
    """P_n = −1 of at most 3 N s: |P_t| = µ (P_n + 3), of slip µ_k; by speed its own µ."""
    for friction in ((0.8, 0.2), ik.FrictionTable([0.0, 1e-9], [0.8, 0.2])):
        impact = struck([3.0, 0, 1.0], friction, v=(0, 0, 0), adhesion=3.0)
        contact = impact.contacts[0]
        assert impact.is_valid() and contact.mode == "sliding"
        assert contact.impulse == pytest.approx([-0.2 * 2.0, 0, -1.0], abs=1e-12)


def test_adhesion_beside_a_contact_that_resists_turning():
    """It slides on what turns hard, held down beside it: the moment takes the spin there is."""
    contacts = [
        ik.Contact("block", adhesion=5.0, name="cup"),
        ik.Contact("block", torsion=0.1, name="pad"),
    ]
    scene = ik.Scene(BOX, [ik.AppliedImpulse("block", linear=[0, 0, 1.0])], contacts=contacts)
    impact = ik.solve(scene, BOX.neutral(), BOX.velocity(root_joint=[0, 0, -1.0, 0, 0, 0.05]))
    # Both push or pull with 1 N s in all; the pad's share says how much spin it takes.
    total = impact.contacts["cup"].impulse[2] + impact.contacts["pad"].impulse[2]
    assert total == pytest.approx(1.0, abs=1e-12) and impact.v_after[2] == pytest.approx(0.0)
    assert abs(impact.energy.imbalance) < 1e-13 and ik.check(impact).agrees


def test_tables_are_the_cores(monkeypatch):
    """Once a scene is known, states and motions by tables call nothing of Python's."""
    from impulsekit.models import pendulum_urdf

    def fail(*_):
        raise AssertionError("a table was called")

    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    slow = ik.FrictionTable([0.0, 1.0], [0.6, 0.2])
    floor = ik.Contact("ball", restitution=0.5, friction=slow)
    scene = ik.Scene(ball, contacts=[floor], gravity=[0, 0, -9.81])
    arm = ik.Robot.from_urdf(pendulum_urdf(1))
    motor = ik.Scene(arm, forces=[ik.Actuator("joint_1", ik.TorqueTable([0, 1], [1, 3]))])
    q, v = ball.neutral(), np.array([0.4, 0, -1.0, 0, 2.0, 0])
    known = ik.solve_batch(scene, q, [v, v]).v_after
    ik.simulate(scene, q, v, duration=0.4)
    monkeypatch.setattr(ik.FrictionTable, "__call__", fail)
    monkeypatch.setattr(ik.TorqueTable, "__call__", fail)
    np.testing.assert_array_equal(ik.solve_batch(scene, q, [v, v]).v_after, known)
    assert ik.simulate(scene, q, v, duration=0.4).status.finished
    motion = ik.simulate(motor, [0.0], [0.0], duration=1.0)
    np.testing.assert_allclose(motion.forces["forces[0]"].force(0.5), 2.0)
