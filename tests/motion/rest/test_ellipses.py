"""Motions with friction by direction, against integrations of Goyal's law and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text

G = 9.81
ALONG = np.array([1.0, 2.0, 0.0]) / np.sqrt(5.0)
TURN = np.array([[ALONG[0], -ALONG[1]], [ALONG[1], ALONG[0]]])


def link(name, mass=2.0, inertia=0.01, shape=""):
    return link_text(name, mass, inertia, shape=shape)


BLOCK = ik.Robot.from_urdf(f'<robot name="block">{link("block")}</robot>', root="freeflyer")


def slid(friction, v, duration, gravity=(0, 0, -G), **more):
    floor = ik.Contact("block", friction=friction, name="floor")
    scene = ik.Scene(BLOCK, contacts=[floor], gravity=gravity, **more)
    return ik.simulate(
        scene, BLOCK.neutral(), BLOCK.velocity(root_joint=v), duration=duration, accuracy="high"
    )


def friction_on(slip, load, first, second):
    """(2,) the force of maximal dissipation: −P_n (µ₁² ξ₁, µ₂² ξ₂)/√(µ₁² ξ₁² + µ₂² ξ₂²)."""
    own = TURN.T @ slip
    return (
        -load * (TURN @ (np.array([first, second]) ** 2 * own)) / np.hypot(*(own * [first, second]))
    )


@pytest.mark.parametrize("second", [0.1, 0.001, 0.0])
def test_a_slide_over_a_ribbed_floor_turns_as_the_law_says(second):
    motion = slid(ik.EllipticFriction(0.3, second, along=ALONG), [1.2, 1.6, 0, 0, 0, 0], 0.4)

    def rates(t, y):
        return [*y[2:], *friction_on(y[2:], G, 0.3, second)]

    start = [0, 0, 1.2, 1.6]
    truth = solve_ivp(rates, (0, 0.4), start, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    q, v = motion.at(0.4)
    assert motion.status.name == "FINISHED"
    assert np.concatenate([q[:2], v[:2]]) == pytest.approx(truth, abs=1e-10)
    expected = friction_on(truth[2:], 2 * G, 0.3, second)
    assert motion.contacts["floor"].force(0.4) == pytest.approx([*expected, 2 * G], abs=1e-8)


def test_a_skate_runs_along_its_blade_and_not_across():
    motion = slid(ik.EllipticFriction(0.0, 0.6, along=ALONG), [0, 0, 0, 0, 0, 0], 0.5, (1, 0, -G))
    assert motion.v[-1][:2] == pytest.approx(0.5 * ALONG[0] * ALONG[:2], abs=1e-9)


@pytest.mark.parametrize(("share", "holds"), [(0.999, True), (1.001, False)])
def test_it_holds_inside_the_ellipse(share, holds):
    """Gravity leans by a share of (µ₁ cos φ, µ₂ sin φ)."""
    lean = share * G * (TURN @ [0.3 * np.cos(0.7), 0.1 * np.sin(0.7)])
    friction = ik.EllipticFriction(0.3, 0.1, along=ALONG)
    motion = slid(friction, np.zeros(6), 0.2, (*lean, -G))
    assert (np.abs(motion.v[-1]).max() < 1e-12) == holds


def test_ribs_turn_with_the_plate_that_has_them():
    """A plate that spins at Ω carries its ribs: a block held to its rail feels them turn."""
    table = ik.Robot.from_urdf(
        robot_text(
            "t",
            *(link_text("base"), link("plate", 1.0, 1.0), link("cart"), link("shoe", 2.0)),
            joint_text("spin", "continuous", "base", "plate", "0 0 1"),
            joint_text("rail", "prismatic", "base", "cart", "1 0 0", far=9),
            joint_text("guide", "prismatic", "cart", "shoe", "0 0 1", far=9),
        )
    )
    rate = 0.5
    friction = ik.EllipticFriction(0.3, 0.1)
    plane = ik.Contact("shoe", against="plate", friction=friction, name="plane")
    turning = ik.Driven("spin", lambda t: rate * t)
    scene = ik.Scene(table, contacts=[plane], constraints=[turning])
    motion = ik.simulate(
        scene,
        table.configuration(rail=[0.2]),
        table.velocity(spin=[rate], rail=[1.0]),
        0.3,
        accuracy="high",
    )

    def rates(t, y):
        x, u = y
        slip = np.array([u, -rate * x])
        c, s = np.cos(rate * t), np.sin(rate * t)
        ribs = np.array([[c, -s], [s, c]])
        own = ribs.T @ slip
        force = -2 * G * ribs @ (np.array([0.09, 0.01]) * own) / np.hypot(*(own * [0.3, 0.1]))
        return [u, force[0] / 4.0]

    truth = solve_ivp(rates, (0, 0.3), [0.2, 1.0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    q, v = motion.at(0.3)
    rail = table.model.joints[table.joint_id("rail")]
    assert [q[rail.idx_q], v[rail.idx_v]] == pytest.approx(truth, abs=1e-9)
