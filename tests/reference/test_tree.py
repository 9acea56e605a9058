"""The tree of bodies: order, names, coordinates, and what is wrong with a URDF."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from impulsekit.errors import (
    UrdfError,
)
from impulsekit.reference import Arithmetic, KaneSystem, Tree

from .models import (
    EVERY_KIND,
    joint,
    link,
    mass_matrix,
    pinocchio_model,
    random_state,
    relative,
    robot,
)

TWO = [link("a"), link("b")]


@pytest.mark.parametrize("root", ["fixed", "planar", "freeflyer"])
def test_coordinates_and_speeds_lie_where_pinocchio_has_them(root):
    model, tree = pinocchio_model(EVERY_KIND, root), Tree.from_urdf(EVERY_KIND, root)
    assert len(tree.coordinate_names) == model.nq
    for name, theirs in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        ours = tree.joint(name)
        assert (ours.coordinates.start, ours.coordinates.stop) == (
            theirs.idx_q,
            theirs.idx_q + theirs.nq,
        )
        assert (ours.speeds.start, ours.speeds.stop) == (theirs.idx_v, theirs.idx_v + theirs.nv)
    assert tree.neutral() == pytest.approx(pin.neutral(model))


def test_fifty_digits_are_fifty_digits():
    """Rotations are orthogonal to the last digit although the URDF and q hold doubles."""
    fifty = Arithmetic.mpmath(50)
    system = KaneSystem.from_urdf(EVERY_KIND, "freeflyer", arithmetic=fifty)
    q, _ = random_state(pinocchio_model(EVERY_KIND, "freeflyer"), 2)
    for turned in system.kinematics(q).rotations:
        assert np.abs(turned @ turned.T - fifty.eye(3)).max() < 1e-48
    doubles = KaneSystem.from_urdf(EVERY_KIND, "freeflyer").generalized_masses(q)
    error = relative(doubles, system.generalized_masses(q))
    assert 1e-18 < error < 1e-14


# -- mimic -----------------------------------------------------------------------

GEARED = robot(
    link("base", "2"),
    link("one", ".5", ".1 .2 0"),
    link("two", ".7", ".3 0 .1"),
    link("three", ".3", "0 .1 .1"),
    joint("a_leader", "base", "one", axis="1 2 0", at=".1 0 0"),
    joint("b_slides", "one", "two", "prismatic", "0 1 1",
          more='<mimic joint="a_leader" multiplier="-0.7" offset="0.2"/>'),
    joint("c_turns", "base", "three", axis="0 0 -1", at="0 .3 0",
          more='<mimic joint="a_leader" multiplier="2" offset="-0.4"/>'),
)  # fmt: skip


@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
@pytest.mark.parametrize("mimic", [False, True])
def test_mimic_joints_are_read_as_pinocchio_reads_them(root, mimic):
    model = pinocchio_model(GEARED, root, mimic)
    system = KaneSystem.from_urdf(GEARED, root, mimic)
    q, _ = random_state(model, 4)
    assert system.n == model.nv == (1 if mimic else 3) + (6 if root == "freeflyer" else 0)
    assert relative(system.generalized_masses(q), mass_matrix(model, q)) < 1e-14


def test_the_angle_of_a_continuous_joint_is_followed():
    """Its coordinates are a cosine and a sine; the follower's angle is a multiple of the angle."""
    turning = GEARED.replace('type="revolute"', 'type="continuous"').replace(
        '<mimic joint="a_leader" multiplier="-0.7" offset="0.2"/>', ""
    )
    model = pinocchio_model(turning, "freeflyer", mimic=True)
    system = KaneSystem.from_urdf(turning, "freeflyer", mimic=True)
    assert system.joint("c_turns").mimics == "a_leader"
    for seed in range(5):
        q, y = random_state(model, seed)
        assert relative(system.generalized_masses(q), mass_matrix(model, q)) < 1e-14
        model.gravity.linear = np.array([1.0, 2.0, 3.0])
        wanted = pin.nonLinearEffects(model, model.createData(), q, y)
        found = -system.generalized_masses(q) @ system.accelerations(q, y, (1, 2, 3))
        assert relative(found, wanted) < 1e-13


def test_a_mimic_of_a_mimic_follows_the_first():
    chained = GEARED.replace('joint="a_leader" multiplier="2"', 'joint="b_slides" multiplier="2"')
    last = Tree.from_urdf(chained, mimic=True).joint("c_turns")
    assert (last.mimics, last.multiplier) == ("a_leader", 2 * -0.7)
    assert last.offset == pytest.approx(2 * 0.2 - 0.4)


# -- several in one world ------------------------------------------------------------


def test_parts_in_one_world_keep_their_own_answers():
    arm = KaneSystem.from_urdf(GEARED)
    ball = KaneSystem.from_urdf(robot(link("ball", "0.3", ".1 0 0")), "freeflyer")
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    both = KaneSystem.combine({"arm": ([1, 2, 3], quarter)}, arm=arm, ball=ball)
    assert both.speed_names == (
        *(f"arm/{n}" for n in arm.speed_names),
        *(f"ball/{n}" for n in ball.speed_names),
    )
    q = np.concatenate([[0.3, 0.1, -0.2], ball.neutral()])
    masses = both.generalized_masses(q)
    assert masses[:3, :3] == pytest.approx(arm.generalized_masses(q[:3]), abs=1e-15)
    assert masses[3:, 3:] == pytest.approx(ball.generalized_masses(q[3:]), abs=1e-15)
    assert not masses[:3, 3:].any()
    at = both.kinematics(q)
    wanted = quarter @ arm.kinematics(q[:3]).mass_centres[1] + [1, 2, 3]
    assert at.mass_centres[both.body_of_link("arm/one")] == pytest.approx(wanted)


# -- what is wrong with a URDF ---------------------------------------------------------

WRONG = {
    "broken XML": ("<robot><link", "robot", "the XML is broken"),
    "another document": ("<sdf/>", "sdf", "not <robot>"),
    "empty": (robot(), "robot", "no link"),
    "nameless": (robot('<link/>'), "link", "has no name"),
    "twice": (robot(link("a"), link("a")), 'link "a"', "two links have this name"),
    "unknown kind": (
        robot(*TWO, joint("j", "a", "b", "ball")), 'joint "j"', '"ball" is unknown; URDF knows'),
    "missing link": (
        robot(*TWO, joint("j", "a", "c")), 'joint "j"', 'child link "c" does not exist'),
    "no parent": (
        robot(*TWO, '<joint name="j" type="fixed"><child link="b"/></joint>'),
        'joint "j"', "no <parent link>"),
    "two parents": (
        robot(*TWO, link("c"), joint("j", "a", "c"), joint("k", "b", "c"), joint("l", "a", "b")),
        'link "c"', 'a loop: it is the child of two joints, "j" and "k"'),
    "a ring": (
        robot(*TWO, link("c"), joint("j", "a", "b"), joint("k", "b", "a")),
        'link "a"', "a loop: it is below itself"),
    "two roots": (robot(*TWO), 'link "b"', 'two roots, "a" is the other'),
    "no mass value": (
        robot('<link name="a"><inertial><inertia ixx="1"/></inertial></link>'),
        'link "a"', "no <mass value>"),
    "no inertia": (
        robot('<link name="a"><inertial><mass value="1"/></inertial></link>'),
        'link "a"', "no <inertia>"),
    "part of an inertia": (
        robot('<link name="a"><inertial><mass value="1"/><inertia ixx="1"/></inertial></link>'),
        'link "a"', "no ixy"),
    "negative mass": (robot(link("a", "-1")), 'link "a"', "its mass is -1 kg"),
    "not a number": (robot(link("a", at="0 zero 0")), 'link "a"', "expected 3 finite numbers"),
    "infinite": (robot(link("a", "inf")), 'link "a"', "expected 1 finite number"),
    "an axis of no length": (
        robot(*TWO, joint("j", "a", "b", axis="0 0 0")), 'joint "j"', "its axis has no length"),
    "no masses": (
        robot(link("a"), '<link name="b"/>', '<link name="c"/>',
              joint("j", "a", "b"), joint("k", "b", "c", "fixed")),
        'joint "j"', 'link "b" and all below it have neither mass nor inertia'),
}  # fmt: skip


@pytest.mark.parametrize("fault", WRONG)
def test_what_is_wrong_is_said_with_the_name_of_the_element(fault):
    urdf, element, message = WRONG[fault]
    with pytest.raises(UrdfError, match="URDF given as a string") as caught:
        Tree.from_urdf(urdf)
    assert caught.value.element == element
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("mimicked", "message"),
    [("nobody", '"nobody" that it mimics does not exist'), ("c_turns", "it mimics itself"),
     ("welded", "both need a single speed")],
)  # fmt: skip
def test_a_mimic_needs_somebody_to_follow(mimicked, message):
    urdf = GEARED.replace(
        'joint="a_leader" multiplier="2"', f'joint="{mimicked}" multiplier="2"'
    ).replace("</robot>", link("tip") + joint("welded", "three", "tip", "fixed") + "</robot>")
    with pytest.raises(UrdfError, match=message) as caught:
        Tree.from_urdf(urdf, mimic=True)
    assert caught.value.element == 'joint "c_turns"'
    assert Tree.from_urdf(urdf).n == 3  # of no concern where mimics are independent
