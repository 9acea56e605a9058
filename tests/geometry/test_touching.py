"""Shapes that touch: gaps, normals and points, proved by weak duality, through a solve.

A gap g with its normal n is right if two points of the shapes are g apart, so that the distance
is no more, and if along n one shape ends g above the other, so that it is no less.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from .shapes import KINDS, Shape, pair, shape_of

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")
PAIRS = [(a, b) for i, a in enumerate(KINDS) for b in KINDS[i:] if (a, b) != ("box", "box")]


def unit(x):
    return x / np.linalg.norm(x)


def placed(robot, places):
    joints = {f"{n}/free": pin.SE3ToXYZQUAT(p) for n, p in zip("ab", places, strict=True)}
    return robot.configuration(joints)


def met(robot, places, margin=1e-6, order=("a/one", "b/two")):
    """The contact of the two at rest; within a margin they count as touching."""
    scene = ik.Scene(robot, contacts=[ik.Collision(*order, margin=margin)])
    return ik.solve(scene, placed(robot, places), np.zeros(12)).contacts[0]


def random_pose(rng, ordinary):
    """Any rotation; or one that lays faces, sides and edges on each other."""
    if ordinary:
        return pin.Quaternion(*unit(rng.normal(size=4))).matrix()
    spin = pin.utils.rotate("z", rng.choice([0.0, np.pi / 4, rng.uniform(0, 6)]))
    return spin @ pin.utils.rotate("x", rng.choice([0.0, np.pi / 4, np.pi / 2, 1.0]))


@pytest.mark.parametrize("ordinary", [True, False], ids=["tumbled", "laid"])
@pytest.mark.parametrize("kinds", PAIRS, ids="-".join)
def test_gap_normal_and_points_are_right(kinds, ordinary):
    rng = np.random.default_rng(PAIRS.index(kinds))
    for _ in range(6):
        shapes = [shape_of(kind, rng) for kind in kinds]
        robot, way = pair(*shapes), unit(rng.normal(size=3) * (1.0 if ordinary else [0.2, 0.2, 1]))
        places = [pin.SE3(random_pose(rng, ordinary), s * way) for s in (1.5, 0.0)]
        places[0].translation -= (met(robot, places).gap - 0.1) * way
        apart = met(robot, places).gap
        normal = met(robot, places, apart + 1e-6).points[0].normal
        # Brought nearer along the normal, they are that far apart, and no more.
        for gap in (0.03, 0.0):
            there = [pin.SE3(places[0].rotation, places[0].translation - (apart - gap) * normal),
                     places[1]]  # fmt: skip
            contact = met(robot, there, gap + 1e-6)
            assert contact.gap == pytest.approx(gap, abs=1e-9)
            n = contact.points[0].normal
            below, above = (
                shape.reach(place.rotation.T @ (sign * n)) + sign * n @ place.translation
                for shape, place, sign in zip(shapes, there, (-1.0, 1.0), strict=True)
            )
            assert -below - above == pytest.approx(gap, abs=1e-9)
            for point in contact.points:
                for shape, place, sign in zip(shapes, there, (0.5, -0.5), strict=True):
                    own = place.actInv(point.position + sign * gap * n)
                    assert abs(shape.outside(own)) < 3e-6


@pytest.mark.parametrize(
    ("shape", "turn", "count"),
    [
        (Shape("box", (0.5, 0.5, 0.5)), np.eye(3), 4),
        (Shape("box", (0.5, 0.5, 0.5)), pin.utils.rotate("z", 0.4), 4),
        (Shape("sphere", (0.5,)), np.eye(3), 1),
        (Shape("capsule", (0.5, 0.5)), pin.utils.rotate("y", np.pi / 2), 2),
        (Shape("cylinder", (0.5, 0.5)), pin.utils.rotate("y", np.pi / 2), 2),
    ],
)
@pytest.mark.parametrize("gap", [-1e-9, 0.0, 1e-9, 1e-7])
def test_what_just_touches_a_slab_has_its_normal_and_all_its_points(shape, turn, count, gap):
    robot = pair(shape, Shape("box", (2.0, 2.0, 0.5)))
    places = [pin.SE3(turn, np.array([0.3, 0.2, 1.0 + gap])), pin.SE3.Identity()]
    for order, sign in ((("a/one", "b/two"), 1.0), (("b/two", "a/one"), -1.0)):
        points = met(robot, places, 1e-6, order).points
        assert len(points) == count
        for point in points:
            np.testing.assert_allclose(point.normal, [0, 0, sign], atol=1e-8)
            assert point.position[2] == pytest.approx(0.5 + gap / 2, abs=1e-7)


def test_two_capsules_side_by_side_across_and_end_on_end():
    pill, thin = Shape("capsule", (0.5, 0.5)), Shape("capsule", (0.2, 1.5))
    lying = pin.utils.rotate("y", np.pi / 2)
    beside = [pin.SE3(lying, np.array([0.2, 0, 1.0])), pin.SE3(lying, np.zeros(3))]
    points = met(pair(pill, pill), beside, 1e-6).points
    assert sorted(round(point.position[0], 5) for point in points) == [-0.3, 0.5]
    points = met(
        pair(thin, pill), [pin.SE3(lying, np.array([0.2, 0, 0.7])), beside[1]], 1e-6
    ).points
    assert sorted(round(point.position[0], 9) for point in points) == [-0.5, 0.5]
    across = pin.SE3(pin.utils.rotate("z", 0.5) @ lying, np.array([0, 0, 1.0]))
    (point,) = met(pair(pill, pill), [across, beside[1]], 1e-6).points
    np.testing.assert_allclose(point.position, [0, 0, 0.5], atol=1e-9)
    ends = [pin.SE3(np.eye(3), np.array([1.0, 0, 1.6])), pin.SE3(np.eye(3), np.zeros(3))]
    way = np.array([1.0, 0, 1.1]) - [0, 0, 0.5]
    contact = met(pair(pill, pill), ends)
    assert contact.gap == pytest.approx(np.linalg.norm(way) - 1.0, abs=1e-9)


def test_what_is_further_apart_than_the_margin_does_not_meet():
    box = Shape("box", (0.5, 0.5, 0.5))
    places = [pin.SE3(np.eye(3), np.array([0, 0, 1.01])), pin.SE3.Identity()]
    contact = met(pair(box, box), places, 1e-6)
    assert not contact.touching and contact.gap == pytest.approx(0.01)


@pytest.mark.parametrize("world", [0.0, 100.0])
@pytest.mark.parametrize("kinds", [("sphere", "box"), ("cylinder", "box"), ("capsule", "cylinder")])
def test_points_are_the_same_wherever_both_are_and_whichever_is_first(kinds, world):
    rng = np.random.default_rng(3)
    for _ in range(4):
        shapes = [shape_of(kind, rng) for kind in kinds]
        robot, way = pair(*shapes), unit(rng.normal(size=3))
        places = [pin.SE3(random_pose(rng, True), 1.5 * way), pin.SE3.Identity()]
        places[0].translation -= (met(robot, places).gap - 0.1) * way
        margin = met(robot, places).gap + 1e-6
        here = met(robot, places, margin)
        move = pin.SE3(random_pose(rng, True), world * rng.normal(size=3))
        there = met(robot, [move * place for place in places], margin)
        back = met(robot, places, margin, ("b/two", "a/one"))
        assert here.gap == pytest.approx(there.gap, abs=1e-9)
        assert here.gap == pytest.approx(back.gap, abs=1e-12)
        for other, turn, sign in ((there, move.rotation, 1.0), (back, np.eye(3), -1.0)):
            assert len(other.points) == len(here.points)
            normal = sign * turn @ here.points[0].normal
            np.testing.assert_allclose(other.points[0].normal, normal, atol=5e-6)
