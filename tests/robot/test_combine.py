"""Several robots in one world."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik


@pytest.fixture(scope="module")
def panda() -> ik.Robot:
    return ik.Robot.from_example("panda")


def test_names_get_their_robots_name_and_states_are_stacked(panda):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    both = ik.combine(arm=panda, ball=ball)
    assert (both.nq, both.nv) == (9 + 7, 9 + 6)
    assert both.joint_names == (*(f"arm/{n}" for n in panda.joint_names), "ball/root_joint")
    assert {"arm/panda_hand", "ball/ball"} <= set(both.frame_names)
    assert both.mass == pytest.approx(panda.mass + ball.mass)


def test_a_placement_puts_the_root_there(panda):
    turn = pin.SE3(pin.utils.rotate("z", 0.5), np.array([1.0, 2.0, 3.0]))
    both = ik.combine(a=panda, b=panda, placements={"b": turn.homogeneous})
    data = both.model.createData()
    pin.framesForwardKinematics(both.model, data, both.neutral())
    a, b = (data.oMf[both.frame_id(f"{name}/panda_hand")] for name in "ab")
    np.testing.assert_allclose(b.homogeneous, (turn * a).homogeneous, atol=1e-15)


def test_worlds_nest(panda):
    pair = ik.combine(a=panda, b=panda, placements={"b": [0, 1, 0]})
    four = ik.combine(near=pair, far=pair, placements={"far": [5, 0, 0]})
    assert four.nv == 36
    assert "far/b/panda_hand" in four.frame_names
    np.testing.assert_allclose(np.array(four.parts[3].placement)[:3, 3], [5, 1, 0])
    assert four.joint_names[9] == "near/b/panda_joint1"


@pytest.mark.parametrize("name", ["so100", "z1", "b1_z1", "anymal_c"])
def test_a_link_and_a_joint_may_be_called_alike(name):
    alone = ik.Robot.from_example(name, root="freeflyer")
    both = ik.combine(a=alone, b=alone)
    for prefix in ("a/", "b/"):
        for frame in alone.model.frames.tolist()[1:]:
            frame_id = both.model.getFrameId(prefix + frame.name, frame.type)
            parent = both.model.frames[both.model.frames[frame_id].parentFrame].name
            above = alone.model.frames[frame.parentFrame].name
            assert parent == (prefix + above if frame.parentFrame else "universe")


def test_mass_matrices_stand_side_by_side_with_their_armature():
    model = pin.Model(ik.Robot.from_example("z1", root="freeflyer").model)
    rng = np.random.default_rng(0)
    model.armature[:] = rng.uniform(0.1, 2.0, model.nv)
    given = ik.Robot.from_model(model)
    pair = ik.combine(near=ik.combine(a=given, b=given), far=given)
    q = [pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv)) for _ in range(3)]
    whole = pin.crba(pair.model, pair.model.createData(), np.concatenate(q))
    for i in range(3):
        rows = slice(i * model.nv, (i + 1) * model.nv)
        alone = pin.crba(model, model.createData(), q[i])
        # pin.crba fills the upper triangle.
        np.testing.assert_allclose(np.triu(whole[rows, rows]), np.triu(alone), atol=1e-14)
        np.testing.assert_allclose(whole[rows, rows.stop :], 0.0, atol=1e-14)
