"""A result shown in one line, or in a notebook, begins with what was asked for."""

import json

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.compliance import GearPeak, Hertz

ARM = ik.Robot.from_example("panda")
BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
SCENE = ik.Scene(BALL, contacts=[ik.Contact("ball", at=[0, 0, -0.1], name="floor")], gap_bound=1)

DROP = BALL.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])


@pytest.fixture(scope="module")
def impact():
    return ik.solve(SCENE, BALL.neutral(), BALL.velocity(root_joint=[0, 0, -2, 0, 0, 0]))


def test_lines_begin_with_the_answer(impact):
    v = ARM.velocity(panda_joint1=1.0)
    hit = ik.transient_contact(ARM, ARM.configuration(panda_joint4=-1.5), v, body="chest")
    assert repr(hit).startswith(
        "TransientContact(within_limits=True, force=127.966, force_limit=280"
    )
    history = ik.force_history(impact, Hertz(E=1e7, nu=0.5, radius=0.1))
    assert repr(history).startswith(
        f"ForceHistory(contact='floor', peak_force={history.peak_force:.6g}"
    )
    assert "share=0.75" in repr(GearPeak("elbow", jump=1.0, torque=60.0, limit=80.0))
    blow = ik.solve(
        ik.Scene(ARM, [ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])]), ARM.neutral(), v
    )
    load = blow.joint_loads["panda_joint2"]
    assert repr(load).startswith(f"JointLoad('panda_joint2', axial={load.axial:.6g}, shear=")
    assert "e-1" not in repr(load), "rounding is shown as 0"


def test_notebooks_show_them(impact):
    for thing, words in (
        (impact.uniqueness, "uniqueness of v⁺: proven"),
        (impact.residuals, "momentum"),
        (ik.touching(SCENE, impact.q), "1 of 1 contacts touch"),
        (ik.Simulation(SCENE, DROP, impact.v_before), "t = 0 s"),
        (SCENE.contacts["floor"], "Contact"),
        (ik.AppliedImpulse("ball", linear=[0, 0, 1]), "AppliedImpulse"),
        (ik.force_history(impact, Hertz(E=1e7, nu=0.5, radius=0.1)), "peak force"),
        (GearPeak("elbow", jump=1.0, torque=60.0), "elbow"),
        (ik.transient_contact(ARM, ARM.neutral(), ARM.velocity(panda_joint1=1.0)), "the limits"),
    ):
        assert words in thing._repr_html_(), type(thing).__name__


def test_a_motion_is_plain_data_and_a_batch_a_table(impact):
    motion = ik.simulate(SCENE, DROP, BALL.velocity(), duration=0.6, samples=4)
    found = json.loads(json.dumps(motion.to_dict(), allow_nan=False))
    assert found["t"] == motion.t.tolist() and found["v"] == motion.v.tolist()
    assert [hit["time"] for hit in found["impacts"]] == [time for time, _ in motion.impacts]
    assert found["impacts"][0]["contacts"] == ["floor"] and found["rests"][0]["end"] is None
    pytest.importorskip("xarray")
    outputs = ("v_after", "contact_impulses", "gaps", "energy_change")
    batch = ik.solve_batch(SCENE, impact.q, np.tile(impact.v_before, (3, 1)), outputs=outputs)
    table = batch.to_xarray()
    assert table.v_after.sel(speed="root_joint[2]").shape == (3,)
    up = table.contact_impulses.sel(contact="floor", axis="z").values
    np.testing.assert_array_equal(up, batch.contact_impulses[:, 0, 2])
