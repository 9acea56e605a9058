"""What solve takes, refuses and keeps."""

from __future__ import annotations

import math
import pickle
import threading

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors
from tests.reference.models import joint, link, robot
from tests.robots import STRUCK, random_blow, random_state


@pytest.fixture(scope="module")
def talos() -> ik.Scene:
    robot = ik.Robot.from_example("talos", root="freeflyer")
    return ik.Scene(robot, [random_blow(STRUCK["talos"], 0)])


def test_the_answer_is_read_only_and_apart_from_what_was_given(talos):
    q, v = random_state(talos.robot, 0)
    impact = ik.solve(talos, q, v)
    before = impact.q.copy()
    q[:] = 0.0
    np.testing.assert_array_equal(impact.q, before)
    for array in (impact.q, impact.v_before, impact.dv, impact.v_after, impact.momentum_after):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_lists_and_whole_numbers_are_taken():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [random_blow("panda_hand", 0)])
    a = ik.solve(scene, [0] * 9, [1] * 9)
    b = ik.solve(scene, np.zeros(9), np.ones(9))
    np.testing.assert_array_equal(a.v_after, b.v_after)


@pytest.mark.parametrize(
    ("change_q", "change_v", "error", "words"),
    [
        (
            lambda q: q[:-1],
            lambda v: v,
            errors.ShapeError,
            r"q: expected shape \(39,\), got \(38,\)",
        ),
        (
            lambda q: q,
            lambda v: v[None],
            errors.ShapeError,
            r"v: expected shape \(38,\), got \(1, 38\)",
        ),
        (lambda q: _set(q, 10, math.nan), lambda v: v, errors.NotFiniteError, "leg_left_4_joint"),
        (lambda q: _set(q, 0, math.inf), lambda v: v, errors.NotFiniteError, "root_joint"),
        (lambda q: q, lambda v: _set(v, 6, math.nan), errors.NotFiniteError, "leg_left_1_joint"),
        (lambda q: _set(q, slice(3, 7), 0.0), lambda v: v, errors.StateError, "length 0"),
        (lambda q: _set(q, 6, q[6] + 1e-3), lambda v: v, errors.StateError, "quaternion"),
        (
            lambda q: "here",
            lambda v: v,
            errors.InputError,
            'q must be 39 numbers, got "here"',
        ),
        (lambda q: q, lambda v: None, errors.ImpulsekitError, "v"),
    ],
)
def test_a_wrong_state_is_one_clear_error(talos, change_q, change_v, error, words):
    q, v = random_state(talos.robot, 0)
    with pytest.raises(error, match=words):
        ik.solve(talos, change_q(q), change_v(v))


@pytest.mark.parametrize("entry", [0, 8])
def test_no_nan_slips_through_a_fixed_base(entry):
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [random_blow("panda_link1", 0)])
    for q, v in ((_set(np.zeros(9), entry, math.nan), np.zeros(9)),):
        with pytest.raises(errors.NotFiniteError, match="q"):
            ik.solve(scene, q, v)
        with pytest.raises(errors.NotFiniteError, match="v"):
            ik.solve(scene, v, q)


def test_huge_states_are_not_taken_for_infinite_ones():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [random_blow("panda_hand", 0)])
    v = np.full(9, 1e200)
    np.testing.assert_array_equal(ik.solve(scene, np.zeros(9), v).v_before, v)


@pytest.mark.parametrize("entry", [math.nan, math.inf, -math.inf, 1e200])
def test_states_of_many_numbers_are_checked_as_those_of_few(entry):
    chain = ik.Robot.from_urdf(ik.models.chain_urdf(60), root="planar")
    scene = ik.Scene(chain, [random_blow("link_60", 0)])
    q, v = random_state(chain, 0)
    v[5] = entry
    if entry == 1e200:
        assert ik.solve(scene, q, v).is_valid()
        return
    with pytest.raises(errors.NotFiniteError, match="velocity v: entry 5"):
        ik.solve(scene, q, v)


def test_without_an_impulse_nothing_changes():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    q, v = random_state(robot, 1)
    impact = ik.solve(ik.Scene(robot), q, v)
    assert not impact.dv.any()
    assert impact.is_valid()
    assert impact.energy.change == 0.0


def test_a_joint_that_moves_no_inertia_is_named():
    text = robot(
        '<link name="base"/>',
        link("arm"),
        '<link name="tip"/>',
        joint("shoulder", "base", "arm", "continuous"),
        joint("wrist", "arm", "tip", "continuous"),
    )
    bare = ik.Robot.from_urdf(text)
    scene = ik.Scene(bare, [ik.AppliedImpulse("arm", angular=[0, 0, 1])])
    with pytest.raises(
        errors.SingularMassError, match='joint "wrist" moves no mass: give link "tip"'
    ) as caught:
        ik.solve(scene, bare.neutral(), bare.velocity())
    assert caught.value.joints == ("wrist",)


def test_a_massless_gimbal_is_singular_only_where_its_axes_meet():
    """Three hinges with massless links between stand for a ball joint, but not everywhere."""
    model = pin.Model()
    joint = 0
    for name, kind in (("z", pin.JointModelRZ), ("y", pin.JointModelRY), ("x", pin.JointModelRX)):
        joint = model.addJoint(joint, kind(), pin.SE3.Identity(), name)
    model.appendBodyToJoint(joint, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    model.addFrame(pin.Frame("body", joint, 0, pin.SE3.Identity(), pin.FrameType.BODY))
    robot = ik.Robot.from_model(model)
    scene = ik.Scene(robot, [ik.AppliedImpulse("body", angular=[1, 2, 3])])
    away = ik.solve(scene, robot.configuration(y=0.3), robot.velocity())
    np.testing.assert_allclose(away.bodies["body"].domega, [1, 2, 3], rtol=1e-13)
    with pytest.raises(errors.SingularMassError):
        ik.solve(scene, robot.configuration(y=math.pi / 2), robot.velocity())


def test_threads_do_not_meet(talos):
    robot = talos.robot
    states = [random_state(robot, seed) for seed in range(8)]
    expected = [ik.solve(talos, *state).dv for state in states]
    wrong = []

    def work(i: int) -> None:
        for _ in range(50):
            impact = ik.solve(talos, *states[i])
            if not np.array_equal(impact.dv, expected[i]):
                wrong.append(i)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_an_impact_travels_by_pickle(talos):
    impact = ik.solve(talos, *random_state(talos.robot, 1))
    _ = impact.energy
    twin = pickle.loads(pickle.dumps(impact))
    np.testing.assert_array_equal(twin.dv, impact.dv)
    assert twin.energy.after == impact.energy.after


def test_a_scene_is_needed():
    with pytest.raises(errors.InputError, match="solve takes a Scene, not a"):
        ik.solve("scene", [0], [0])


def _set(array, index, value):
    array = array.copy()
    array[index] = value
    return array


@pytest.mark.parametrize("name", ik.models.example_names())
def test_a_blow_on_any_branch_of_any_robot_is_solved(name):
    """On a fixed base, with all other branches left out."""
    robot = ik.Robot.from_example(name)
    if robot.nv == 0:
        pytest.skip("nothing moves on a fixed base")
    moved = [link for link in robot.links if link.joint_id > 0 and link.mass > 0.0]
    scene = ik.Scene(robot, [random_blow(moved[-1].name, 1)])
    try:
        impact = ik.solve(scene, *random_state(robot, 1))
    except errors.SingularMassError as error:
        assert error.joints
        return
    assert impact.residuals.momentum < 1e-12
