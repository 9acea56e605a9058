"""Derivatives against central differences of Kane's equations in 50 digits."""

import dataclasses
import itertools
import pathlib
import re

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial import ConvexHull

import impulsekit as ik
from impulsekit.impact.derivatives import DerivativeStatus
from tests.reference.models import EVERY_KIND, joint, link, robot
from tests.robots import random_state

from .fifty_digits import PreciseImpact

BOUND = 1e-8

ARM = robot(
    link("base", "2", ".1 .05 .1", ".3 -.2 .5", ".3 .01 .02 .4 .02 .5"),
    link("upper", "1.2", ".2 .02 .01", inertia=".05 .001 .002 .06 0 .07"),
    link("fore", ".8", "0 .1 .2", ".1 .2 0", ".03 0 .004 .02 0 .025"),
    joint("shoulder", "base", "upper", "revolute", "1 .3 .2", ".3 .1 0", ".2 .1 -.4"),
    joint("slide", "upper", "fore", "prismatic", "0 1 .5", ".4 0 .1", ".7 0 .3"),
)


def arm():
    return ik.Robot.from_urdf(ARM, root="freeflyer")


def blow(frame, seed=0, axes="world", name="blow"):
    rng = np.random.default_rng(seed)
    return ik.AppliedImpulse(
        frame,
        linear=rng.normal(size=3),
        angular=rng.normal(size=3),
        at=0.2 * rng.normal(size=3),
        axes=axes,
        name=name,
    )


def tables(found):
    """The derivatives of v⁺, then of the impulses of constraints and contacts, by parameter."""
    own = (
        found.dv_after_dq,
        found.dv_after_dv,
        found.dv_after_dimpulse,
        found.dv_after_drestitution,
        found.dv_after_dfriction,
    )
    parts = [
        (p.dq, p.dv, p.dimpulse, p.drestitution, p.dfriction)
        for p in (*found.constraints.values(), *found.contacts.values())
    ]
    return [own, *parts]


def assert_true(scene, q, v, modes=None):
    """Every derivative of an impact against 50 digits."""
    impact = ik.solve(scene, q, v)
    if modes is not None:
        assert [contact.mode for contact in impact.contacts] == modes
    found = ik.derivatives(impact)
    assert found.status is DerivativeStatus.EXISTS
    truth, parts = PreciseImpact(impact), tables(found)
    close(np.vstack([part[0] for part in parts]), truth.by_q())
    close(np.vstack([part[1] for part in parts]), truth.by_v())
    for name in scene.entry_names("impulses"):
        ours = np.vstack([part[2][name] for part in parts])
        close(ours, truth.by_blow(name, ours.shape[1]))
    for i, name in enumerate(scene.entry_names("contacts")):
        if name in found.dv_after_drestitution:
            close(np.concatenate([p[3][name] for p in parts]), truth.by_coefficient("de", i))
        if name in found.dv_after_dfriction and getattr(scene.contacts[i], "friction", 0.0):
            close(np.concatenate([p[4][name] for p in parts]), truth.by_coefficient("dmu", i))


def close(ours, truth):
    __tracebackhide__ = True
    assert np.abs(ours - truth).max() <= BOUND * max(1.0, np.abs(truth).max())


# -- known blows and constraints ---------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["world", "local"])
def test_known_blows(axes):
    scene = ik.Scene(arm(), [blow("fore", 1, axes), ik.JointImpulse("slide", 0.4)])
    assert_true(scene, *random_state(scene.robot, 3))


@pytest.mark.slow
@pytest.mark.parametrize(
    "constraints",
    [
        [ik.PointAnchor("fore", at=[0.1, 0.2, 0.3], velocity=[1, -2, 0.5])],
        [ik.FrameAnchor("fore", "base", at=[0.1, 0.2, 0.3], directions=("x", "y"))],
        [ik.FrameAnchor("fore", "base", [0.1, 0, 0.3], [0, 0.1, 0], ("x", "rz"))],
        [ik.FrameAnchor("fore", "base", [0, 0.2, 0], None, ("y", "rz"), "local", "kept")],
        [ik.FrameAnchor("world", "fore", directions=("y", "z", "rx"), at=[0.1, 0.2, 0.3])],
        [ik.JointLock("slide", velocity="kept"), ik.FrameAnchor("base", directions=("x", "ry"))],
        [ik.JointCoupling("shoulder", "slide", ratio=0.5), ik.PointAnchor("base")],
    ],
    ids=["imposed", "coincident", "two points", "kept", "of world", "lock", "coupling"],
)
def test_constraints(constraints):
    scene = ik.Scene(arm(), [blow("upper", 2)], constraints)
    assert_true(scene, *random_state(scene.robot, 4))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_every_kind_of_joint_with_random_entries(seed):
    rng = np.random.default_rng(seed)
    scene = ik.Scene(
        ik.Robot.from_urdf(EVERY_KIND, root="freeflyer"),
        [blow("tool", seed), blow("drone", seed + 9, "local", "second")],
        [
            ik.FrameAnchor(
                "drone",
                "arm",
                at=rng.normal(size=3),
                directions=tuple(rng.choice(["x", "y", "z", "rx", "ry", "rz"], 3, replace=False)),
                axes=str(rng.choice(["world", "local"])),
                velocity=list(rng.normal(size=3)),
            ),
            ik.JointCoupling("zeta", "alpha", ratio=0.5),
        ],
    )
    assert_true(scene, *random_state(scene.robot, seed))


def test_redundant_rows_have_derivatives_where_the_rank_is_constant():
    rod = ik.Robot.from_urdf(ik.models.chain_urdf(links=2), root="planar")
    pins = [
        ik.PointAnchor("link_1", at=[0.2, 0, 0], name="pin"),
        ik.PointAnchor("link_1", at=[0.2, 0, 0], name="again"),
    ]
    hit = [ik.AppliedImpulse("link_2", linear=[0, 1, 0], at=[0.3, 0, 0], name="hit")]
    q, v = random_state(rod, 0)
    twice = ik.derivatives(ik.solve(ik.Scene(rod, hit, pins), q, v))
    once = ik.derivatives(ik.solve(ik.Scene(rod, hit, pins[:1]), q, v))
    assert twice.status is DerivativeStatus.EXISTS
    assert np.allclose(twice.dv_after_dq, once.dv_after_dq, rtol=0, atol=1e-12)
    assert np.allclose(twice.dv_after_dv, once.dv_after_dv, rtol=0, atol=1e-12)
    assert np.isnan(twice.constraints["pin"].dq[:2]).all()
    assert not np.isnan(once.constraints["pin"].dq).any()


def test_rows_that_are_redundant_here_only_have_no_derivative():
    # Two pinned rods, stretched out: the tip's row along the rods says nothing here, and
    # bent ever so little it stops both.
    rods = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    tip = ik.PointAnchor("link_2", at=[0, 0, -1])
    found = ik.derivatives(ik.solve(ik.Scene(rods, [], [tip]), [0.0, 0.0], [1.0, -1.0]))
    assert found.status is DerivativeStatus.RANK_CHANGES
    assert not found.status.exists
    bent = ik.derivatives(ik.solve(ik.Scene(rods, [], [tip]), [0.0, 0.1], [1.0, -1.0]))
    assert bent.status.exists


# -- joints that follow others, or whose axes turn with themselves --------------------------

HAND = robot(
    link("palm", "2", ".1 .05 .1", ".3 -.2 .5", ".3 .01 .02 .4 .02 .5"),
    link("knuckle", "1.2", ".2 .02 .01", inertia=".05 .001 .002 .06 0 .07"),
    link("finger", ".8", "0 .1 .2", ".1 .2 0", ".03 0 .004 .02 0 .025"),
    link("tip", ".5", ".1 0 .1", inertia=".02 0 .001 .03 0 .02"),
    joint("first", "palm", "knuckle", "revolute", "1 .3 .2", ".3 .1 0", ".2 .1 -.4"),
    joint(
        "second",
        "knuckle",
        "finger",
        "revolute",
        "0 1 .5",
        ".4 0 .1",
        ".7 0 .3",
        more='<mimic joint="first" multiplier="-1.5" offset="0.3"/>',
    ),
    joint(
        "third",
        "finger",
        "tip",
        "prismatic",
        "1 0 .2",
        ".1 0 .1",
        more='<mimic joint="first" multiplier="0.4"/>',
    ),
)


@pytest.mark.slow
@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
def test_joints_that_follow_others(root):
    hand = ik.Robot.from_urdf(HAND, root=root, mimic=True)
    scene = ik.Scene(hand, [blow("tip", 3), blow("knuckle", 4, "local", "second blow")])
    assert_true(scene, *random_state(hand, 2))


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.05, 3.0])
def test_contacts_and_constraints_of_joints_that_follow_others(mu):
    hand = ik.Robot.from_urdf(HAND, root="freeflyer", mimic=True)
    q, v = random_state(hand, 5)
    v[:3] += pin.Quaternion(q[3:7]).matrix().T @ [0, 0, -3.0]
    hold = [ik.FrameAnchor("finger", "palm", directions=("x",), axes="local")]
    touch = [ik.Contact("tip", at=[0.1, 0, 0.2], friction=mu, restitution=0.4)]
    assert_true(ik.Scene(hand, [blow("tip", 3)], hold if mu > 1 else [], touch), q, v)


def arms_with_axes(*axes):
    """Arms whose middle turns about these axes, in order: by one joint, by another, by several."""
    axes = [np.array(axis, dtype=float) for axis in axes]
    composite = pin.JointModelComposite()
    for axis in axes:
        composite.addJoint(pin.JointModelRevoluteUnaligned(axis))
    single = pin.JointModelSphericalZYX() if len(axes) == 3 else pin.JointModelUniversal(*axes)
    return [
        arm_with([composite]),
        arm_with([single]),
        arm_with([pin.JointModelRevoluteUnaligned(axis) for axis in axes]),
    ]


def arm_with(joints):
    model = pin.Model()
    place, heavy = pin.SE3.Identity(), pin.Inertia(2.0, np.array([0.1, 0.2, 0.1]), np.eye(3))
    parent = model.addJoint(0, pin.JointModelPX(), place, "base")
    model.appendBodyToJoint(parent, heavy, place)
    between = pin.SE3(pin.rpy.rpyToMatrix(0.3, 0.2, 0.5), np.array([0.4, 0, 0.2]))
    for i, item in enumerate(joints):
        parent = model.addJoint(parent, item, between, f"middle {i}")
        between = place
    model.appendBodyToJoint(parent, heavy, place)
    last = model.addJoint(
        parent, pin.JointModelRX(), pin.SE3(np.eye(3), np.array([0.3, 0, 0])), "last"
    )
    model.appendBodyToJoint(last, heavy, place)
    hand = pin.SE3(np.eye(3), np.array([0, 0.3, 0.1]))
    model.addFrame(pin.Frame("hand", last, 0, hand, pin.OP_FRAME))
    return ik.Robot.from_model(model)


@pytest.mark.parametrize("axes", [[(0, 0, 1), (0, 1, 0), (1, 0, 0)], [(1, 0, 0), (0, 0, 1)]])
def test_axes_that_turn_with_their_own_coordinates(axes):
    *varying, spread = arms_with_axes(*axes)
    rng = np.random.default_rng(3)
    q, v = rng.uniform(-1, 1, spread.nq), rng.normal(size=spread.nv)
    touch = ik.Contact("hand", normal=[0, 0.1, 1], friction=0.2, restitution=0.5)

    def scene(arm):
        return ik.Scene(arm, [blow("hand", 1)], contacts=[touch])

    if ik.solve(scene(spread), q, v).contacts[0].mode == "separated":
        v = -v
    truth = ik.derivatives(ik.solve(scene(spread), q, v))
    assert truth.status.exists and truth.contacts["contacts[0]"].dq.any()
    for arm in varying:
        found = ik.derivatives(ik.solve(scene(arm), q, v))
        for ours, theirs in zip(tables(found), tables(truth), strict=True):
            close(np.hstack(ours[:2]), np.hstack(theirs[:2]))
            close(ours[2]["blow"], theirs[2]["blow"])
            close(ours[4]["contacts[0]"], theirs[4]["contacts[0]"])
        # And against differences, which know nothing of chains.
        by_q, by_v = _differences(scene(arm), q, v)
        assert np.abs(found.dv_after_dq - by_q).max() < 1e-7 * np.abs(by_q).max()
        assert np.abs(found.dv_after_dv - by_v).max() < 1e-7 * np.abs(by_v).max()


def test_an_ellipsoid_joint_is_refused():
    arm = arm_with([pin.JointModelEllipsoid(0.1, 0.2, 0.3)])
    impact = ik.solve(ik.Scene(arm, [blow("hand", 1)]), np.full(arm.nq, 0.3), np.ones(arm.nv))
    with pytest.raises(ik.errors.InputError, match="no chain of joints"):
        ik.derivatives(impact)


# -- contacts -------------------------------------------------------------------------------

FEET = ("base", "upper", "fore")
POINTS = ([0.1, 0.2, -0.3], [0.2, 0, 0.1], [0, 0.3, 0.2])


def contacts(count, mu, e=0.3, **more):
    return [
        ik.Contact(
            FEET[i], at=POINTS[i], normal=[0.1 * i, 0.2, 1], friction=mu, restitution=e, **more
        )
        for i in range(count)
    ]


def falling(seed=5):
    q, v = random_state(arm(), seed)
    v[:3] += pin.Quaternion(q[3:7]).matrix().T @ [0, 0, -3.0]
    return q, v


@pytest.mark.slow
@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("mu", [0.0, 0.02, 3.0])
def test_one_contact_in_each_mode(law, mu):
    scene = ik.Scene(
        arm(), [blow("fore", 7)], contacts=contacts(1, mu), law=ik.Law(restitution=law)
    )
    # In Poisson's law slip may end between compression and expansion.
    modes = ["sticking" if mu == 3.0 else "sliding"] if law == "newton" else None
    assert_true(scene, *falling(), modes)


def test_a_contact_that_parts_carries_nothing():
    scene = ik.Scene(arm(), [blow("fore", 7)], contacts=contacts(1, 0.5))
    q, v = falling()
    impact = ik.solve(scene, q, -3 * v)
    found = ik.derivatives(impact)
    assert impact.contacts[0].mode == "separated" and found.status.exists
    assert not found.contacts["contacts[0]"].dv.any()
    assert np.array_equal(found.dv_after_dv, np.eye(8))


@pytest.mark.slow
def test_coefficients_that_depend_on_speed_and_tangential_restitution():
    table = ik.RestitutionTable([0.0, 20.0], [0.9, 0.2])
    for law, e_t in (("newton", 0.4), ("poisson", 0.0)):
        own = contacts(1, 3.0, table, tangential_restitution=e_t)
        scene = ik.Scene(arm(), contacts=own, law=ik.Law(restitution=law))
        assert_true(scene, *falling(), modes=["sticking"])


MIXED = pin.Quaternion(0.8, 0.1, -0.3, 0.5).normalized().coeffs()


def two_bodies(first, other, way):
    """Two free bodies, the first away from the other by ``way``, that approach each other."""
    kinds = [ik.Robot.from_urdf(f"models/{kind}.urdf", root="freeflyer") for kind in (first, other)]
    world = ik.combine(a=kinds[0], b=kinds[1])
    q = world.configuration({"a/root_joint": [*way, *MIXED], "b/root_joint": [0, 0, 0, 0, 0, 0, 1]})
    v = np.random.default_rng(1).normal(size=12)
    v[:3] -= 4.0 * pin.Quaternion(MIXED).matrix().T @ way / np.linalg.norm(way)
    return world, q, v


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.0, 0.05, 2.0])
def test_a_collision_of_two_balls(mu):
    way = 0.1 * np.array([2.0, 1.0, 2.0]) / 3.0
    world, q, v = two_bodies("ball", "ball", way)
    touch = ik.Collision("a/ball", "b/ball", restitution=0.6, friction=mu)
    assert_true(ik.Scene(world, [blow("a/ball", 2)], contacts=[touch]), q, v)


@pytest.mark.slow
def test_a_collision_of_balls_of_two_sizes():
    way = (0.05 + 0.028575) * np.array([2.0, 1.0, 2.0]) / 3.0
    world, q, v = two_bodies("ball", "billiard_ball", way)
    touch = ik.Collision("a/ball", "b/ball", restitution=0.6, friction=0.1)
    assert_true(ik.Scene(world, contacts=[touch]), q, v)


@pytest.mark.slow
@pytest.mark.parametrize("ball_first", [True, False])
@pytest.mark.parametrize("mu", [0.05, 2.0])
def test_a_collision_of_a_ball_with_a_face(ball_first, mu):
    size = np.array(box().collision_model.geometryObjects[0].geometry.halfSide).reshape(3)
    world, q, v = two_bodies("ball", "box", np.array([0.02, -0.03, size[2] + 0.05]))
    names = ("a/ball", "b/box") if ball_first else ("b/box", "a/ball")
    touch = ik.Collision(*names, restitution=0.6, friction=mu)
    assert_true(ik.Scene(world, contacts=[touch]), q, v)


def test_a_face_of_a_mesh_is_that_of_the_box_that_it_is(tmp_path):
    half = np.array(box().collision_model.geometryObjects[0].geometry.halfSide).reshape(3)
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
        world = ik.combine(a=ik.Robot.from_urdf("models/ball.urdf", root="freeflyer"), b=flat)
        q = world.configuration({"a/root_joint": [0.02, -0.03, half[2] + 0.05, *MIXED]})
        v = np.random.default_rng(1).normal(size=12)
        v[:3] -= 4.0 * pin.Quaternion(MIXED).matrix().T[:, 2]
        touch = ik.Collision("a/ball", "b/box", restitution=0.6, friction=0.3)
        found.append(ik.derivatives(ik.solve(ik.Scene(world, contacts=[touch]), q, v)))
    assert np.abs(found[0].dv_after_dq).max() > 1.0
    for name in ("dv_after_dq", "dv_after_dv"):
        by_box, by_mesh = (getattr(each, name) for each in found)
        assert np.abs(by_mesh - by_box).max() < 1e-6 * np.abs(by_box).max()


def test_a_collision_of_shapes_without_a_closed_form_is_refused():
    upper = ik.combine(a=box(), b=box())
    q = upper.configuration({"a/root_joint": [0.05, 0, 0.1, 0, 0, 0, 1]})
    scene = ik.Scene(upper, contacts=[ik.Collision("a/box", "b/box")])
    impact = ik.solve(scene, q, upper.velocity({"a/root_joint": [0, 0, -1, 0, 0, 0]}))
    with pytest.raises(ik.errors.InputError, match="Box and Box"):
        ik.derivatives(impact)


def box():
    return ik.Robot.from_urdf("models/box.urdf", root="freeflyer")


class Worn:
    """e(u) = 0.9 − 0.01 u², with its slope."""

    def __call__(self, speed):
        return 0.9 - 0.01 * speed**2

    def derivative(self, speed):
        return -0.02 * speed


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_restitution_that_is_a_function(law):
    order = ik.Law(restitution=law)

    def found(value):
        scene = ik.Scene(arm(), contacts=contacts(1, 0.1, value), law=order)
        return ik.derivatives(ik.solve(scene, *falling()))

    known, plain = found(Worn()), found(lambda speed: 0.9 - 0.01 * speed**2)
    assert known.status is DerivativeStatus.EXISTS
    assert plain.status is DerivativeStatus.BY_DIFFERENCES and plain.status.exists
    assert np.allclose(plain.dv_after_dq, known.dv_after_dq, rtol=0, atol=1e-9)
    # A table through the same value with the same slope is the same here.
    approach = -ik.solve(known.impact.scene, *falling()).contacts[0].velocity_before @ [0, 0.2, 1]
    approach /= np.sqrt(1.04)
    e, slope = Worn()(approach), Worn().derivative(approach)
    tangent = ik.RestitutionTable(
        [approach - 0.5, approach + 0.5], [e - 0.5 * slope, e + 0.5 * slope]
    )
    same = found(tangent)
    close(known.dv_after_dq, same.dv_after_dq)
    close(known.dv_after_dv, same.dv_after_dv)
    sudden = Worn()
    sudden.derivative = lambda speed: float("nan")
    with pytest.raises(ik.errors.InputError, match="no number"):
        found(sudden)


@pytest.mark.slow
def test_a_table_beside_a_blow_that_presses_what_did_not_approach():
    # Its approach speed is zero here and nearby, so its restitution is that at rest.
    table = ik.RestitutionTable([0.0, 20.0], [0.9, 0.2])
    down = ik.AppliedImpulse("base", linear=[0, 0, -30.0], name="down")
    order = ik.Law(restitution="poisson")
    scene = ik.Scene(arm(), [down], contacts=contacts(1, 0.1, table), law=order)
    q, v = falling()
    assert ik.solve(scene, q, -0.2 * v).contacts[0].velocity_before[2] > 0.1
    assert_true(scene, q, -0.2 * v)


@pytest.mark.slow
def test_a_plane_that_moves():
    own = [
        ik.Contact(
            "fore",
            at=[0.1, 0, 0.2],
            against="base",
            normal=[1, 0.5, 0.2],
            friction=0.2,
            restitution=0.5,
        )
    ]
    q, v = falling()
    scene = ik.Scene(arm(), contacts=own)
    if ik.solve(scene, q, v).contacts[0].mode == "separated":
        v = -v
    assert_true(scene, q, v, modes=["sliding"])


@pytest.mark.slow
def test_a_joint_stop():
    stop = ik.JointStop("slide", upper=0.1, restitution=0.5)
    q, v = random_state(arm(), 6)
    q[-1], v[-1] = 0.1, 2.0
    assert_true(ik.Scene(arm(), [blow("fore", 3)], contacts=[stop]), q, v, modes=["sliding"])


@pytest.mark.slow
@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("mu", [0.1, 0.5, 3.0])
def test_several_contacts_beside_a_constraint(law, mu):
    hold = [ik.FrameAnchor("upper", "fore", directions=("x",), axes="local")]
    scene = ik.Scene(arm(), [blow("fore", 7)], hold, contacts(2, mu), law=ik.Law(restitution=law))
    assert_true(scene, *falling(8))


@pytest.mark.slow
@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize(
    "mu", [pytest.param(mu, marks=pytest.mark.slow if mu else ()) for mu in (0.0, 0.05, 3.0)]
)
def test_contacts_one_after_the_other(law, mu):
    hold = [ik.FrameAnchor("upper", "fore", directions=("x",), axes="local")]
    order = ik.Law(restitution=law, order="sequential")
    touch = contacts(3, mu, 0.8)
    scene = ik.Scene(arm(), [blow("fore", 7)], hold if mu else [], touch, law=order)
    assert ik.solve(scene, *falling(9)).outcome.contacts.iterations > 1
    assert_true(scene, *falling(9))


def test_three_balls_in_a_row_have_an_order_on_its_edge():
    # After the blow has passed, the first two lie still against each other.
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    row = ik.combine(a=ball, b=ball, c=ball)
    touch = [
        ik.Contact(
            f"{one}/ball",
            at=[0.05, 0, 0],
            against=f"{two}/ball",
            normal=[-1, 0, 0],
            origin=[-0.05, 0, 0],
            restitution=1.0,
        )
        for one, two in (("a", "b"), ("b", "c"))
    ]
    scene = ik.Scene(row, contacts=touch, law=ik.Law(order="sequential"))
    v = np.zeros(18)
    v[0] = 1.0
    found = ik.derivatives(ik.solve(scene, row.neutral(), v))
    assert found.status is DerivativeStatus.MODE_EDGE
    assert "contacts[0]: it hardly approaches or hardly parts" in found.edges
    assert found.dv_after_dv[12, 0] == pytest.approx(1.0)


@pytest.mark.slow
def test_three_feet_of_solo12():
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    rng = np.random.default_rng(1)
    q = pin.integrate(solo.model, solo.neutral(), rng.uniform(-0.3, 0.3, solo.nv))
    v = rng.normal(size=solo.nv)
    v[2] -= 2.0
    feet = [ik.Contact(f, friction=0.2, restitution=0.3) for f in ("FL_FOOT", "FR_FOOT", "HL_FOOT")]
    assert_true(ik.Scene(solo, contacts=feet), q, v)


def test_redundant_contacts_against_differences_in_doubles():
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    feet = [
        ik.Contact("box", at=[x, y, -0.1], friction=0.8, restitution=0.4)
        for x in (-0.2, 0.2)
        for y in (-0.1, 0.1)
    ]
    scene = ik.Scene(box, contacts=feet)
    q, v = box.neutral(), np.array([0.3, 0.1, -2.0, 0, 0, 0.1])
    impact = ik.solve(scene, q, v)
    assert impact.status is ik.Status.SOLVED
    found = ik.derivatives(impact)
    assert found.status is DerivativeStatus.EXISTS
    # A box tilted by h about y turns at a rate in proportion to h: four corners in a tilted plane
    # cannot all stick then, and whichever of them slips, at some 7e-3 h² m/s, is a lawful answer.
    # A long step would measure how far these lie apart.
    by_q, by_v = _differences(scene, q, v, step=1e-5)
    assert np.abs(found.dv_after_dq - by_q).max() < 1e-7
    # A change of ω tilts the soles' targets out of what four sticking corners can do.
    assert np.abs(found.dv_after_dv - by_v).max() < 1e-7
    assert np.isnan(found.contacts["contacts[0]"].dv).all()
    assert np.isnan(found.dv_after_drestitution["contacts[0]"]).all()
    tilting = ik.derivatives(ik.solve(scene, q, v + 0.05 * np.eye(6)[3]))
    assert tilting.status is DerivativeStatus.RANK_CHANGES
    assert np.isnan(tilting.dv_after_dq).any() and not np.isnan(tilting.dv_after_dv).any()


def test_tables_of_impulses_are_made_on_first_access():
    """From then on they are the same; making them changes nothing that the others are made of."""
    q, v = falling()
    scene = ik.Scene(arm(), constraints=[ik.JointLock("slide")], contacts=contacts(2, 0.3))
    found = ik.derivatives(ik.solve(scene, q, v))
    for tables in (found.contacts, found.constraints):
        assert tables._found is None
        first, again = tables._build(), tables._build()
        assert list(tables) == list(first) == list(again) and len(tables) == len(first) > 0
        for name, table in tables.items():
            assert tables[name] is table
            assert not table.dq.flags.writeable
            assert np.array_equal(table.dq, first[name].dq)
            assert np.array_equal(first[name].dq, again[name].dq)
        with pytest.raises(TypeError):
            tables["floor"] = None


def _differences(scene, q, v, step=1e-3):
    """∂v⁺/∂q and ∂v⁺/∂v by Richardson's extrapolation of central differences."""

    def after(dq, dv):
        return ik.solve(scene, pin.integrate(scene.robot.model, q, dq), v + dv).v_after

    still = np.zeros_like(v)
    tables = []
    for way in (lambda d: after(d, still), lambda d: after(still, d)):
        columns = []
        for unit in np.eye(len(v)):
            coarse, fine = ((way(h * unit) - way(-h * unit)) / (2 * h) for h in (2 * step, step))
            columns.append((4 * fine - coarse) / 3)
        tables.append(np.array(columns).T)
    return tables


# -- where no derivative is -------------------------------------------------------------------


def ball():
    return ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


@pytest.mark.parametrize(
    ("velocity", "friction", "reason"),
    [
        ([1.0, 0, 0, 0, 0, 0], 0.0, "hardly presses"),
        ([1.0, 0, -1e-9, 0, 0, 0], 0.0, "hardly"),
    ],
)
def test_an_edge_is_named(velocity, friction, reason):
    scene = ik.Scene(ball(), contacts=[ik.Contact("ball", friction=friction, restitution=0.5)])
    found = ik.derivatives(ik.solve(scene, ball().neutral(), velocity))
    assert found.status is DerivativeStatus.MODE_EDGE
    assert reason in found.edges[0] and found.edges[0].startswith("contacts[0]")


def test_sticking_at_the_edge_of_the_cone():
    # At the mass centre W is m⁻¹: it sticks exactly while u_t⁻ ≤ µ u_n⁻.
    contact = ik.Contact("ball", friction=0.5)
    scene = ik.Scene(ball(), contacts=[contact])
    q = ball().neutral()
    edge = ik.derivatives(ik.solve(scene, q, [0.5, 0, -1.0, 0, 0, 0]))
    assert edge.status is DerivativeStatus.MODE_EDGE
    assert "cone" in edge.edges[0] or "slips" in edge.edges[0]
    for speed in (0.4, 0.6):
        assert ik.derivatives(ik.solve(scene, q, [speed, 0, -1.0, 0, 0, 0])).status.exists


def test_what_has_no_derivatives_of_this_kind_is_refused():
    with pytest.raises(ik.errors.InputError, match="takes an Impact"):
        ik.derivatives(None)


# -- inertias, far places, books -----------------------------------------------------------------


def test_by_inertia_against_changed_models():
    source = arm()
    own = contacts(1, 0.15)
    q, v = falling()
    found = ik.derivatives(ik.solve(ik.Scene(source, [blow("fore", 7)], contacts=own), q, v))
    joint_id = source.joint_id("shoulder")

    def after(change):
        model = pin.Model(source.model)
        values = model.inertias[joint_id].toDynamicParameters() + change
        model.inertias[joint_id] = pin.Inertia.FromDynamicParameters(values)
        scene = ik.Scene(ik.Robot.from_model(model), [blow("fore", 7)], contacts=own)
        return ik.solve(scene, q, v).v_after

    for k, direction in enumerate(np.eye(10)):
        coarse, fine = (
            (after(h * direction) - after(-h * direction)) / (2 * h) for h in (2e-4, 1e-4)
        )
        truth = (4 * fine - coarse) / 3
        ours = found.dv_after_dinertia("shoulder")[:, k]
        assert np.abs(ours - truth).max() < 1e-7 * max(1.0, np.abs(truth).max())


def test_far_from_the_origin_nothing_is_lost():
    scene = ik.Scene(arm(), [blow("fore", 1)], contacts=contacts(1, 0.15))
    q, v = falling()
    far = q.copy()
    far[:3] += [1e6, -2e6, 3e6]
    near, there = (ik.derivatives(ik.solve(scene, place, v)) for place in (q, far))
    assert np.array_equal(near.dv_after_dq, there.dv_after_dq)


def test_arrays_are_read_only_and_shapes_told():
    scene = ik.Scene(arm(), [blow("fore", 1)], contacts=contacts(2, 0.15))
    found = ik.derivatives(ik.solve(scene, *falling()))
    assert found.dv_after_dimpulse["blow"].shape == (8, 6)
    assert found.dv_after_dfriction["contacts[0]"].shape == (8,)
    assert found.contacts["contacts[0]"].dimpulse["blow"].shape == (3, 6)
    for array in (found.dv_after_dq, found.contacts["contacts[0]"].dq):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.status = None
