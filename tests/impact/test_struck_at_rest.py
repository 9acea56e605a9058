"""What rests and is struck gains no energy: its velocities before are zero, so work is rounding."""

import numpy as np
import pytest

import impulsekit as ik

from ..robots import one_body

BOX = one_body("box", 2, 0.1)
AT_REST = BOX.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1])
CORNERS = [(x, y, -0.05) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
LAWS = [
    {},
    {"restitution": "poisson"},
    {"order": "sequential"},
    {"slip": "path"},
    {"restitution": "stronge", "slip": "path"},
    {"restitution": "lzb"},
]
DRAWS = 25


def blows(seed, draws=DRAWS):
    """Mostly downwards, small and large, within the box."""
    rng = np.random.default_rng(seed)
    for _ in range(draws):
        size = rng.choice([1e-6, 0.05, 1.0])
        linear = np.array([0.1, 0.1, 1.0]) * rng.normal(size=3) * size
        yield ik.AppliedImpulse("box", linear, at=[*rng.uniform(-0.1, 0.1, 2), 0.0])


def statuses(contacts, law=None, **more):
    found = set()
    for blow in blows(len(contacts)):
        scene = ik.Scene(BOX, [blow], contacts=contacts, law=ik.Law(**(law or {})), **more)
        impact = ik.solve(scene, AT_REST, BOX.velocity())
        found.add(impact.status.name)
    return found


@pytest.mark.parametrize("law", LAWS, ids=lambda law: "-".join(law.values()) or "newton")
@pytest.mark.parametrize("count", [1, 2, 4])
def test_a_box_on_its_corners_gains_no_energy(law, count):
    more = {"stiffness": 1e5} if law.get("restitution") == "lzb" else {}
    feet = [ik.Contact("box", at=at, friction=0.5, restitution=0.3, **more) for at in CORNERS]
    if "slip" in law and count > 1:
        pytest.skip("follows one contact by itself")
    assert statuses(feet[:count], law) <= {"SOLVED"}


def test_nor_without_friction_nor_where_it_resists_rolling_nor_where_it_adheres():
    for more in ({}, {"friction": 0.5, "rolling": 0.01, "torsion": 0.01}, {"adhesion": 0.3}):
        feet = [ik.Contact("box", at=at, **more) for at in CORNERS]
        assert "ENERGY_GAIN" not in statuses(feet)


def test_nor_where_a_point_of_it_is_pinned():
    pin = ik.PointAnchor("box", at=CORNERS[0])
    feet = [ik.Contact("box", at=at, friction=0.5) for at in CORNERS[1:]]
    assert statuses(feet, constraints=[pin]) <= {"SOLVED"}


@pytest.mark.parametrize("friction", [(0.9, 0.3), ik.FrictionTable([0.0, 1e-6], [0.9, 0.3])])
@pytest.mark.parametrize("count", [1, 4])
def test_static_friction_holds_what_rests(friction, count):
    """Pushed down by 1 and aside by less than 0.9 N s at the floor: it stays."""
    places = CORNERS if count > 1 else [(0.0, 0.0, -0.05)]
    feet = [ik.Contact("box", at=at, friction=friction) for at in places]
    rng = np.random.default_rng(count)
    for _ in range(DRAWS):
        aside = rng.normal(size=2)
        aside *= rng.uniform(0.4, 0.85) / np.hypot(*aside)
        blow = ik.AppliedImpulse("box", [*aside, -1.0], at=(0.0, 0.0, -0.05))
        impact = ik.solve(ik.Scene(BOX, [blow], contacts=feet), AT_REST, BOX.velocity())
        assert impact.is_valid()
        assert np.abs(impact.v_after).max() < 1e-12
        assert {point.mode for found in impact.contacts for point in found.points} == {"sticking"}


@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize("stiffness", [1e3, 1e5, 1e6])
def test_a_ball_hit_on_its_cloth_comes_to_an_end(stiffness, friction):
    """Both rest on sprung cloth, without load at first; the hit shares 1 m/s as (1 ± 0.95)/2."""
    radius, mass = 0.028575, 0.17
    ball = one_body("ball", mass, 0.4 * mass * radius**2)
    balls = ik.combine(first=ball, second=ball)
    cloth = [
        ik.Contact(
            f"{name}/ball", at=[0, 0, -radius], restitution=0.5, friction=friction,
            stiffness=stiffness,
        )
        for name in ("first", "second")
    ]  # fmt: skip
    hit = ik.Contact(
        "second/ball", at=[-radius, 0, 0], normal=[1, 0, 0], origin=[radius, 0, 0],
        against="first/ball", restitution=0.95, friction=0.3 * friction, stiffness=1e6,
    )  # fmt: skip
    places = {"first/root_joint": [0, 0, radius], "second/root_joint": [2 * radius, 0, radius]}
    q = balls.configuration(**{name: [*at, 0, 0, 0, 1] for name, at in places.items()})
    v = balls.velocity(**{"first/root_joint": [1, 0, 0, 0, 1 / radius, 0]})
    impact = ik.solve(ik.Scene(balls, contacts=[*cloth, hit], law=ik.Law("lzb")), q, v)
    assert impact.status is ik.Status.SOLVED
    along = impact.v_after[[0, 6]]
    assert along == pytest.approx([0.025, 0.975], abs=1e-12 if friction == 0.0 else 0.02)
