"""``check``: it agrees where the answer is right, and says no where anything is spoilt."""

from __future__ import annotations

import json

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main
from impulsekit.errors import InputError

from .reference.models import joint, link, robot
from .robots import STRUCK, random_blow, random_state
from .robots_with_armature import KINDS, random_configuration, random_robot

ROWS = ["Δv", "I", "P before", "P after", "mass centres", "rotations", "energy", "joint impulses",
        "joint couples"]  # fmt: skip
OF_CONSTRAINTS = ["constraint impulses", "constraint velocities"]


def solved(robot, impulses, constraints=(), contacts=(), seed=1):
    q, v = random_state(robot, seed)
    return ik.solve(ik.Scene(robot, impulses, constraints, contacts), q, v)


def spoilt(impact, factor=None, dv=None):
    """The same answer with another Δv."""
    other = impact.dv * factor if dv is None else dv
    return ik.Impact(impact.scene, impact.q.copy(), impact.v_before.copy(), other, impact.outcome)


@pytest.fixture(scope="module")
def world():
    """An arm and a ball in a world, which stand with a dog in a larger one."""
    rng = np.random.default_rng(5)

    def somewhere():
        turned = pin.exp3(rng.normal(size=3))
        return pin.SE3(turned, rng.normal(size=3))

    arm = ik.Robot.from_example("panda")
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    near = ik.combine(arm=arm, ball=ball, placements={"arm": somewhere(), "ball": somewhere()})
    dog = ik.Robot.from_example("solo12", root="freeflyer")
    return ik.combine(near=near, dog=dog, placements={"near": somewhere()})


@pytest.mark.slow
def test_constraints_agree():
    robot = ik.Robot.from_example("talos", root="freeflyer")
    blow = random_blow(STRUCK["talos"], 2)
    cases = [
        [ik.FrameAnchor("left_sole_link"), ik.FrameAnchor("right_sole_link")],
        [ik.FrameAnchor("left_sole_link", velocity="kept"),
         ik.PointAnchor("right_sole_link", at=(0.1, 0, 0), velocity=(0.1, 0, 0.2))],
        [ik.FrameAnchor("gripper_left_base_link", "gripper_right_base_link", (0.1, 0, 0),
                        directions=("x", "z", "ry"), axes="local", velocity=(0.1, 0.2, 0.3))],
        [ik.JointLock("torso_1_joint"), ik.JointLock("root_joint", velocity="kept"),
         ik.JointCoupling("arm_left_4_joint", ["arm_right_4_joint", "head_1_joint"],
                          ratio=[0.5, -2])],
        [ik.PointAnchor("world", "head_2_link", at=(1, 2, 3)),
         ik.FrameAnchor("world", "torso_2_link", directions=("rx", "ry"), axes="local")],
    ]  # fmt: skip
    for constraints in cases:
        check = ik.check(solved(robot, [blow], constraints))
        assert check.agrees, check
        assert [row.name for row in check.rows] == ROWS + OF_CONSTRAINTS
        assert max(row.difference for row in check.rows) < 0.1 * check.tolerance
        assert check.condition_of_rows > 1 and not check.notes


def test_redundant_constraints_are_compared_as_far_as_they_are_unique():
    robot = ik.Robot.from_example("talos", root="freeflyer")
    corners = [ik.PointAnchor("left_sole_link", at=(x, y, 0)) for x in (0.1, -0.1)
               for y in (0.05, -0.05)]  # fmt: skip
    lock = ik.JointLock("torso_1_joint")
    check = ik.check(solved(robot, [random_blow(STRUCK["talos"], 2)], [*corners, lock]))
    assert check.agrees, check
    assert check.row("constraint impulses").entries == ("constraints[4].lock",)
    assert len(check.row("constraint velocities").entries) == 13
    assert "more than one way" in check.notes[0]


def test_a_world_with_placements_agrees(world):
    blows = [
        random_blow("near/arm/panda_hand", 1),
        random_blow("dog/FR_FOOT", 2, "local"),
        ik.JointImpulse("near/ball/root_joint", (1, 2, 3, 4, 5, 6)),
    ]
    grip = ik.FrameAnchor("near/ball/ball", "near/arm/panda_hand")
    rope = ik.PointAnchor("dog/FL_FOOT", "near/ball/ball", at=(0.01, 0, 0), other_at=(0.1, 0, 0.1))
    assert ik.check(solved(world, blows)).agrees
    assert ik.check(solved(world, blows, [grip, rope])).agrees


def test_impulses_of_contacts_are_given_to_the_reference(world):
    ball = ik.Contact("near/ball/ball", against="near/arm/panda_hand", restitution=0.5)
    stop = ik.JointStop("near/arm/panda_joint2", lower=-20, upper=-10, restitution=0.5)
    q, v = random_state(world, 3)
    v[1] = 2.0  # on to the stop
    impact = ik.solve(ik.Scene(world, [random_blow("dog/FR_FOOT", 1)], [], [ball, stop]), q, v)
    assert all(result.touching for result in impact.contacts)
    assert impact.contacts[1].impulse[0] < 0
    check = ik.check(impact)
    assert check.agrees, check
    assert "contacts" in check.notes[0]
    assert not ik.check(spoilt(impact, 1 + 1e-6)).agrees


def test_fifty_digits():
    robot = ik.Robot.from_example("ur5")
    impact = solved(robot, [random_blow("tool0", 1)], [ik.JointLock("elbow_joint")])
    check = ik.check(impact, digits=50)
    assert check.agrees and check.numbers == "mpmath, 50 digits"
    assert not ik.check(spoilt(impact, 1 + 1e-6), digits=50).agrees
    loop = ik.PointAnchor("tool0", "forearm_link", at=(0.1, 0, 0))
    assert ik.check(solved(robot, [random_blow("tool0", 1)], [loop, loop]), digits=30).agrees


# -- it can say no -------------------------------------------------------------------------


def test_one_spoilt_entry_is_found_and_named():
    robot = ik.Robot.from_example("talos", root="freeflyer")
    impact = solved(robot, [random_blow(STRUCK["talos"], 1)])
    dv = impact.dv.copy()
    dv[robot.model.joints[robot.joint_id("head_1_joint")].idx_v] += 1e-6 * np.abs(dv).max()
    row = ik.check(spoilt(impact, dv=dv)).row("Δv")
    assert not row.agrees and row.entries[row.worst] == "head_1_joint"
    dv = dv.copy()
    dv[3] = np.nan
    assert not ik.check(spoilt(impact, dv=dv)).agrees


def test_spoilt_parts_are_found():
    robot = ik.Robot.from_example("panda")
    impact = solved(robot, [random_blow("panda_hand", 1)], [ik.JointLock("panda_joint3")])
    for part, row in (
        ("generalized_impulse", "I"),
        ("momentum_before", "P before"),
        ("momentum_after", "P after"),
    ):
        other = solved(robot, [random_blow("panda_hand", 1)], [ik.JointLock("panda_joint3")])
        vars(other)[part] = getattr(other, part) * (1 + 1e-9)
        failed = [r.name for r in ik.check(other).rows if not r.agrees]
        assert failed == ([row] if row == "I" else [row, "energy"])
    reactions = {name: wrench.copy() for name, wrench in impact.reactions.items()}
    reactions["panda_joint8"][4] += 1e-6
    vars(impact)["reactions"] = reactions
    failed = [r for r in ik.check(impact).rows if not r.agrees]
    assert [(r.name, r.entries[r.worst]) for r in failed] == [("joint couples", "panda_joint8 y")]


def test_a_constraint_left_out_is_found():
    robot = ik.Robot.from_example("talos", root="freeflyer")
    blow, foot = random_blow(STRUCK["talos"], 1), ik.FrameAnchor("left_sole_link")
    held, free = solved(robot, [blow], [foot]), solved(robot, [blow])
    check = ik.check(spoilt(held, dv=free.dv.copy()))
    assert not check.row("Δv").agrees and not check.row("constraint velocities").agrees


# -- what it is ----------------------------------------------------------------------------


def test_the_report_names_what_fails():
    robot = ik.Robot.from_example("panda")
    impact = solved(robot, [random_blow("panda_hand", 1)], [ik.JointLock("panda_joint3")])
    good, bad = str(ik.check(impact)), ik.check(spoilt(impact, 1.001)).report()
    assert good.endswith("Agrees: yes\n") and " NO" not in good
    assert "Agrees: NO, in Δv, P after, mass centres and 5 more" in bad
    for name in ROWS + OF_CONSTRAINTS:
        assert name in good


def test_the_tolerance_is_what_the_condition_allows():
    eps = np.finfo(float).eps
    masses = (1.0, 1e-6)
    rods = robot(
        link("base", "1"),
        *(link(f"rod_{i}", str(m), "1 0 0", inertia="0 0 0 0 0 0") for i, m in enumerate(masses)),
        joint("first", "base", "rod_0"),
        joint("second", "rod_0", "rod_1", at="1 0 0"),
    )
    uneven = ik.Robot.from_urdf(rods)
    check = ik.check(ik.solve(ik.Scene(uneven, [ik.JointImpulse("first", 1.0)]), [0, 1.0], [0, 0]))
    assert check.agrees
    assert check.tolerance == pytest.approx(max(1e-12, 10 * eps * check.condition))
    chain = ik.Robot.from_urdf(ik.models.chain_urdf(40), root="planar")
    check = ik.check(ik.solve(ik.Scene(chain, [random_blow("link_40", 1)]), chain.neutral(),
                              chain.velocity()))  # fmt: skip
    assert check.agrees and check.condition > 1e6
    assert check.tolerance == pytest.approx(10 * eps * check.condition)


# -- the command ---------------------------------------------------------------------------


def solve_command(*arguments):
    return CliRunner().invoke(main, ["solve", *arguments], prog_name="impulsekit")


def test_the_command_checks():
    result = solve_command("examples/whittaker_chain.toml", "--check")
    assert result.exit_code == 0 and result.stdout.endswith("Agrees: yes\n")
    assert "Agrees" not in solve_command("examples/whittaker_chain.toml").stdout
    result = solve_command("examples/whittaker_chain.toml", "--check", "--json", "-")
    assert json.loads(result.stdout)["valid"] and "Agrees: yes" in result.stderr


def test_the_command_exits_with_1_where_it_disagrees(monkeypatch):
    from impulsekit import checking

    monkeypatch.setattr(checking, "check", lambda impact: ik.check(spoilt(impact, 1.01)))
    result = solve_command("examples/whittaker_chain.toml", "--check")
    assert result.exit_code == 1 and "Agrees: NO, in Δv" in result.stdout


# -- what cannot be checked ----------------------------------------------------------------


def test_what_cannot_be_checked_says_so():
    panda = ik.Robot.from_example("panda")
    mixed = ik.combine(a=panda, b=ik.Robot.from_example("panda", root=pin.JointModelHX(0.1)))
    with pytest.raises(InputError, match=r'cannot be checked.*"b/root_joint".*HX'):
        ik.check(solved(mixed, [random_blow("a/panda_hand", 1)]))
    flying = ik.Robot.from_example("panda", root="freeflyer")
    q, v = random_state(flying, 1)
    q[3:7] *= 1 + 1e-7
    scene = ik.Scene(flying, [random_blow("panda_hand", 1)])
    with pytest.raises(InputError, match=r'cannot be checked.*quaternion of joint "root_joint"'):
        ik.check(ik.solve(scene, q, v))


@pytest.mark.parametrize(
    ("coupler", "words"),
    [
        ('<link name="coupler"/>', '"coupler" and all below it have neither mass'),
        (link("coupler", "1", inertia="0 0 0 0 0 0"), "singular: b can change"),
    ],
)
def test_masses_that_only_constraints_make_whole_cannot_be_checked(coupler, words):
    bar = "0 0 0 0 0 .01"
    loop = ik.Robot.from_urdf(
        robot(
            '<link name="ground"/>',
            link("crank", "1", ".2 0 0", inertia=bar),
            coupler,
            link("rocker", "1", ".2 0 0", inertia=bar),
            joint("a", "ground", "crank"),
            joint("b", "crank", "coupler", at=".4 0 0"),
            joint("c", "ground", "rocker", at="1 0 0"),
        )
    )
    closed = ik.PointAnchor("coupler", "rocker", at=(1, 0, 0), other_at=(0.4, 0, 0))
    scene = ik.Scene(loop, [ik.JointImpulse("a", 1.0)], [closed])
    with pytest.raises(InputError, match=f"cannot be checked.*{words}"):
        ik.check(ik.solve(scene, [1.0, -1.0, 1.0], [0, 0, 0]))


# -- robots that are no URDF ------------------------------------------------------------------


CHECKED = [kind for kind in KINDS if not kind.startswith(("helical", "ellipsoid"))]


@pytest.mark.parametrize("armature", [False, True])
@pytest.mark.parametrize("kind", CHECKED)
def test_a_given_model_is_checked_with_its_armature(kind, armature):
    rng = np.random.default_rng(3)
    robot = random_robot(rng, [kind, "revolute"], armature=armature)
    last = robot.links[-1].name
    q = random_configuration(robot, rng)
    scene = ik.Scene(
        robot,
        [random_blow(last, 1)],
        constraints=[ik.PointAnchor(last, at=[0.1, 0.2, 0.3])] if robot.nv > 5 else (),
    )
    impact = ik.solve(scene, q, rng.normal(size=robot.nv))
    result = ik.check(impact)
    assert result.agrees, result.report()
    assert {"Δv", "energy", "joint impulses"} <= {row.name for row in result.rows}
    assert not ik.check(spoilt(impact, 1.000001)).agrees


def test_a_rotor_that_the_check_overlooked_would_show():
    rng = np.random.default_rng(3)
    robot = random_robot(rng, ["revolute", "prismatic"])
    blow = random_blow("link_1", 1)
    impact = ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())
    robot.model.armature = np.zeros(robot.nv)
    assert not ik.check(impact).agrees
