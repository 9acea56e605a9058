"""Gaps and closing speeds before and after a solve, against closed forms and differences."""

import math

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.urdf import link_text, robot_text
from impulsekit.errors import UnknownNameError
from tests.close import close


def body(name, shape):
    return robot_text(name, link_text(name, 1, shape=shape))


BALL = body("ball", "<sphere radius='0.1'/>")
BOX = body("box", "<box size='0.2 0.4 0.6'/>")


def two(first, second):
    made = [ik.Robot.from_urdf(text, root="freeflyer") for text in (first, second)]
    return ik.combine(a=made[0], b=made[1])


def test_a_ball_over_a_tilted_plane():
    robot = ik.Robot.from_urdf(BALL, root="freeflyer")
    normal = np.array([math.sin(0.3), 0, math.cos(0.3)])
    floor = ik.Contact("ball", at=[0, 0, 0.2], normal=normal, origin=[5, 6, 7], name="floor")
    q = robot.configuration(root_joint=[1, 2, 9, 0, 0, math.sin(0.2), math.cos(0.2)])
    v = robot.velocity(root_joint=[0, 0, -2, 0, 3, 0])
    found = ik.touching(ik.Scene(robot, contacts=[floor]), q, v)
    wanted = normal @ (np.array([1, 2, 9.2]) - [5, 6, 7])
    # The point is 0.2 m over the centre: turning about the body's y moves it along the body's x.
    way = np.array([0.6 * math.cos(0.4), 0.6 * math.sin(0.4), -2.0])
    assert found.contacts["floor"].gap == pytest.approx(wanted, abs=1e-14)
    assert found.contacts["floor"].closing_speed == pytest.approx(-normal @ way, abs=1e-14)
    assert found.contacts["floor"].touching


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("shapes", [(BALL, BALL), (BALL, BOX), (BOX, BOX)])
def test_a_closing_speed_is_the_rate_of_its_gap(shapes, seed):
    robot = two(*shapes)
    rng = np.random.default_rng(seed)
    q = pin.integrate(robot.model, robot.neutral(), rng.normal(size=12))
    v = rng.normal(size=12)
    scene = ik.Scene(
        robot,
        contacts=[
            ik.Collision("a/" + name_of(shapes[0]), "b/" + name_of(shapes[1]), name="pair"),
            ik.Contact(
                "a/" + name_of(shapes[0]),
                at=[0.1, 0, 0],
                against="b/" + name_of(shapes[1]),
                normal=[1, 2, 3],
                origin=[0, 0.3, 0],
                name="face",
            ),
        ],
    )
    found = ik.touching(scene, q, v)
    h = 1e-6
    ends = [ik.touching(scene, pin.integrate(robot.model, q, s * h * v)) for s in (-1, 1)]
    for name in ("pair", "face"):
        rate = (ends[1].contacts[name].gap - ends[0].contacts[name].gap) / (2 * h)
        assert found.contacts[name].closing_speed == pytest.approx(-rate, abs=1e-6)


def name_of(text):
    return text.split('"')[1]


def test_a_stop_is_measured_to_the_nearer_limit():
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(1))
    stop = ik.JointStop("joint_1", lower=-1.0, upper=2.0, name="stop")
    scene = ik.Scene(arm, contacts=[stop])
    for angle, gap, closing in ((1.7, 0.3, 4.0), (-0.8, 0.2, -4.0), (2.1, -0.1, 4.0)):
        q, v = arm.configuration(joint_1=angle), arm.velocity(joint_1=4.0)
        found = ik.touching(scene, q, v).contacts["stop"]
        assert (found.gap, found.closing_speed) == pytest.approx((gap, closing), abs=1e-15)
        assert found.angular and found.touching == (gap < 0)


def test_openings_of_anchors():
    robot = two(BALL, BALL)
    turn = pin.Quaternion(pin.exp3(np.array([0.3, 0.2, -0.7]))).coeffs()
    q = robot.configuration(
        {"a/root_joint": [1, 2, 3, *turn], "b/root_joint": [1.3, 2.4, 3, 0, 0, 0, 1]}
    )
    ends = {"frame": "a/ball", "other": "b/ball", "other_at": [0, 0, 0]}
    scene = ik.Scene(
        robot,
        constraints=[
            ik.PointAnchor(**ends, name="pin"),
            ik.FrameAnchor(**ends, directions=("x", "rx"), name="world x"),
            ik.FrameAnchor(**ends, directions=("z",), axes="local", name="own z"),
            ik.PointAnchor("a/ball", "b/ball", name="met anywhere"),
            ik.JointLock("a/root_joint", name="lock"),
        ],
        gap_bound=np.inf,
    )
    wanted = [0.5, 0.3, abs(pin.Quaternion(*turn[[3, 0, 1, 2]]).matrix()[:, 2] @ [0.3, 0.4, 0])]
    openings = [item.gap for item in ik.touching(scene, q).constraints]
    close(openings, [*wanted, 0.0, 0.0], 1e-14)
    impact = ik.solve(scene, q, robot.velocity())
    close([result.gap for result in impact.constraints], openings, 0.0)
    assert impact.to_dict()["constraints"][0]["gap"] == openings[0]


def test_results_carry_the_gap():
    robot = two(BALL, BALL)
    q = robot.configuration({"b/root_joint": [0.2, 0, 0, 0, 0, 0, 1]})
    scene = ik.Scene(
        robot,
        contacts=[
            ik.Collision("a/ball", "b/ball", name="hit"),
            ik.Contact("a/ball", at=[0, 0, -0.1], origin=[0, 0, -0.1], name="floor"),
            ik.Contact("b/ball", origin=[0, 0, -0.25], name="far"),
        ],
        gap_bound=0.3,
    )
    impact = ik.solve(scene, q, robot.velocity({"a/root_joint": [1, 0, 0, 0, 0, 0]}))
    gaps = [impact.contacts[name].gap for name in ("hit", "floor", "far")]
    close(gaps, [0, 0, 0.25], 1e-15)
    assert "gaps [m]: hit 0, floor 0, far 0.25" in ik.report(impact)
    apart = ik.solve(scene, robot.configuration({"b/root_joint": [2, 0, 0, 0, 0, 0, 1]}), impact.dv)
    assert apart.contacts["hit"].gap == pytest.approx(1.8)
    assert not apart.contacts["hit"].touching


def test_it_prints_as_a_table():
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    scene = ik.Scene(
        arm,
        constraints=[ik.PointAnchor("link_2", other_at=[0, 0, -1], name="pin")],
        contacts=[ik.Contact("link_1", at=[0, 0, -1], origin=[0, 0, -1.5], name="floor")],
    )
    text = str(ik.touching(scene, arm.neutral(), arm.velocity()))
    assert [line.split() for line in text.splitlines()] == [
        ["Contacts"],
        ["contact", "touching", "gap", "closing", "speed", "units"],
        ["-------", "--------", "---", "-------------", "------"],
        ["floor", "yes", "0.5", "0", "m,", "m/s"],
        ["Constraints"],
        ["constraint", "open", "by,", "m"],
        ["----------", "----------"],
        ["pin", "0"],
    ]
    with pytest.raises(UnknownNameError, match="floor"):
        ik.touching(scene, arm.neutral()).contacts["flor"]
