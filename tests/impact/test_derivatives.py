"""Derivatives of every kind of scene against differences, and where there are none."""

from __future__ import annotations

import dataclasses
import itertools
import pathlib
import pickle
import re

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial import ConvexHull

import impulsekit as ik
from tests.reference.models import EVERY_KIND, joint, link, robot
from tests.robots import random_state
from tests.robots_with_armature import KINDS, random_configuration, random_robot

from ..conformance.differences import assert_true, by_differences

pytestmark = pytest.mark.filterwarnings("ignore::impulsekit.errors.SetupWarning")

ARM = ik.Robot.from_urdf(
    robot(
        link("base", "2", ".1 .05 .1", ".3 -.2 .5", ".3 .01 .02 .4 .02 .5"),
        link("upper", "1.2", ".2 .02 .01", inertia=".05 .001 .002 .06 0 .07"),
        link("fore", ".8", "0 .1 .2", ".1 .2 0", ".03 0 .004 .02 0 .025"),
        joint("shoulder", "base", "upper", "revolute", "1 .3 .2", ".3 .1 0", ".2 .1 -.4"),
        joint("slide", "upper", "fore", "prismatic", "0 1 .5", ".4 0 .1", ".7 0 .3"),
    ),
    root="freeflyer",
)
_FINGER = ("0 1 .5", ".4 0 .1", ".7 0 .3")
HAND = ik.Robot.from_urdf(
    robot(
        link("palm", "2", ".1 .05 .1", ".3 -.2 .5", ".3 .01 .02 .4 .02 .5"),
        link("knuckle", "1.2", ".2 .02 .01", inertia=".05 .001 .002 .06 0 .07"),
        link("finger", ".8", "0 .1 .2", ".1 .2 0", ".03 0 .004 .02 0 .025"),
        joint("first", "palm", "knuckle", "revolute", "1 .3 .2", ".3 .1 0", ".2 .1 -.4"),
        joint("second", "knuckle", "finger", "revolute", *_FINGER,
              more='<mimic joint="first" multiplier="-1.5" offset="0.3"/>'),
    ),
    root="freeflyer", mimic=True,
)  # fmt: skip
BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
BOX = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
FEET, POINTS = ("base", "upper", "fore"), ([0.1, 0.2, -0.3], [0.2, 0, 0.1], [0, 0.3, 0.2])


def blow(frame, seed=0, axes="world", name="blow"):
    rng = np.random.default_rng(seed)
    linear, angular, at = rng.normal(size=(3, 3))
    return ik.AppliedImpulse(frame, linear, angular, 0.2 * at, axes, name)


def contacts(count, mu, e=0.3, **more):
    return [
        ik.Contact(FEET[i], POINTS[i], [0.1 * i, 0.2, 1], friction=mu, restitution=e, **more)
        for i in range(count)
    ]


def falling(seed=5, robot=ARM):
    q, v = random_state(robot, seed)
    v[:3] += pin.Quaternion(q[3:7]).matrix().T @ [0, 0, -3.0]
    return q, v


def on_arm(seed=5, law=None, **entries):
    return ik.Scene(ARM, law=law or ik.Law(), **entries), *falling(seed)


def held(*constraints):
    return ik.Scene(ARM, [blow("upper", 2)], constraints), *random_state(ARM, 4)


MIXED = pin.Quaternion(0.8, 0.1, -0.3, 0.5).normalized().coeffs()


def two_bodies(first, other, way, **collision):
    """Two free bodies, the first away from the other by ``way``, that approach each other.

    All of it is turned in the world.
    """
    kinds = [ik.Robot.from_urdf(f"models/{kind}.urdf", root="freeflyer") for kind in (first, other)]
    world, way = ik.combine(a=kinds[0], b=kinds[1]), np.array(way)
    turn = pin.Quaternion(0.4, -0.6, 0.2, 0.7).normalized()
    own = (turn * pin.Quaternion(MIXED)).coeffs()
    q = world.configuration(
        {"a/root_joint": [*turn.matrix() @ way, *own], "b/root_joint": [0, 0, 0, *turn.coeffs()]}
    )
    v = np.random.default_rng(1).normal(size=12)
    v[:3] -= 4.0 * pin.Quaternion(MIXED).matrix().T @ way / np.linalg.norm(way)
    names = (f"a/{kinds[0].links[-1].name}", f"b/{kinds[1].links[-1].name}")
    # A little overlap, so that they touch at all states about this one.
    touch = ik.Collision(*names, restitution=0.6, margin=0.01, **collision)
    return ik.Scene(world, [blow(names[0], 2)], contacts=[touch]), q, v


def corner_on_a_face():
    """A box whose lowest corner is a little within the top of another one."""
    half, turn = np.array([0.15, 0.1, 0.05]), pin.Quaternion(MIXED).matrix()
    corner = -turn @ (half * np.sign(turn[2]))
    scene, q, v = two_bodies("box", "box", [-corner[0], -corner[1], half[2] - 2e-3 - corner[2]])
    scene, v[3:] = ik.Scene(scene.robot, contacts=scene.contacts), 0.1 * v[3:]
    assert ik.solve(scene, q, v).contacts[0].impulse[2] > 0.0
    return scene, q, v


def every_kind(seed=0):
    rng = np.random.default_rng(seed)
    robot = ik.Robot.from_urdf(EVERY_KIND, root="freeflyer")
    hold = ik.FrameAnchor("drone", "arm", rng.normal(size=3), directions=("x", "z", "ry"),
                          velocity=list(rng.normal(size=3)))  # fmt: skip
    blows = [blow("tool", seed), blow("drone", seed + 9, "local", "second")]
    scene = ik.Scene(robot, blows, [hold, ik.JointCoupling("zeta", "alpha", ratio=0.5)])
    return scene, *random_state(robot, seed)


TABLE = ik.RestitutionTable([0.0, 20.0], [0.9, 0.2])


CASES = {
    "two points": lambda: held(
        ik.FrameAnchor("fore", "base", [0.1, 0, 0.3], [0, 0.1, 0], ("x", "rz"))
    ),
    "kept": lambda: held(
        ik.FrameAnchor("fore", "base", [0, 0.2, 0], None, ("y", "rz"), "local", "kept")
    ),
    "every kind of joint": every_kind,
    "joints that follow": lambda: (
        ik.Scene(HAND, [blow("finger", 3), blow("knuckle", 4, "local", "second")]),
        *random_state(HAND, 2),
    ),
    "contacts of joints that follow": lambda: (
        ik.Scene(HAND, contacts=[ik.Contact("finger", [0.1, 0, 0.2], friction=0.1)]),
        *falling(5, HAND),
    ),
    "tangential restitution": lambda: on_arm(contacts=contacts(1, 3.0, tangential_restitution=0.4)),
    "restitution by speed": lambda: on_arm(contacts=contacts(1, 0.1, TABLE)),
    "balls of two sizes": lambda: two_bodies("ball", "billiard_ball", [0.05, 0.026, 0.05]),
    "a ball and a face": lambda: two_bodies("ball", "box", [0.02, -0.03, 0.099], friction=0.05),
    "a corner and a face": corner_on_a_face,
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_they_are_those_of_differences(name):
    assert_true(*CASES[name]())


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "ellipsoid"])
def test_joints_of_every_kind_with_their_rotors(kind):
    """Also joints of several axes, each with its own armature, and axes that turn with them."""
    rng = np.random.default_rng(5)
    plain = random_robot(rng, ["free", kind], armature=False)
    model = pin.Model(plain.model)
    model.armature = np.linspace(0.1, 0.9, model.nv)
    arm = ik.Robot.from_model(model)
    touch = ik.Contact("link_1", normal=[0, 0.1, 1], restitution=0.5)
    q, v = random_configuration(arm, rng), rng.normal(size=arm.nv)
    assert_true(
        ik.Scene(arm, [blow("link_1", 1)], [ik.FrameAnchor("link_1", directions=["x"])]), q, v
    )
    scene = ik.Scene(arm, contacts=[touch])
    assert_true(scene, q, v if ik.solve(scene, q, v).contacts[0].impulse.any() else -v)


def test_a_face_of_a_mesh_is_that_of_the_box_that_it_is(tmp_path):
    half = np.array([0.15, 0.1, 0.05])
    corners = half * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    facets = ""
    for i in ConvexHull(corners).simplices:
        loop = "".join("vertex {} {} {}\n".format(*corner) for corner in corners[i])
        facets += f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n"
    (tmp_path / "box.stl").write_text(f"solid box\n{facets}endsolid box\n")
    plain = pathlib.Path("models/box.urdf").read_text()
    meshed = re.sub("<box size=[^>]*/>", '<mesh filename="box.stl"/>', plain)
    found = []
    for text in (plain, meshed):
        flat = ik.Robot.from_urdf(text, root="freeflyer", package_dirs=[tmp_path])
        world = ik.combine(a=BALL, b=flat)
        q = world.configuration({"a/root_joint": [0.02, -0.03, half[2] + 0.05, *MIXED]})
        v = np.random.default_rng(1).normal(size=12)
        v[:3] -= 4.0 * pin.Quaternion(MIXED).matrix().T[:, 2]
        touch = ik.Collision("a/ball", "b/box", restitution=0.6, friction=0.3)
        found.append(ik.derivatives(ik.solve(ik.Scene(world, contacts=[touch]), q, v)))
    assert np.abs(found[0]["v_after", "q"]).max() > 1.0
    for by in ("q", "v"):
        by_box, by_mesh = (each["v_after", by] for each in found)
        assert np.abs(by_mesh - by_box).max() < 1e-6 * np.abs(by_box).max()


def test_redundant_rows_have_derivatives_where_the_rank_is_constant():
    rod = ik.Robot.from_urdf(ik.models.chain_urdf(links=2), root="planar")
    pins = [ik.PointAnchor("link_1", at=[0.2, 0, 0], name=name) for name in ("pin", "again")]
    hit = [ik.AppliedImpulse("link_2", linear=[0, 1, 0], at=[0.3, 0, 0], name="hit")]
    q, v = random_state(rod, 0)
    twice = ik.derivatives(ik.solve(ik.Scene(rod, hit, pins), q, v))
    once = ik.derivatives(ik.solve(ik.Scene(rod, hit, pins[:1]), q, v))
    assert twice.status.exists
    np.testing.assert_allclose(twice["v_after", "q"], once["v_after", "q"], atol=1e-12)
    np.testing.assert_allclose(twice["v_after", "v"], once["v_after", "v"], atol=1e-12)
    assert np.isnan(twice["pin", "q"][:2]).all()
    assert not np.isnan(once["pin", "q"]).any()


def test_rows_that_are_redundant_here_only_have_no_derivative():
    """Two pinned rods, stretched out; bent ever so little the tip's second row stops both."""
    rods = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    scene = ik.Scene(rods, [], [ik.PointAnchor("link_2", at=[0, 0, -1])])
    assert not ik.derivatives(ik.solve(scene, [0.0, 0.0], [1.0, -1.0])).status.exists
    assert ik.derivatives(ik.solve(scene, [0.0, 0.1], [1.0, -1.0])).status.exists


def test_redundant_contacts_that_stick():
    feet = [
        ik.Contact("box", at=[x, y, -0.1], friction=0.8, restitution=0.4)
        for x in (-0.2, 0.2)
        for y in (-0.1, 0.1)
    ]
    scene, q, v = ik.Scene(BOX, contacts=feet), BOX.neutral(), np.array([0.3, 0.1, -2, 0, 0, 0.1])
    # Of a tilted box some corner slips, at some 7e-3 h² m/s: a long step would measure that.
    found = assert_true(scene, q, v, bar=1e-5, step=1e-5)
    assert np.isnan(found["contacts[0]", "v"]).all()
    tilting = ik.derivatives(ik.solve(scene, q, v + 0.05 * np.eye(6)[3]))
    assert np.isnan(tilting["v_after", "q"]).any() and not np.isnan(tilting["v_after", "v"]).any()


class Worn:
    """e(u) = 0.9 − 0.01 u², with its slope."""

    def __call__(self, speed):
        return 0.9 - 0.01 * speed**2

    def derivative(self, speed):
        return -0.02 * speed


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_restitution_that_is_a_function(law):
    def found(value):
        return assert_true(*on_arm(law=ik.Law(law), contacts=contacts(1, 0.1, value)))

    known, plain = found(Worn()), found(lambda speed: 0.9 - 0.01 * speed**2)
    assert known.status is not plain.status and plain.status.exists
    np.testing.assert_allclose(plain["v_after", "q"], known["v_after", "q"], atol=1e-8)
    sudden = Worn()
    sudden.derivative = lambda speed: float("nan")
    with pytest.raises(ik.errors.InputError, match="no number"):
        found(sudden)


@pytest.mark.parametrize("blow", [0.7, -0.7, -3.0])
@pytest.mark.parametrize("order", ["simultaneous", "sequential"])
def test_a_ball_that_is_struck_as_it_lands_has_two_laws_and_their_slopes(order, blow):
    """Together: v⁺ = e v⁻ (or as the blow parts it). In turn: v⁺ = −e (v⁻ + P/m)."""
    mass, e, speed = 0.5, 0.5, 1.0
    kick = ik.AppliedImpulse("ball", linear=[0, 0, blow], name="blow")
    floor = ik.Contact("ball", at=[0, 0, -0.05], restitution=e, name="floor")
    scene = ik.Scene(BALL, [kick], contacts=[floor], law=ik.Law(order=order))
    v = BALL.velocity(root_joint=[0, 0, -speed, 0, 0, 0])
    found = ik.derivatives(ik.solve(scene, BALL.neutral(), v))
    thrown = -speed + blow / mass
    if thrown > (e * speed if order == "simultaneous" else 0.0):
        by_blow, by_e, by_v = 1.0 / mass, 0.0, 1.0
    elif order == "simultaneous":
        by_blow, by_e, by_v = 0.0, speed, -e
    else:
        by_blow, by_e, by_v = -e / mass, -thrown, -e
    assert found["v_after", "impulses"]["blow"][2, 2] == pytest.approx(by_blow, abs=1e-12)
    assert found["v_after", "restitution"]["floor"][2] == pytest.approx(by_e, abs=1e-12)
    assert found["v_after", "v"][2, 2] == pytest.approx(by_v, abs=1e-12)


@pytest.mark.parametrize(
    ("velocity", "friction", "words"),
    [
        ([1.0, 0, 0, 0, 0, 0], 0.0, "hardly"),
        ([1.0, 0, -1e-9, 0, 0, 0], 0.0, "hardly"),
        # At the mass centre W is 1/m: it sticks exactly while u_t⁻ ≤ µ u_n⁻.
        ([0.5, 0, -1.0, 0, 0, 0], 0.5, ""),
    ],
)
def test_an_edge_is_named(velocity, friction, words):
    scene = ik.Scene(BALL, contacts=[ik.Contact("ball", friction=friction)])
    found = ik.derivatives(ik.solve(scene, BALL.neutral(), velocity))
    assert not found.status.exists
    assert words in found.edges[0] and found.edges[0].startswith("contacts[0]")


@pytest.mark.parametrize(
    "law", [ik.Law(), ik.Law("stronge", "path")], ids=lambda law: law.restitution
)
def test_by_inertia_against_changed_models(law):
    scene, q, v = on_arm(law=law, impulses=[blow("fore", 7)], contacts=contacts(1, 0.15))
    found, joint_id = ik.derivatives(ik.solve(scene, q, v)), ARM.joint_id("shoulder")

    def after(change):
        model = pin.Model(ARM.model)
        values = model.inertias[joint_id].toDynamicParameters() + change
        model.inertias[joint_id] = pin.Inertia.FromDynamicParameters(values)
        other = dataclasses.replace(scene, robot=ik.Robot.from_model(model))
        return ik.solve(other, q, v).v_after

    for k, way in enumerate(np.eye(10)):
        truth = by_differences(lambda h, way=way: after(h * way))
        ours = found.by_inertia("shoulder")[:, k]
        assert np.abs(ours - truth).max() < 1e-7 * max(1.0, np.abs(truth).max())


def test_what_has_none_of_this_kind_is_refused():
    q, v = np.array([0.3, 0, 0.009, 0, 0, 0, 1]), np.array([1.0, 0, -2, 0, 0, 0])
    # Edges that cross.
    boxes, turned = ik.combine(a=BOX, b=BOX), pin.Quaternion(pin.rpy.rpyToMatrix(0, 0.8, 0.5))
    low = 0.15 * np.sin(0.8) + 0.05 * np.cos(0.8)
    at = [-0.15, 0.0, 0.05 + low - 1e-4, *turned.coeffs()]
    state = boxes.configuration({"a/root_joint": at})
    falls = boxes.velocity({"a/root_joint": [0, 0, -1, 0, 0, 0]})
    for scene, at, u, words in (
        (
            ik.Scene(BALL, contacts=[ik.GapContact(lambda q: q[2] - 0.1 * q[0] ** 2)]),
            q,
            v,
            "second",
        ),
        (
            ik.Scene(boxes, contacts=[ik.Collision("a/box", "b/box", margin=1e-2)]),
            state,
            falls,
            "polytope",
        ),
    ):
        impact = ik.solve(scene, at, u)
        with pytest.raises(ik.errors.InputError, match=words):
            ik.derivatives(impact)


def test_impacts_of_a_motion_keep_their_derivatives_in_files_and_pickles(tmp_path):
    """A box falls on another with a corner: the point at which they meet is known by its name."""
    world = ik.combine(upper=BOX, box=BOX)
    tilt = pin.Quaternion(pin.rpy.rpyToMatrix(0.5, 0.4, 0.1)).coeffs()
    q = world.configuration({"upper/root_joint": [0.05, 0.02, 0.4, *tilt]})
    floor = [
        ik.Contact("box/box", at=[x, y, -0.05], origin=[0, 0, -0.05])
        for x in (-0.15, 0.15)
        for y in (-0.1, 0.1)
    ]
    scene = ik.Scene(
        world,
        contacts=[ik.Collision("upper/box", "box/box", restitution=0.4, friction=0.3), *floor],
        gravity=[0, 0, -9.81],
    )
    motion = ik.simulate(scene, q, world.velocity(), duration=0.3)
    # At the first impact an edge meets an edge, which has no closed form; then a corner a face.
    ours = ik.derivatives(_meetings(motion)[1])
    motion.save(tmp_path / "m.npz")
    loaded = ik.Trajectory.load(tmp_path / "m.npz", scene=scene)
    for again in (pickle.loads(pickle.dumps(motion)), loaded):
        theirs = ik.derivatives(_meetings(again)[1])
        assert theirs.results == ours.results and "contacts[0]" in ours.results
        for name in ours.results:
            np.testing.assert_array_equal(theirs[name, "q"], ours[name, "q"])


def _meetings(motion):
    """The impacts at which the first contact touches."""
    return [impact for _, impact in motion.impacts if impact.contacts[0].touching]
