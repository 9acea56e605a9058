"""One thing of a scene varied: a scene with other entries, a solve with other numbers."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError

from ..robots import random_state

PANDA = ik.Robot.from_example("panda")
BLOW = ik.AppliedImpulse("panda_hand", linear=[0, 0, 1], at=[0.1, 0, 0], name="blow")
KICK = ik.JointImpulse("panda_joint2", 0.5, name="kick")
LOCAL = ik.AppliedImpulse("panda_link4", angular=[0, 1, 0], axes="local")
LOCK, STOP = ik.JointLock("panda_joint4"), ik.JointStop("panda_joint1", lower=-9.0, upper=-5.0)
SCENES = {
    "crba": ik.Scene(PANDA, [KICK, BLOW]),
    "aba": ik.Scene(ik.Robot.from_urdf(ik.models.chain_urdf(40)), [
        ik.AppliedImpulse("link_40", linear=[0, 1, 0], name="blow"),
        ik.JointImpulse("joint_3", 0.2, name="kick"),
    ]),
    "rows": ik.Scene(PANDA, [KICK, LOCAL, BLOW], [LOCK]),
    "contacts": ik.Scene(PANDA, [BLOW, KICK], contacts=[STOP]),
}  # fmt: skip


@pytest.mark.parametrize("case", SCENES)
def test_other_numbers_are_those_of_another_scene(case):
    scene = SCENES[case]
    q, v = random_state(scene.robot, 3)
    given = {"blow": [0.3, -2.0, 0.7, 0.1, 0.2, -0.3], "kick": [-0.8]}
    impulses = {i.name: i.with_values(given[i.name]) for i in scene.impulses if i.name in given}
    other = scene.replace(impulses=[impulses.get(i.name, i) for i in scene.impulses])
    known, before = ik.solve(other, q, v), ik.solve(scene, q, v)
    impact = ik.solve(scene, q, v, impulses=given)
    np.testing.assert_allclose(impact.dv, known.dv, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(impact.generalized_impulse, known.generalized_impulse, atol=1e-12)
    assert impact.scene.impulses == tuple(other.impulses) and impact.is_valid()
    assert ik.check(impact).agrees
    batch = ik.solve_batch(scene, q[None], v[None], impulses=given)
    np.testing.assert_allclose(batch.v_after[0], impact.v_after, atol=1e-10)
    # The scene is as it was.
    assert np.array_equal(ik.solve(scene, q, v).dv, before.dv)


def test_one_impulse_needs_no_name_and_a_force_no_couple():
    scene = ik.Scene(PANDA, [BLOW])
    q, v = random_state(PANDA, 4)
    twice = ik.solve(scene, q, v, impulses=[0, 0, 2])
    np.testing.assert_allclose(twice.dv, 2.0 * ik.solve(scene, q, v).dv, rtol=1e-12)
    assert np.array_equal(ik.solve(ik.Scene(PANDA, [KICK]), q, v, impulses=0.5).dv,
                          ik.solve(ik.Scene(PANDA, [KICK]), q, v).dv)  # fmt: skip


def test_a_scene_is_replaced_in_part():
    scene = ik.Scene(PANDA, [KICK], gravity=[0, 0, -1])
    assert scene.with_impulse(BLOW, LOCAL).impulses == (KICK, BLOW, LOCAL)
    law = ik.Law(restitution="poisson")
    other = scene.replace(law=law, contacts=[STOP])
    assert (other.law, other.contacts, other.gravity) == (law, (STOP,), (0.0, 0.0, -1.0))
    with pytest.raises(InputError, match='2 entries have the name "kick"'):
        scene.with_impulse(KICK)
