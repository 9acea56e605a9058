"""What is likely not meant is warned of once, at the border, and never per row of a batch."""

import math
import warnings

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import SetupWarning, SingularMassError
from impulsekit.scenefile import dump_scene

from ..robots import one_body


def ball():
    return one_body("ball", 1, 0.1, '<sphere radius="0.1"/>')


def falling(height, **scene):
    """A ball whose lowest point is ``height`` over the floor and comes down."""
    robot = ball()
    floor = ik.Contact("ball", at=[0, 0, -0.1], restitution=0.5, name="floor")
    q = robot.configuration(root_joint=[0, 0, 0.1 + height, 0, 0, 0, 1])
    v = robot.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    return ik.Scene(robot, contacts=[floor], **scene), q, v


@pytest.mark.parametrize(
    ("height", "words"),
    [
        (0.3, 'floor: "ball" is 0.3 m away from the plane of "world"'),
        (-0.02, 'floor: "ball" is 0.02 m under its floor'),
    ],
)
def test_a_gap_past_a_millimetre_warns_once_a_scene(height, words):
    scene, q, v = falling(height)
    with pytest.warns(SetupWarning) as caught:
        impact = ik.solve(scene, q, v)
    assert caught[0].message.doubts == (words,)
    assert caught[0].filename == __file__
    assert f"warning: {words}" in ik.report(impact)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = ik.solve(scene, q, v)
    assert again.doubts == impact.doubts == (words,)


@pytest.mark.parametrize(
    ("height", "bound"), [(0.0, 1e-3), (9e-4, 1e-3), (-9e-4, 1e-3), (0.2, 0.3), (5.0, math.inf)]
)
def test_within_the_bound_nothing_is_said(height, bound):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        impact = ik.solve(*falling(height, gap_bound=bound))
    assert impact.doubts == ()


def test_the_bound_is_kept_in_scene_files(tmp_path):
    for bound in (0.25, math.inf):
        scene, q, v = falling(0.0, gap_bound=bound)
        text = dump_scene(scene, q, v)
        path = tmp_path / "scene.toml"
        path.write_text(text)
        assert ik.load_scene(path).scene.gap_bound == bound
    assert "gap_bound" not in dump_scene(*falling(0.0))
    with pytest.raises(ik.errors.RangeError, match="gap_bound"):
        falling(0.0, gap_bound=-1.0)


def test_an_open_anchor_and_overlapping_bodies():
    robot = ik.combine(a=ball(), b=ball())
    q = robot.configuration({"b/root_joint": [0.15, 0, 0, 0, 0, 0, 1]})
    pin = ik.PointAnchor("a/ball", "b/ball", at=[0.1, 0, 0], other_at=[0, 0, 0], name="pin")
    hit = ik.Collision("a/ball", "b/ball", name="hit")
    v = robot.velocity({"a/root_joint": [1, 0, 0, 0, 0, 0]})
    with pytest.warns(SetupWarning, match=r"pin is open by 0\.05 m"):
        ik.solve(ik.Scene(robot, constraints=[pin]), q, v)
    with pytest.warns(SetupWarning, match=r'hit: "a/ball" and "b/ball" overlap by 0\.05 m'):
        ik.solve(ik.Scene(robot, contacts=[hit]), q, v)


def test_nothing_strikes():
    scene, q, v = falling(0.0)
    for speed, reason in ((0.0 * v, "the robot is at rest"), (-v, "no contact that touches is")):
        fresh = ik.Scene(scene.robot, contacts=scene.contacts)
        with pytest.warns(SetupWarning, match=f"nothing strikes: .*{reason}"):
            ik.solve(fresh, q, speed)
    with pytest.warns(SetupWarning, match="no impulses, constraints or contacts"):
        ik.solve(ik.Scene(scene.robot), q, v)
    robot = ik.combine(a=ball(), b=ball())
    q = robot.configuration({"b/root_joint": [0.5, 0, 0, 0, 0, 0, 1]})
    v = robot.velocity({"a/root_joint": [1, 0, 0, 0, 0, 0]})
    pair = ik.Collision("a/ball", "b/ball", name="pair")
    with pytest.warns(SetupWarning, match=r"no contact touches; the nearest, pair, is 0\.3 m"):
        ik.solve(ik.Scene(robot, contacts=[pair]), q, v)


def test_a_blow_that_is_held_does_strike():
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(1))
    blow = ik.AppliedImpulse("link_1", linear=[1, 0, 0], at=[0, 0, -1])
    scene = ik.Scene(arm, [blow], constraints=[ik.JointLock("joint_1")])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ik.solve(scene, arm.neutral(), arm.velocity())


def test_a_robot_under_its_ground():
    robot = ball().with_ground(0.5)
    blow = ik.AppliedImpulse("ball", linear=[1, 0, 0])
    with pytest.warns(SetupWarning, match=r'under its floor "ground".*"ball" by 0\.5 m'):
        ik.solve(ik.Scene(robot, [blow]), robot.neutral(), robot.velocity())


def test_degrees_are_asked_for():
    arm = ik.Robot.from_example("ur5")
    with pytest.warns(SetupWarning, match=r"elbow_joint.* 90 rad.*degrees\? 90° fits") as caught:
        q = arm.configuration(elbow_joint=90)
    assert caught[0].filename == __file__
    # A little past a limit, or far past it in degrees too: no such guess.
    panda = ik.Robot.from_example("panda")
    for value in (3.0, 700):
        with pytest.warns(SetupWarning, match="outside") as caught:
            panda.configuration(panda_joint1=value)
        assert "degrees" not in str(caught[0].message)
    blow = ik.AppliedImpulse("tool0", linear=[0, 0, 1])
    with pytest.warns(SetupWarning, match="degrees"):
        ik.solve(ik.Scene(arm, [blow]), q, arm.velocity())


def test_angles_within_limits_and_joints_that_nobody_set_are_fine():
    # Zero is outside the limits of the Panda's fourth joint.
    panda = ik.Robot.from_example("panda")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        q = panda.configuration(panda_joint2=0.5)
        blow = ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])
        assert ik.solve(ik.Scene(panda, [blow]), q, panda.velocity()).doubts == ()


def test_the_command_warns_on_stderr_in_plain_words(tmp_path):
    from click.testing import CliRunner

    from impulsekit.cli import main

    path = tmp_path / "scene.toml"
    path.write_text(
        '[robot]\nexample = "ur5"\n[state.q]\nelbow_joint = 90\n'
        '[[impulses]]\nframe = "tool0"\nlinear = [0, 0, 1]\n'
    )
    done = CliRunner().invoke(main, ["solve", str(path)])
    assert done.exit_code == 0
    (line,) = done.stderr.splitlines()
    assert line.startswith('warning: joint "elbow_joint" is at 90 rad')


def head_of_icub(**pose):
    """iCub struck on its head, whose mass lies all but on the axis of the neck's roll."""
    robot = ik.Robot.from_example("icub")
    blow = ik.AppliedImpulse("head", linear=[0, 0.3, 1])
    return ik.Scene(robot, [blow]), robot.configuration(**pose), robot.velocity()


def test_joints_that_next_to_no_inertia_resists_are_named():
    with pytest.warns(SetupWarning, match='"neck_roll", "neck_yaw" here'):
        ik.solve(*head_of_icub(neck_yaw=1e-3))


def test_inertia_that_is_small_but_counts_is_no_doubt():
    assert not ik.solve(*head_of_icub(neck_yaw=0.1)).doubts


def test_a_lock_on_such_a_joint_leaves_no_doubt():
    scene, q, v = head_of_icub()
    held = ik.Scene(scene.robot, scene.impulses, constraints=[ik.JointLock("neck_yaw")])
    assert not ik.solve(held, q, v).doubts


@pytest.mark.parametrize("feet", [0, 1, 2])
def test_what_rounding_alone_resists_is_refused(feet):
    scene, q, v = head_of_icub()
    frames = ("head", "l_hand")[:feet]
    contacts = [ik.Contact(frame, normal=[0, 0, 1]) for frame in frames]
    touching = ik.Scene(scene.robot, scene.impulses, contacts=contacts)
    with pytest.raises(SingularMassError, match='"neck_roll", "neck_yaw" moves no mass'):
        ik.solve(touching, q, v)


def test_rolling_friction_without_a_unit_is_doubted():
    robot = ball()
    v = robot.velocity(root_joint=[0, 0, -1, 0, 0, 1])
    for rolling, torsion, word in ((0.5, 0.01, "rolling is 0.5 m"), (0.01, 5.0, "torsion is 5 m")):
        floor = ik.Contact("ball", at=[0, 0, -0.1], rolling=rolling, torsion=torsion)
        scene = ik.Scene(robot, contacts=[floor], gap_bound=np.inf)
        with pytest.warns(SetupWarning, match=f"{word}; it is a length"):
            ik.solve(scene, robot.neutral(), v)


def test_a_batch_counts_the_rows_whose_contacts_are_open():
    scene, q, v = falling(0.95)
    heights = np.repeat(q[None], 4, axis=0)
    heights[:, 2] += [0.0, -0.95, -0.45, -1.0]
    with pytest.warns(SetupWarning, match="floor is open in 2 of 4 rows") as caught:
        batch = ik.solve_batch(scene, heights, v)
    assert caught[0].filename == __file__ and list(batch.arrays) == ["v_after"]
    assert batch.doubts == (
        "floor is open in 2 of 4 rows, by up to 0.95 m",
        "floor overlaps in 1 of 4 rows, by up to 0.05 m",
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ik.solve_batch(scene, heights, v).doubts == batch.doubts
        fine = falling(0.95, gap_bound=math.inf)[0]
        gaps = ik.solve_batch(fine, heights, v, outputs=("gaps",))
    assert gaps.doubts == ()
    np.testing.assert_allclose(gaps.gaps[:, 0], [0.95, 0.0, 0.5, -0.05], atol=1e-15)
    ground = ik.Scene(ball().with_ground(), contacts=[ik.Collision("ball", "ground")])
    touched = ik.solve_batch(ground, heights, v, outputs=("gaps",)).gaps[:, 0]
    assert np.isnan(touched[:1]).all() and touched[3] == pytest.approx(-0.05)


BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
FLOOR = ik.Contact("ball", at=[0, 0, -0.05], name="floor")
Q, V = BALL.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1]), BALL.velocity()


def test_a_motion_without_a_duration_says_how_long_it_is():
    with pytest.warns(SetupWarning, match="the motion ends after 1 s") as caught:
        motion = ik.simulate(ik.Scene(BALL, contacts=[FLOOR]), Q, V)
    assert caught[0].filename == __file__ and motion.t[-1] == 1.0


def test_a_quaternion_in_the_order_of_others_is_doubted():
    given = [0, 0, 1, 1, 0, 0, 0]
    with pytest.warns(SetupWarning, match="order x, y, z, w half a turn about x"):
        q = BALL.configuration(root_joint=given)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        impact = ik.solve(ik.Scene(BALL, contacts=[FLOOR]), np.array(given), V)
    assert np.array_equal(q, given) and any("half a turn" in doubt for doubt in impact.doubts)
    assert not any("turn" in d for d in ik.solve(ik.Scene(BALL, contacts=[FLOOR]), Q, V).doubts)
