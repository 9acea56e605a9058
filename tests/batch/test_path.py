"""Slip along the path in batches: as ``solve`` follows it, and as Routh's construction ends."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.laws.status import Status
from tests.batch.compare import random_states, worst_difference
from tests.truths.planar import planar_impulses

pytest.importorskip("numba")

LAWS = [ik.Law(restitution, "path") for restitution in ("newton", "poisson", "stronge")]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.restitution)


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


@pytest.fixture(scope="module")
def rod():
    return ik.Robot.from_urdf("models/rod.urdf", root="planar")


def held_against_solve(scene, q, v, bar=1e-12, share=0.01):
    """The batch, whose rows kernels solved, all as ``solve`` does."""
    worst, batch = worst_difference(scene, q, v)
    assert worst < bar
    return batch


@pytest.mark.slow
@every_law
def test_coefficients_of_every_row(solo, law):
    rng = np.random.default_rng(1)
    q, v = random_states(solo, 60, seed=1)
    e, mu = rng.uniform(0, 1, 60), rng.choice([0.0, 1e-160, 0.2, 3.0], 60)
    e[:10] = 1e-160
    foot = ik.Contact("FR_FOOT")
    batch = ik.solve_batch(
        ik.Scene(solo, contacts=[foot], law=law), q, v, restitution=e[:, None], friction=mu[:, None]
    )
    for i in range(60):
        own = dataclasses.replace(foot, restitution=e[i], friction=mu[i])
        impact = ik.solve(ik.Scene(solo, contacts=[own], law=law), q[i], v[i])
        size = np.abs(v[i]).max() + np.abs(impact.dv).max()
        assert np.abs(batch.v_after[i] - impact.v_after).max() < 1e-12 * size
        assert batch.status[i] == impact.status


def refused_where_solve_refuses(scene, q, v):
    """The batch, all as ``solve`` does; and how many rows both refuse."""
    batch = ik.solve_batch(scene, q, v)
    refused = 0
    for i in range(len(q)):
        try:
            impact = ik.solve(scene, q[i], v[i])
        except ik.errors.InputError:
            refused += 1
            assert batch.status[i] == Status.REFUSED
            assert np.isnan(batch.v_after[i]).all()
            continue
        assert batch.status[i] == impact.status
        size = np.abs(v[i]).max() + np.abs(impact.dv).max()
        assert np.abs(batch.v_after[i] - impact.v_after).max() < 1e-12 * size
    return batch, refused


@pytest.mark.slow
@pytest.mark.parametrize("restitution", ["newton", "poisson"])
@pytest.mark.parametrize("feet", [("FR_FOOT",), ("FR_FOOT", "HL_FOOT", "FL_FOOT")])
@pytest.mark.parametrize("held", [False, True])
def test_what_strikes_or_holds_comes_first_without_friction_too(solo, restitution, feet, held):
    # Energy counts from then, and other feet are only kept from approaching.
    contacts = [ik.Contact(f, restitution=0.8) for f in feet]
    blow = [] if held else [ik.AppliedImpulse("base_link", [1.0, -2.0, 3.0])]
    anchor = [ik.PointAnchor("HR_FOOT")] if held else []
    law = ik.Law(restitution, slip="path")
    q, v = random_states(solo, 60, seed=4)
    worst, _batch = worst_difference(ik.Scene(solo, blow, anchor, contacts, law=law), q, v)
    assert worst < 1e-12


@every_law
def test_beside_locks_anchors_blows_and_a_stop(solo, law):
    scene = ik.Scene(
        solo,
        [ik.AppliedImpulse("base_link", [0.1, 0.2, -0.4])],
        constraints=[ik.JointLock("HL_KFE"), ik.PointAnchor("HR_FOOT", at=[0, 0, 0.01])],
        contacts=[
            ik.Contact("FR_FOOT", friction=0.5, restitution=0.6),
            ik.JointStop("FL_HFE", lower=-1.0, upper=0.5, restitution=0.5),
        ],
        law=law,
    )
    _batch, refused = refused_where_solve_refuses(scene, *random_states(solo, 100, seed=4))
    assert 0 < refused < 50


@every_law
def test_one_foot_acts_while_the_other_parts(solo, law):
    feet = [ik.Contact(f, friction=0.4, restitution=0.5) for f in ("FR_FOOT", "HL_FOOT")]
    scene = ik.Scene(solo, contacts=feet, law=law)
    _batch, refused = refused_where_solve_refuses(scene, *random_states(solo, 200, seed=5))
    assert 10 < refused < 190


@pytest.mark.slow
@every_law
@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_feet_one_after_the_other(solo, law, restitution):
    names = ("FR_FOOT", "HL_FOOT", "FL_FOOT")
    feet = [ik.Contact(f, friction=0.4 + 0.3 * i, restitution=restitution)
            for i, f in enumerate(names)]  # fmt: skip
    order = dataclasses.replace(law, order="sequential")
    held_against_solve(ik.Scene(solo, contacts=feet, law=order), *random_states(solo, 100, seed=7))


@every_law
def test_smooth_feet_are_the_same_under_both_slips(solo, law):
    feet = [ik.Contact(f, restitution=0.5) for f in ("FR_FOOT", "HL_FOOT", "FL_FOOT")]
    scene = ik.Scene(solo, contacts=feet, law=law)
    refused = refused_where_solve_refuses(scene, *random_states(solo, 60, seed=6))[1]
    assert (refused > 0) is (law.restitution == "stronge")


@every_law
def test_bodies_that_meet_each_other(law):
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    robot = ik.combine(arm=ik.Robot.from_example("panda"), box=box)
    contact = ik.Contact(
        "box/box", at=[0.02, 0, 0.1], normal=[0.1, 1, 0.2], against="arm/panda_hand",
        friction=0.4, restitution=0.5,
    )  # fmt: skip
    held_against_solve(ik.Scene(robot, contacts=[contact], law=law), *random_states(robot, 60))


@pytest.mark.slow
@every_law
@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("friction", [0.2, 2.0])
@pytest.mark.parametrize("held", [True, False])
def test_where_one_angle_is_all_that_moves(law, friction, restitution, held):
    """Where friction holds the slip of such a rod, it holds the rod."""
    name, frame = ("double_pendulum", "link_1") if held else ("door", "leaf")
    robot = ik.Robot.from_urdf(f"models/{name}.urdf")
    tip = ik.Contact(
        frame, at=[0.4, 0.1, -0.8], normal=[0.3, 0.5, 1], friction=friction,
        restitution=restitution,
    )  # fmt: skip
    locks = [ik.JointLock("joint_2")] if held else []
    scene = ik.Scene(robot, constraints=locks, contacts=[tip], law=law)
    held_against_solve(scene, *random_states(robot, 60))


def test_tangential_restitution_is_refused(solo):
    foot = ik.Contact("FR_FOOT", friction=0.5, tangential_restitution=0.5)
    with pytest.raises(ik.errors.InputError, match="tangential"):
        ik.Scene(solo, contacts=[foot], law=LAWS[0])


@pytest.mark.parametrize("friction", [0.1, 0.4, 1.0])
def test_rods_in_the_plane_end_where_routh_says(friction):
    """A rod of 1 kg and 1 m on its end, which lies at −c from the centre."""
    rod = ik.Robot.from_urdf("models/rod.urdf", root="planar")
    rng = np.random.default_rng(2)
    angle, e = rng.uniform(0.2, np.pi - 0.2, 200), 0.6
    cosine, sine = np.cos(angle), np.sin(angle)
    q, v = np.stack([0 * angle, 0 * angle, cosine, sine], axis=1), rng.normal(size=(200, 3))
    end = ik.Contact("rod", normal=[0, 1, 0], friction=friction, restitution=e)
    batch = ik.solve_batch(ik.Scene(rod, contacts=[end], law=LAWS[2]), q, v)
    turned = 0
    for i in range(200):
        turn = np.array([[cosine[i], -sine[i]], [sine[i], cosine[i]]])
        before, after = turn @ v[i, :2], turn @ batch.v_after[i, :2]
        x, y = -0.5 * cosine[i], -0.5 * sine[i]
        w = (1 + 12 * y * y, -12 * x * y, 1 + 12 * x * x)
        if before[1] >= 0.0:
            np.testing.assert_array_equal(after, before)
            continue
        ways = planar_impulses((*w, *before), e, friction, "stronge", "path")
        if not ways:
            assert batch.status[i] == Status.PAINLEVE_JAM
            continue
        p, n = map(float, ways[0])
        truth = before + np.array((w[0] * p + w[1] * n, w[1] * p + w[2] * n))
        np.testing.assert_allclose(after, truth, atol=1e-12 * np.abs(v[i]).max())
        turned += before[0] * after[0] < 0.0
    assert turned > 3 or friction > 0.5


@pytest.mark.slow
def test_newtons_law_may_gain_energy_where_slip_turns_about(solo):
    """Kane & Levinson 1985: the normal impulse of a slip that is reversed does too much work."""
    foot = ik.Contact("FR_FOOT", friction=0.5, restitution=1.0)
    q, v = random_states(solo, 300, seed=8)
    found = {
        law.restitution: held_against_solve(ik.Scene(solo, contacts=[foot], law=law), q, v)
        for law in LAWS
    }
    assert (found["newton"].status == Status.ENERGY_GAIN).any()
    assert not (found["stronge"].status == Status.ENERGY_GAIN).any()


@every_law
def test_feet_that_come_straight_down_or_graze(solo, law):
    """Slip starts from rest on the way, where friction cannot hold it; or nothing is struck."""
    foot = ik.Contact("FR_FOOT", friction=0.05, restitution=0.5)
    q, v = random_states(solo, 60, seed=9)
    frame = solo.model.getFrameId("FR_FOOT")
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    data = solo.model.createData()
    for i in range(60):
        # The base's own linear speeds, turned into the world, are those of all its points.
        jacobian = pin.computeFrameJacobian(solo.model, data, q[i], frame, axes)[:3]
        wanted = np.array([0.0, 0.0, -1.0]) if i % 2 else np.array([1.0, 0.0, -1e-13])
        v[i, :3] += np.linalg.solve(jacobian[:, :3], wanted - jacobian @ v[i])
    # What a grazing contact gives is itself no more than rounding; the velocities are not.
    _batch, refused = refused_where_solve_refuses(ik.Scene(solo, contacts=[foot], law=law), q, v)
    assert refused == 0
