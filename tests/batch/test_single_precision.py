"""float32 on request: digits fewer, verdicts the same."""

import numpy as np
import pytest

import impulsekit as ik
from tests.batch.compare import random_states

pytest.importorskip("numba")
# Kernels of their own have to be compiled for these.
pytestmark = pytest.mark.slow

CORNERS = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]


def scenes():
    panda = ik.Robot.from_example("panda")
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    talos = ik.Robot.from_example("talos", root="freeflyer")
    blow = ik.AppliedImpulse("base_link", [0.3, -0.2, -1])
    feet = [
        ik.Contact(name, restitution=0.3, friction=0.6)
        for name in ("FR_FOOT", "FL_FOOT", "HR_FOOT", "HL_FOOT")
    ]
    smooth = [ik.Contact(one.frame, restitution=1.0) for one in feet]
    held = [ik.PointAnchor("FR_FOOT"), ik.JointLock("FL_KFE", velocity="kept")]
    return {
        "a blow": ik.Scene(panda, [ik.AppliedImpulse("panda_hand", [0, 1, 2], at=[0, 0, 0.1])]),
        "a blow on 38": ik.Scene(talos, [ik.AppliedImpulse("gripper_left_base_link", [0, 1, 2])]),
        "one contact": ik.Scene(solo, [blow], contacts=feet[:1]),
        "four": ik.Scene(solo, contacts=feet),
        "four without friction or loss": ik.Scene(solo, contacts=smooth),
        "anchors": ik.Scene(solo, [blow], held),
        "a sole": ik.Scene(
            talos, contacts=[ik.Contact("left_sole_link", at=at, friction=0.5) for at in CORNERS]
        ),
    }


@pytest.mark.parametrize("name", scenes())
def test_few_digits_are_lost(name):
    scene = scenes()[name]
    q, v = random_states(scene.robot, 203)
    outputs = ("v_after", "energy_change")
    exact = ik.solve_batch(scene, q, v, outputs=outputs)
    rough = ik.solve_batch(scene, q, v, outputs=outputs, dtype=np.float32)
    assert rough.v_after.dtype == rough.energy_change.dtype == np.float32
    assert rough.plan.kernel
    assert np.array_equal(rough.status, exact.status)
    both = rough.valid & exact.valid
    speed = np.abs(v).max(axis=1) + np.abs(exact.v_after - v).max(axis=1)
    error = (np.abs(rough.v_after - exact.v_after).max(axis=1) / speed)[both]
    print(
        name,
        both.sum(),
        np.median(error),
        np.quantile(error, 0.99),
        error.max(),
        rough.count(),
        exact.count(),
    )
    assert np.median(error) < 1e-6
    assert error.max() < 1e-5


def test_angles_keep_their_digits_beyond_a_turn():
    panda = ik.Robot.from_example("panda")
    scene = ik.Scene(panda, [ik.AppliedImpulse("panda_hand", [0, 0, 1])])
    q, v = random_states(panda, 20)
    turned = q.copy()
    turned[:, :7] += 2 * np.pi * np.random.default_rng(0).integers(-1000, 1000, (20, 7))
    near = ik.solve_batch(scene, q, v, dtype=np.float32).v_after
    far = ik.solve_batch(scene, turned, v, dtype=np.float32).v_after
    assert np.abs(near - far).max() < 1e-5 * np.abs(near).max()


def test_bad_rows_and_few_rows():
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    scene = ik.Scene(solo, contacts=[ik.Contact("FR_FOOT", friction=0.5)])
    q, v = random_states(solo, 40)
    whole = ik.solve_batch(scene, q, v, dtype="float32").v_after
    q[3, 9], v[11, 0], q[20, 3:7] = np.nan, np.inf, q[20, 3:7] * 1.01
    v[21, 3] = 1e39
    batch = ik.solve_batch(scene, q, v, dtype="float32")
    names = [ik.Status(code).name for code in batch.status[[3, 11, 20, 21]]]
    assert names == ["NOT_FINITE", "NOT_FINITE", "OFF_MANIFOLD", "NOT_FINITE"]
    good = np.setdiff1d(np.arange(40), [3, 11, 20, 21])
    assert np.array_equal(batch.v_after[good], whole[good])
    for size in (1, 15, 16, 17):
        few = ik.solve_batch(scene, q[:3][:size], v[:3][:size], dtype="float32")
        assert np.array_equal(few.v_after, whole[:3][:size])
    with pytest.raises(ik.errors.InputError, match="float16"):
        ik.solve_batch(scene, q, v, dtype=np.float16)
