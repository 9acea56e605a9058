"""Contacts on robots: what the laws say, in the coordinates of a scene."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import impulsekit as ik
from impulsekit import errors
from impulsekit.impact import ImpactSolver
from impulsekit.impact.freed import freed_joint
from tests.robots import random_blow, random_state, relative

RADIUS = 0.05  # of models/ball.urdf
FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")


@pytest.fixture(scope="module")
def ball() -> ik.Robot:
    return ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


@pytest.fixture(scope="module")
def solo() -> ik.Robot:
    return ik.Robot.from_example("solo12", root="freeflyer")


def landing(robot: ik.Robot, law: ik.Law | None = None, **coefficients: float) -> ik.Scene:
    """Solo12 with four feet on the ground."""
    contacts = [ik.Contact(foot, **coefficients) for foot in FEET]
    return ik.Scene(robot, contacts=contacts, law=law or ik.Law())


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("theta", [0.0, 0.4, 1.0, 1.4])
def test_a_falling_rod_meets_the_floor(theta, e):
    """P = (1 + e) m v / (1 + 3 cos²θ), with θ the slope of the rod."""
    mass, length, speed = 1.3, 0.7, 2.1
    rod = ik.Robot.from_urdf(ik.models.chain_urdf(1, mass, length), root="planar")
    # The floor is the line y = 0 of the rod's plane; its far end is lowest.
    q = rod.configuration(root_joint=[0.0, length * math.sin(theta), -theta])
    turned = np.array([[math.cos(-theta), math.sin(-theta)], [-math.sin(-theta), math.cos(-theta)]])
    v = np.array([*(turned @ [0.0, -speed]), 0.0])
    floor = ik.Contact("link_1", at=[length, 0, 0], normal=[0, 1, 0], restitution=e)
    impact = ik.solve(ik.Scene(rod, contacts=[floor]), q, v)
    exact = (1 + e) * mass * speed / (1 + 3 * math.cos(theta) ** 2)
    np.testing.assert_allclose(impact.contacts[0].impulse, [0, exact, 0], atol=1e-13 * exact)
    assert impact.contacts[0].velocity_after[1] == pytest.approx(e * speed, abs=1e-13)


@pytest.mark.parametrize("mu", [0.0, 0.05, 0.11, 0.13, 0.5])
def test_a_ball_slips_or_rolls_away(ball, mu):
    """It slips below µ = (2/7) |v_t| / ((1 + e) |v_n|) and rolls with 5/7 v_t above."""
    e, across, down = 0.5, 1.3, 2.0
    floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=e, friction=mu)
    v = ball.velocity(root_joint=[across, 0, -down, 0, 0, 0])
    impact = ik.solve(ik.Scene(ball, contacts=[floor]), ball.neutral(), v)
    critical = 2 / 7 * across / ((1 + e) * down)
    if mu < critical:
        expected, mode = across - mu * (1 + e) * down, "sliding"
    else:
        expected, mode = 5 / 7 * across, "sticking"
    assert impact.v_after[0] == pytest.approx(expected, abs=1e-14)
    assert impact.contacts[0].mode == mode
    assert impact.energy.change < 0.0
    assert impact.energy.imbalance < 1e-14


def test_a_superball_comes_back_with_three_sevenths(ball):
    floor = ik.Contact(
        "ball", at=[0, 0, -RADIUS], restitution=1.0, friction=10.0, tangential_restitution=1.0
    )
    v = ball.velocity(root_joint=[1, 0, -1, 0, 0, 0])
    impact = ik.solve(ik.Scene(ball, contacts=[floor]), ball.neutral(), v)
    assert impact.v_after[0] == pytest.approx(3 / 7, abs=1e-14)
    assert impact.energy.change == pytest.approx(0.0, abs=1e-14)


def test_a_contact_that_parts_gets_nothing(ball):
    floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=0.5, friction=0.5)
    impact = ik.solve(
        ik.Scene(ball, contacts=[floor]),
        ball.neutral(),
        ball.velocity(root_joint=[1, 0, 0.1, 0, 0, 0]),
    )
    assert not impact.dv.any()
    assert impact.contacts[0].mode == "separated"
    assert impact.is_valid()


def test_a_blow_and_a_floor_in_one_instant(ball):
    """A ball at rest on the floor, struck from above: the floor takes all of it."""
    blow = ik.AppliedImpulse("ball", linear=[0.3, 0, -2.0])
    floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=0.9)
    impact = ik.solve(ik.Scene(ball, [blow], contacts=[floor]), ball.neutral(), ball.velocity())
    np.testing.assert_allclose(impact.contacts[0].impulse, [0, 0, 2.0], atol=1e-15)
    np.testing.assert_allclose(impact.v_after[:3], [0.3 / 0.5, 0, 0], atol=1e-15)


def test_a_slope_in_any_direction_is_a_floor_seen_slanted(ball):
    """Turn floor, point and velocity together: the answer turns with them."""
    floor = {"restitution": 0.4, "friction": 0.2}
    v = np.array([1.0, 0.3, -2.0])
    level = ik.solve(
        ik.Scene(ball, contacts=[ik.Contact("ball", at=[0, 0, -RADIUS], **floor)]),
        ball.neutral(),
        np.array([*v, 0, 0, 0]),
    )
    rng = np.random.default_rng(0)
    for _ in range(10):
        turn = pin.exp3(rng.normal(size=3))
        slope = ik.Contact("ball", at=turn @ [0, 0, -RADIUS], normal=turn[:, 2], **floor)
        impact = ik.solve(
            ik.Scene(ball, contacts=[slope]), ball.neutral(), np.array([*(turn @ v), 0, 0, 0])
        )
        for part in (slice(0, 3), slice(3, 6)):
            np.testing.assert_allclose(impact.v_after[part], turn @ level.v_after[part], atol=1e-13)


def test_a_plane_may_be_carried_by_another_body(ball):
    """A ball on a moving table sees the table's velocity and gives it the reverse impulse."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    world = ik.combine(ball=ball, table=box)
    height = 0.05
    q = world.configuration({"ball/root_joint": [0.02, 0.01, height + RADIUS, 0, 0, 0, 1]})
    v = world.velocity(
        {"ball/root_joint": [0, 0, -1, 0, 0, 0], "table/root_joint": [0, 0, 0.5, 0, 0, 0]}
    )
    e = 0.6
    contact = ik.Contact(
        "ball/ball", at=[0, 0, -RADIUS], against="table/box", origin=[0, 0, height], restitution=e
    )
    impact = ik.solve(ik.Scene(world, contacts=[contact]), q, v)
    result = impact.contacts[0]
    assert result.velocity_before[2] == pytest.approx(-1.5)
    assert result.velocity_after[2] == pytest.approx(1.5 * e)
    masses = {link.name: link.mass for link in world.links}
    momentum = sum(masses[name] * impact.bodies[name].dv_com for name in masses)
    np.testing.assert_allclose(momentum, 0.0, atol=1e-15)
    np.testing.assert_allclose(
        masses["ball/ball"] * impact.bodies["ball/ball"].dv_com, result.impulse, atol=1e-15
    )


def test_a_fixed_point_against_a_moving_plane(ball):
    """The same pair seen from the other side: the world strikes the ball."""
    v = ball.velocity(root_joint=[0.4, 0, -2, 0, 0, 0])
    coefficients = {"restitution": 0.5, "friction": 0.3}
    usual = ik.Contact("ball", at=[0, 0, -RADIUS], **coefficients)
    turned = ik.Contact(
        "world", at=[0, 0, -RADIUS], against="ball", normal=[0, 0, -1], **coefficients
    )
    a, b = (
        ik.solve(ik.Scene(ball, contacts=[contact]), ball.neutral(), v)
        for contact in (usual, turned)
    )
    np.testing.assert_allclose(a.v_after, b.v_after, atol=1e-14)
    np.testing.assert_allclose(a.contacts[0].impulse, -b.contacts[0].impulse, atol=1e-14)


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_four_feet_land_and_none_pulls(solo, e):
    """Every foot keeps Newton's law with its own coefficient, and Coulomb's cone."""
    mu = 0.6
    q, _ = random_state(solo, 0)
    q[:7] = [0, 0, 0.3, 0, 0, 0, 1]
    v = solo.velocity(root_joint=[0.5, 0.2, -1.0, 0.3, -0.2, 0.1])
    impact = ik.solve(landing(solo, restitution=e, friction=mu), q, v)
    assert impact.is_valid()
    for foot in impact.contacts:
        target = -e * min(foot.velocity_before[2], 0.0)
        assert foot.impulse[2] >= 0.0
        assert np.hypot(*foot.impulse[:2]) <= mu * foot.impulse[2] * (1 + 1e-12)
        assert foot.velocity_after[2] >= target - 1e-10
        assert foot.impulse[2] * (foot.velocity_after[2] - target) < 1e-10
        if foot.mode == "sliding":
            slip = foot.velocity_after[:2]
            expected = -mu * foot.impulse[2] * slip / np.linalg.norm(slip)
            np.testing.assert_allclose(foot.impulse[:2], expected, atol=1e-8)
        elif foot.mode == "sticking":
            np.testing.assert_allclose(foot.velocity_after[:2], 0.0, atol=1e-10)
    total = sum(foot.impulse for foot in impact.contacts)
    momentum = sum(link.mass * impact.bodies[link.name].dv_com for link in solo.links)
    np.testing.assert_allclose(total, momentum, atol=1e-12)


def test_the_order_of_contacts_does_not_matter_at_once(solo):
    q, v = random_state(solo, 1)
    v[2] = -2.0
    contacts = [ik.Contact(foot, restitution=0.3, friction=0.4) for foot in FEET]
    forth = ik.solve(ik.Scene(solo, contacts=contacts), q, v)
    back = ik.solve(ik.Scene(solo, contacts=contacts[::-1]), q, v)
    np.testing.assert_allclose(forth.v_after, back.v_after, atol=1e-9)


def test_a_robot_a_kilometre_away_lands_the_same(solo):
    q, v = random_state(solo, 2)
    far = q.copy()
    far[:3] += [1000.0, -500.0, 300.0]
    scene = landing(solo, restitution=0.2, friction=0.5)
    np.testing.assert_allclose(
        ik.solve(scene, far, v).v_after, ik.solve(scene, q, v).v_after, atol=1e-9
    )


def test_a_box_on_four_corners_shares_its_load():
    """Twelve rows of rank six: the resultant is one, the split is not."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    half = np.array([0.15, 0.10, 0.05])
    corners = [[x, y, -half[2]] for x in (-half[0], half[0]) for y in (-half[1], half[1])]
    e, speed = 0.4, 1.5
    contacts = [ik.Contact("box", at=corner, restitution=e, friction=0.3) for corner in corners]
    v = box.velocity(root_joint=[0, 0, -speed, 0, 0, 0])
    impact = ik.solve(ik.Scene(box, contacts=contacts), box.neutral(), v)
    assert impact.status is ik.Status.SOLVED
    assert impact.is_valid()
    assert not any(corner.unique for corner in impact.contacts)
    total = sum(corner.impulse for corner in impact.contacts)
    np.testing.assert_allclose(total, [0, 0, box.mass * (1 + e) * speed], atol=1e-12)
    np.testing.assert_allclose(impact.v_after, [0, 0, e * speed, 0, 0, 0], atol=1e-13)
    # No split is wrong, but one that is far from the symmetry of the box would be odd.
    normals = [corner.impulse[2] for corner in impact.contacts]
    np.testing.assert_allclose(normals, total[2] / 4, rtol=1e-6)


def test_contacts_with_a_stance_foot_and_a_locked_joint(solo):
    """Constraints hold, contacts keep their law, and the books of energy close."""
    q, v = random_state(solo, 3)
    v[2] = -2.0
    scene = ik.Scene(
        solo,
        [random_blow("base_link", 1)],
        constraints=[ik.PointAnchor("FL_FOOT"), ik.JointLock("FR_KFE", velocity="kept")],
        contacts=[ik.Contact(foot, restitution=0.3, friction=0.5) for foot in FEET[1:]],
    )
    impact = ik.solve(scene, q, v)
    assert impact.is_valid()
    np.testing.assert_allclose(impact.constraints[0].velocity_after, 0.0, atol=1e-12)
    lock = impact.constraints[1]
    np.testing.assert_allclose(lock.velocity_after, lock.velocity_before, atol=1e-12)
    for foot in impact.contacts:
        target = -0.3 * min(foot.velocity_before[2], 0.0)
        assert foot.impulse[2] >= 0.0
        assert foot.velocity_after[2] >= target - 1e-10
        assert foot.impulse[2] * (foot.velocity_after[2] - target) < 1e-10
    assert impact.energy.imbalance < 1e-12
    total = sum(impact.impulse_shares.values())
    assert relative(impact.mechanics.mass_matrix @ impact.dv - total, total) < 1e-12


def test_reactions_count_contacts_in(solo):
    q, v = random_state(solo, 4)
    v[2] = -2.0
    impact = ik.solve(landing(solo, restitution=0.2, friction=0.5), q, v)
    for joint in solo.joint_names:
        freed = freed_joint(impact, joint).impulse
        np.testing.assert_allclose(impact.reactions[joint], freed, atol=1e-12)
    # Nothing holds a floating base.
    np.testing.assert_allclose(impact.reactions["root_joint"], 0.0, atol=1e-12)


def test_restitution_may_fall_with_the_approach_speed(ball):
    v = ball.velocity(root_joint=[0, 0, -0.5, 0, 0, 0])
    for restitution, expected in (
        (ik.Restitution(0.8, capture_speed=0.4), 0.8),
        (ik.Restitution(0.8, capture_speed=0.6), 0.0),
        (ik.RestitutionTable([0, 1], [1.0, 0.0]), 0.5),
        (lambda speed: 1.0 - speed, 0.5),
    ):
        floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=restitution)
        impact = ik.solve(ik.Scene(ball, contacts=[floor]), ball.neutral(), v)
        assert impact.v_after[2] == pytest.approx(0.5 * expected, abs=1e-15)


def test_a_function_that_gives_no_coefficient_is_refused(ball):
    floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=lambda speed: 2.0)
    with pytest.raises(errors.RangeError, match=r"contacts\[0\]: restitution at 0.5"):
        ik.solve(
            ik.Scene(ball, contacts=[floor]),
            ball.neutral(),
            ball.velocity(root_joint=[0, 0, -0.5, 0, 0, 0]),
        )


def test_a_branch_that_is_not_touched_is_not_computed(ball):
    world = ik.combine(arm=ik.Robot.from_example("panda"), ball=ball)
    scene = ik.Scene(world, contacts=[ik.Contact("ball/ball", at=[0, 0, -RADIUS])])
    assert ImpactSolver(scene).plan.skipped_joints == 9
    v = world.velocity({"ball/root_joint": [0, 0, -1, 0, 0, 0], "arm/panda_joint1": 1.0})
    impact = ik.solve(scene, world.neutral(), v)
    assert impact.is_valid()
    assert not impact.dv[:9].any()
    np.testing.assert_allclose(impact.contacts[0].impulse, [0, 0, 0.5])
    assert impact.energy.imbalance < 1e-14


@pytest.mark.slow
@settings(max_examples=1000, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    seed=st.integers(0, 10**6),
    e=st.floats(0, 1),
    mu=st.floats(0, 1.5),
    law=st.sampled_from([ik.Law(), ik.Law(restitution="poisson")]),
)
@example(seed=143, e=2.2e-311, mu=1.5, law=ik.Law(restitution="poisson"))
def test_laws_of_contact_hold_over_random_landings(solo, seed, e, mu, law):
    q, v = random_state(solo, seed)
    impact = ik.solve(landing(solo, law, restitution=e, friction=mu), q, v)
    assert np.isfinite(impact.dv).all()
    if not impact.status.valid:
        return
    assert impact.residuals.largest < 1e-9
    for foot in impact.contacts:
        normal = foot.impulse[2]
        assert normal >= 0.0
        assert np.hypot(*foot.impulse[:2]) <= mu * normal + 1e-10 * (1 + normal)
        assert foot.velocity_after[2] >= -1e-9


def test_velocities_scale(solo):
    q, v = random_state(solo, 5)
    v[2] = -3.0
    scene = landing(solo, restitution=0.5, friction=0.4)
    once, thrice = ik.solve(scene, q, v), ik.solve(scene, q, 3 * v)
    np.testing.assert_allclose(thrice.dv, 3 * once.dv, rtol=1e-9, atol=1e-10)


def test_to_dict_tells_of_contacts(ball):
    import json

    floor = ik.Contact("ball", at=[0, 0, -RADIUS], restitution=0.5)
    v = ball.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    impact = ik.solve(ik.Scene(ball, contacts=[floor]), ball.neutral(), v)
    plain = json.loads(json.dumps(impact.to_dict(), allow_nan=False))
    assert plain["contacts"][0]["mode"] == "sliding"
    assert plain["contacts"][0]["points"][0]["position"] == [0.0, 0.0, -RADIUS]


@pytest.mark.parametrize(
    "law",
    [
        ik.Law(),
        ik.Law(restitution="poisson"),
        ik.Law(slip="path"),
        ik.Law(restitution="stronge", slip="path"),
        ik.Law(order="sequential"),
    ],
)
def test_the_books_close_under_every_law_with_blow_and_brake_in_the_same_instant(solo, law):
    q, v = random_state(solo, 6)
    v[2] = -2.0
    scene = ik.Scene(
        solo,
        [random_blow("base_link", 3)],
        constraints=[ik.JointLock("FR_KFE")],
        contacts=[ik.Contact("FL_FOOT", restitution=0.4, friction=0.3)],
        law=law,
    )
    impact = ik.solve(scene, q, v)
    assert impact.residuals.largest < 1e-10
    assert impact.energy.imbalance < 1e-12


def test_a_sequence_is_judged_by_the_energy_of_the_whole(solo):
    q, v = random_state(solo, 7)
    v[2] = -2.0
    scene = landing(solo, ik.Law(slip="path", order="sequential"), restitution=1.0, friction=0.5)
    impact = ik.solve(scene, q, v)
    assert (impact.status is ik.Status.ENERGY_GAIN) == (impact.energy.change > 1e-9)


@pytest.mark.parametrize("order", ["simultaneous", "sequential"])
@pytest.mark.parametrize("mu", [0.0, 0.5])
@pytest.mark.parametrize("count", [1, 2])
def test_what_is_held_wholly_bears_no_contact(count, mu, order):
    """Once a box is stopped on all sides, its contacts have nothing left to do."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    contacts = [ik.Contact("box", at=[0.1 * i, 0, -0.1], friction=mu) for i in range(count)]
    lock = ik.JointLock("root_joint")
    scene = ik.Scene(box, constraints=[lock], contacts=contacts, law=ik.Law(order=order))
    v = box.velocity(root_joint=[0.1, 0, -1, 0, 0, 0])
    impact = ik.solve(scene, box.neutral(), v)
    assert impact.status is ik.Status.SOLVED
    assert np.abs(impact.v_after).max() < 1e-15
    assert np.array([contact.impulse for contact in impact.contacts]) == pytest.approx(0, abs=0)


def test_what_is_driven_into_the_floor_has_no_answer():
    """A box that is made to sink cannot be kept out of the floor by any impulse."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    lock = ik.JointLock("root_joint", velocity=[0, 0, -1, 0, 0, 0])
    contacts = [ik.Contact("box", at=[0.1 * i, 0, -0.1], friction=0.5) for i in range(2)]
    scene = ik.Scene(box, constraints=[lock], contacts=contacts)
    impact = ik.solve(scene, box.neutral(), box.velocity())
    assert impact.status is ik.Status.NO_SOLUTION


def test_a_foot_that_holds_a_light_leg_against_a_blow_keeps_its_digits():
    """The blow alone would throw the foot at 100 m/s, beside 1 m/s in the end."""
    bolt = ik.Robot.from_example("bolt")
    blow = ik.AppliedImpulse(
        "FL_UPPER_LEG",
        linear=[0.5443270049746733, -0.8760346782620253, -1.0699530070322312],
        angular=[0.1959457413226008, 0.675752683836492, 1.2785089694847744],
        at=[0.04107028453561117, 0.027951438010951835, 0.13122548606231893],
    )
    foot = ik.Contact(
        "FL_LOWER_LEG",
        at=[0.0977853621987347, -0.12361421741189471, 0.08919070563078546],
        normal=[0.8029803074020662, -0.4186943206315798, 0.42416705647108316],
        friction=0.6,
    )
    scene = ik.Scene(bolt, [blow], contacts=[foot])
    for q, v in (
        ([0.82, 0.85, -0.73, 0.2, -1.01, -0.35], [-0.32, -0.26, -0.95, -1.64, -0.19, 0.21]),
        ([1.12, 0.66, -0.8, 0.67, 0.99, -1.11], [0.18, 1.23, 0.85, 2.06, -1.26, 0.51]),
        ([0.75, 0.83, -0.71, -0.71, 0.45, 0.53], [1.16, 0.06, -1.11, -1.24, -1.64, -1.22]),
    ):
        contact = ik.solve(scene, q, v).contacts[0]
        assert contact.mode == "sticking"
        assert np.abs(contact.velocity_after).max() < 1e-11
