"""Closed loops: against Kane's equations and maximal coordinates, redundant, singular."""

from __future__ import annotations

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.truths.maximal import impact_of_free_bodies
from impulsekit.errors import ContradictionError, SingularMassError
from impulsekit.reference import KaneSystem, Load, Rows
from impulsekit.reference.rows import angular_velocity_rows

from ..close import close
from ..reference.models import FOUR_BAR, four_bar_pose, joint, link, robot
from ..robots import random_blow

SIX_BAR = FOUR_BAR.replace('<link name="ground"/>', link("ground", "4", inertia=".3 0 0 .4 0 .5"))
SIX_BAR = SIX_BAR.replace(
    "</robot>",
    link("arm", "0.8", ".15 0 .01", inertia=".004 0 0 .01 .001 .012")
    + link("lever", "1.1", ".2 .03 0", inertia=".006 0 0 .03 0 .04")
    + joint("arm_pin", "coupler", "arm", at=".5 .3 0")
    + joint("lever_pin", "ground", "lever", "continuous", at="1.2 .6 0")
    + "</robot>",
)
"""Watt's: the four-bar, and from its coupler an arm that ends at a lever."""

PIN = ik.PointAnchor("coupler", "rocker", at=(0.8, 0, 0), name="pin")
KNEE = ik.FrameAnchor(
    "arm",
    "lever",
    at=(0.4, 0, 0),
    directions=("x", "y", "z", "rx", "ry"),
    axes="local",
    name="knee",
)


# -- against the reference -----------------------------------------------------------------


def closing_rows(system, q, anchors):
    """The rows of anchors whose second point is the one that coincides with the first."""
    at, tree, rows = system.kinematics(q), system, []
    for anchor in anchors:
        first, second = tree.body_of_link(anchor.frame), tree.body_of_link(anchor.other)
        place = at.origins[first] + at.rotations[first] @ np.array(anchor.at)
        other_at = at.rotations[second].T @ (place - at.origins[second])
        axes = at.rotations[first].T if isinstance(anchor, ik.FrameAnchor) else np.eye(3)
        rows.append(system.rows_at_point(q, anchor.frame, anchor.other, anchor.at, other_at, axes))
        if isinstance(anchor, ik.FrameAnchor):
            rows.append(angular_velocity_rows(system, anchor.frame, anchor.other, axes[:2]))
    return Rows.stack(system, rows)


CASES = {
    "four-bar": (FOUR_BAR, "fixed", [PIN], 40),
    "one loop that flies": (SIX_BAR, "freeflyer", [PIN], 10),
    "six-bar": (SIX_BAR, "fixed", [PIN, KNEE], 35),
    "two loops that fly": (SIX_BAR, "freeflyer", [PIN, KNEE], 15),
}


@pytest.mark.parametrize("case", CASES)
def test_struck_linkages_in_a_hundred_poses(case):
    """Any pose is one of a closed linkage: its last pin sits where the chains happen to meet."""
    urdf, root, anchors, poses = CASES[case]
    body, system = ik.Robot.from_urdf(urdf, root=root), KaneSystem.from_urdf(urdf, root)
    blow = random_blow("coupler", 1)
    scene = ik.Scene(body, [blow, ik.JointImpulse("crank_pin", 0.3)], anchors)
    load = Load("coupler", blow.linear, blow.angular, blow.at)
    rng = np.random.default_rng(poses)
    worst = 0.0
    for _ in range(poses):
        q = body.neutral()
        for name in body.joint_names:
            if name != "root_joint":
                q = set_angle(body, q, name, rng.uniform(-np.pi, np.pi))
        v = rng.normal(size=body.nv)
        impact = ik.solve(scene, q, v)
        given = (q, v, [load], {"crank_pin": 0.3}, closing_rows(system, q, anchors))
        kane, maximal = system.impact(*given), impact_of_free_bodies(system, *given)
        size = max(np.abs(impact.v_before).max(), np.abs(kane.dy).max())
        for reference in (kane, maximal):
            worst = max(worst, np.abs(impact.dv - reference.dy).max() / size)
        assert worst < 1e-10, q
    assert worst > 0


def set_angle(body, q, name, angle):
    item = body.model.joints[body.joint_id(name)]
    q[item.idx_q : item.idx_q + item.nq] = (
        [np.cos(angle), np.sin(angle)] if item.nq == 2 else [angle]
    )
    return q


# -- redundant -----------------------------------------------------------------------------


def chain(links=3):
    """A planar chain on the world, bent."""
    parts = ['<link name="ground"/>']
    for k in range(links):
        parts.append(link(f"rod_{k}", "1", ".5 0 0", inertia=".001 0 0 .0833 0 .0833"))
        above = f"rod_{k - 1}" if k else "ground"
        parts.append(joint(f"pin_{k}", above, f"rod_{k}", at="1 0 0" if k else "0 0 0"))
    return ik.Robot.from_urdf(robot(*parts))


def test_six_rows_on_a_planar_chain():
    """Three of them move nothing; Pinocchio's impulseDynamics by J answers (-.17, .22, .07)."""
    body = chain()
    q, v = np.array([0.3, 0.5, -0.4]), np.array([1.0, -2.0, 0.5])
    held = ik.solve(ik.Scene(body, [], [ik.FrameAnchor("rod_2", at=(1, 0, 0))]), q, v)
    close(held.v_after, 0, 1e-14)
    result = held.constraints[0]
    assert result.rows == ("x", "y", "z", "rx", "ry", "rz") and not result.unique
    assert result.unique_rows == (True, True, False, False, False, True)
    assert not result.impulse[2:5].any()
    plane = ik.FrameAnchor("rod_2", at=(1, 0, 0), directions=("x", "y", "rz"))
    flat = ik.solve(ik.Scene(body, [], [plane]), q, v).constraints[0]
    assert flat.unique
    close(result.impulse[[0, 1, 5]], flat.impulse, 1e-12)


def test_what_is_shared_is_told_apart_from_what_is_not():
    """A hinge on a hinge: of five rows each, the loop leaves only some undetermined."""
    body = ik.Robot.from_urdf(FOUR_BAR)
    q = four_bar_pose(1.0)
    pin = ik.PointAnchor("coupler", "rocker", at=(0.8, 0, 0), other_at=(0.5, 0, 0), name="pin")
    impact = ik.solve(ik.Scene(body, [random_blow("coupler", 1)], [pin]), q, [1, 2, 3])
    assert impact.constraints[0].unique_rows == (True, True, False)
    kane = KaneSystem.from_urdf(FOUR_BAR)
    blow = impact.scene.impulses[0]
    load = Load("coupler", blow.linear, blow.angular, blow.at)
    rows = kane.rows_at_point(q, "coupler", "rocker", (0.8, 0, 0), (0.5, 0, 0))
    reference = kane.impact(q, [1, 2, 3], [load], None, rows)
    close(impact.constraints[0].impulse, reference.row_impulses, 1e-12)
    # A lock of the crank makes the loop rigid, and nothing more is shared.
    locked = ik.Scene(body, [blow], [pin, ik.JointLock("crank_pin")])
    rigid = ik.solve(locked, q, [1, 2, 3])
    close(rigid.v_after, 0, 1e-13)
    assert [r.unique_rows for r in rigid.constraints] == [(True, True, False), (True,)]
    # A second lock does: three rows for the two that are left, on which all three act.
    locked = ik.Scene(body, [blow], [pin, ik.JointLock("crank_pin"), ik.JointLock("rocker_pin")])
    shared = ik.solve(locked, q, [1, 2, 3])
    close(shared.v_after, 0, 1e-13)
    assert [r.unique_rows for r in shared.constraints] == [(False,) * 3, (False,), (False,)]


# -- singular ------------------------------------------------------------------------------


def test_rods_in_line():
    """Held at the tip, straight rods cannot stretch anyway: one row does nothing."""
    body = chain(2)
    q, v = np.zeros(2), np.array([1.0, 0.5])
    tip = ik.PointAnchor("rod_1", at=(1, 0, 0))
    impact = ik.solve(ik.Scene(body, [], [tip]), q, v)
    # M for rods of 1 kg and 1 m about the pins, and the row (2, 1) on the speeds.
    third = 0.0833 + 0.25
    masses = np.array([[2 * third + 2, third + 0.5], [third + 0.5, third]])
    row = np.array([2.0, 1.0])
    push = np.linalg.solve(masses, row)
    close(impact.v_after, v - push * (row @ v) / (row @ push), 1e-13)
    assert impact.constraints[0].unique_rows == (False, True, False)
    assert impact.constraints[0].impulse[0] == 0.0
    stretched = ik.PointAnchor("rod_1", at=(1, 0, 0), velocity=(1, 0, 0), name="pull")
    with pytest.raises(ContradictionError, match=r"pull\.x") as caught:
        ik.solve(ik.Scene(body, [], [stretched]), q, v)
    assert caught.value.rows == ("pull.x",)


@pytest.mark.parametrize("bend", [0.0, 1e-12, 1e-9, 1e-8])
@pytest.mark.parametrize("heading", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("directions", [("x",), ("x", "y"), ("y", "x", "z"), ("x", "rx")])
def test_rods_in_line_but_for_rounding_count_as_in_line(bend, heading, directions):
    """A row that is zero but for rounding holds nothing, whichever way its axes point."""
    aim = ik.FrameAnchor("aim", "rod_1", at=(2, 0, 0), directions=directions, axes="local")
    impact = ik.solve(ik.Scene(aimed_chain(heading), [], [aim]), [0.9 + bend, -2 * bend], [1, 0.5])
    wanted = [1.0, 0.5]
    if "y" in directions:
        scene = ik.Scene(chain(2), [], [ik.PointAnchor("rod_1", at=(1, 0, 0))])
        wanted = ik.solve(scene, [0, 0], [1, 0.5]).v_after
    close(impact.v_after, wanted, 3e-7)
    result = impact.constraints[0]
    assert result.unique_rows == tuple(row == "y" for row in result.rows)
    assert np.abs(result.impulse).max() < 2


def aimed_chain(heading):
    """Two rods on a base that stands askew, and a mark on it whose x axis the rods follow."""
    rod = {"at": ".5 0 0", "inertia": ".001 0 0 .0833 0 .0833"}
    return ik.Robot.from_urdf(
        robot(
            '<link name="ground"/><link name="base"/><link name="aim"/>',
            joint("stand", "ground", "base", "fixed", at="1 2 3", rpy=f"0.4 0.3 {heading}"),
            joint("sight", "base", "aim", "fixed", rpy="0 0 0.9"),
            link("rod_0", "1", **rod),
            link("rod_1", "1", **rod),
            joint("pin_0", "base", "rod_0"),
            joint("pin_1", "rod_0", "rod_1", at="1 0 0"),
        )
    )


@pytest.mark.parametrize(("frame", "at"), [("rod_0", (0, 0, 0)), ("rod_1", (-1, 0, 0))])
def test_a_point_on_a_pivot_is_held_by_the_pivot(frame, at):
    """Its rows are zero but for rounding: nothing is taken, nothing moves."""
    body = aimed_chain(0.3)
    impact = ik.solve(ik.Scene(body, [], [ik.PointAnchor(frame, at=at)]), [0.7, 0.0], [1.0, 0.0])
    close(impact.v_after, [1.0, 0.0], 1e-13)
    assert not impact.constraints[0].impulse.any()


COUPLER_SPAN = 0.8


def two_force_member(mass="0"):
    """Crank and rocker of the four-bar, joined by a coupler that weighs next to nothing."""
    coupler = link(
        "coupler", mass, f"{COUPLER_SPAN / 2} 0 0", inertia=f"{mass} 0 0 {mass} 0 {mass}"
    )
    return robot(
        link("crank", "1.2", ".2 .01 .02", inertia=".01 0 0 .05 .002 .06"),
        '<link name="coupler"/>' if mass == "0" else coupler,
        link("rocker", "1.5", ".25 .02 0", inertia=".01 0 .003 .08 0 .09"),
        '<link name="ground"/>',
        joint("crank_pin", "ground", "crank", "continuous"),
        joint("coupler_pin", "crank", "coupler", at=".4 0 0"),
        joint("rocker_pin", "ground", "rocker", "continuous", at="1 0 0"),
    )


@pytest.mark.parametrize("crank", [0.4, 1.3, 2.1])
def test_a_massless_coupler(crank):
    """M is singular, the whole is not: the coupler pushes along itself and nothing else."""
    body = ik.Robot.from_urdf(two_force_member())
    q, v = four_bar_pose(crank), np.array([1.0, 2.0, -3.0])
    pin = ik.PointAnchor("coupler", "rocker", at=(COUPLER_SPAN, 0, 0), other_at=(0.5, 0, 0))
    blows = [random_blow("crank", 1), ik.JointImpulse("rocker_pin", 0.7)]
    impact = ik.solve(ik.Scene(body, blows, [pin]), q, v)

    masses = impact.mechanics.mass_matrix
    assert np.linalg.matrix_rank(masses) == 2
    known = sum(impact.impulse_shares[f"impulses[{i}]"] for i in range(2))
    angle = crank + q[2]
    along = np.array([np.cos(angle), np.sin(angle), 0])
    jacobians = [impact.mechanics.point_jacobian(frame, np.array(at))[:3]
                 for frame, at in (("crank", (0.4, 0, 0)), ("rocker", (0.5, 0, 0)))]  # fmt: skip
    two = [0, 2]  # crank and rocker; the coupler's own speed follows from its ends
    row = (along @ (jacobians[0] - jacobians[1]))[two]
    inertia = masses[np.ix_(two, two)]
    free = v[two] + np.linalg.solve(inertia, known[two])
    push = np.linalg.solve(inertia, row)
    thrust = -(row @ free) / (row @ push)
    after = free + push * thrust
    close(impact.v_after[two], after, 1e-12 * np.abs(free).max())
    close(impact.constraints[0].impulse, thrust * along, 1e-12 * abs(thrust))
    assert impact.constraints[0].unique_rows == (True, True, False)
    there = impact.velocity_at("coupler", (COUPLER_SPAN, 0, 0)).after
    assert (
        np.abs(there - impact.velocity_at("rocker", (0.5, 0, 0)).after).max()
        < 1e-12 * np.abs(impact.v_after).max()
    )
    close(impact.reactions["coupler_pin"][:3], -thrust * along, 1e-11)
    assert impact.is_valid(1e-11)


def test_a_massless_link_that_nothing_holds_is_refused():
    body = ik.Robot.from_urdf(two_force_member())
    away = ik.PointAnchor("crank", "rocker", at=(0.4, 0, 0))
    with pytest.raises(SingularMassError, match="coupler_pin") as caught:
        ik.solve(ik.Scene(body, [], [away]), four_bar_pose(1.3), [1.0, 2.0, 3.0])
    assert caught.value.joints == ("coupler_pin",)


def written_parallelogram(tilt, warp, root):
    """A parallelogram in a plane that is ``tilt`` off the world's axes and warped by ``warp``."""
    inertia = "0.02 0 0 0.03 0 0.01"
    text = robot(
        link("base", "4", inertia=".3 0 0 .4 0 .5"),
        link("up", "1", "0 0 .25", inertia=inertia),
        link("across", "2", ".5 0 0", inertia=inertia),
        link("down", "1", "0 0 -.25", inertia=inertia),
        joint("a", "base", "up", axis="0 1 0", rpy=f"0 0 {tilt}"),
        joint("b", "up", "across", axis="0 1 0", at="0 0 .5", rpy=f"{warp} 0 0"),
        joint("c", "across", "down", axis="0 1 0", at="1 0 0", rpy=f"{-2 * warp} 0 0"),
    )
    made = ik.Robot.from_urdf(text, root)
    place = made.placement(made.neutral(), "down").point([0, 0, -0.5])
    pin_d = ik.PointAnchor("down", "base", at=(0, 0, -0.5), other_at=tuple(place))
    return made, ik.Scene(made, [ik.AppliedImpulse("across", linear=[1, 2, 3])], [pin_d])


@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
@pytest.mark.parametrize("warp", [0.0, 1e-9, 2e-9])
def test_a_loop_in_a_plane_is_not_locked_by_the_last_digits_of_its_file(root, warp):
    plain, straight = written_parallelogram(0.0, 0.0, root)
    wanted = ik.solve(straight, plain.neutral(), plain.velocity())
    tilted, scene = written_parallelogram(3.7e-6, warp, root)
    impact = ik.solve(scene, tilted.neutral(), tilted.velocity())
    assert impact.is_valid() and ik.check(impact).agrees
    np.testing.assert_allclose(impact.v_after, wanted.v_after, atol=1e-5)
    assert abs(impact.v_after[-1]) > 0.1, "it moves"
    # A row that is short for rounding does not carry a thousand times the others.
    assert np.abs(impact.constraints[0].impulse).max() < 10.0
    outputs = ("v_after", "constraint_impulses")
    batch = ik.solve_batch(scene, impact.q[None], impact.v_before[None], outputs=outputs)
    close(batch.v_after[0], impact.v_after, 1e-9)
    np.testing.assert_allclose(
        batch.constraint_impulses[0], impact.constraints[0].impulse, atol=1e-6
    )
