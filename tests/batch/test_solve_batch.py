"""The same answers as ``solve``, one row at a time."""

import subprocess
import sys

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.batch.solve import solve_batch
from impulsekit.laws.status import Status
from tests.batch.compare import random_states, worst_difference

pytest.importorskip("numba")

FEET = ("FR_FOOT", "FL_FOOT", "HR_FOOT", "HL_FOOT")


def feet(*names, **coefficients):
    return [ik.Contact(name, at=[0, 0, -0.01], **coefficients) for name in names]


@pytest.fixture(scope="module")
def panda():
    return ik.Robot.from_example("panda")


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


def test_known_impulses_of_all_kinds(panda):
    scene = ik.Scene(
        panda,
        [
            ik.AppliedImpulse("panda_hand", [0.3, -0.2, 1], [0.1, 0.2, 0.3], at=[0.1, 0, 0.05]),
            ik.JointImpulse("panda_joint3", 0.4),
            ik.AppliedImpulse("panda_link4", [1, 2, 3], axes="local"),
        ],
    )
    q, v = random_states(panda, 53)
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


@pytest.mark.parametrize("friction", [0.0, 0.6])
@pytest.mark.parametrize("blow", [False, True])
def test_one_contact(solo, friction, blow):
    impulses = [ik.AppliedImpulse("base_link", [0.3, -0.2, -1])] if blow else []
    contacts = feet("FR_FOOT", friction=friction, restitution=0.3, normal=[0.1, 0.2, 1])
    q, v = random_states(solo, 101)
    worst, _batch = worst_difference(ik.Scene(solo, impulses, contacts=contacts), q, v)
    assert worst < 1e-12


def test_four_feet_without_friction(solo):
    q, v = random_states(solo, 60)
    scene = ik.Scene(solo, contacts=feet(*FEET, restitution=0.3))
    assert worst_difference(scene, q, v)[0] < 1e-12


def test_four_feet_with_friction(solo):
    q, v = random_states(solo, 60)
    scene = ik.Scene(solo, contacts=feet(*FEET, restitution=0.3, friction=0.6))
    assert worst_difference(scene, q, v)[0] < 1e-12


def test_constraints_with_and_without_contacts(solo):
    constraints = [
        ik.PointAnchor("FR_FOOT"),
        ik.JointLock("FL_KFE", velocity="kept"),
        ik.JointCoupling("HL_KFE", "HR_KFE", -1.0),
        ik.FrameAnchor("HL_FOOT", directions=["x", "rz"], axes="local", velocity=[0.1, 0.2]),
    ]
    blows = [ik.AppliedImpulse("base_link", [0.3, -0.2, -1])]
    q, v = random_states(solo, 40)
    assert worst_difference(ik.Scene(solo, blows, constraints), q, v)[0] < 1e-12
    contacts = feet("HR_FOOT", restitution=0.3, friction=0.6)
    assert worst_difference(ik.Scene(solo, blows, constraints, contacts), q, v)[0] < 1e-12


def test_joint_stops(panda):
    stops = [
        ik.JointStop("panda_joint1", lower=-0.2, upper=0.2, restitution=0.5),
        ik.JointStop("panda_joint2", lower=-0.2, upper=0.2, restitution=0.5),
    ]
    q, v = random_states(panda, 80, spread=0.4)
    worst, _batch = worst_difference(ik.Scene(panda, contacts=stops), q, v)
    assert worst < 1e-12


def own_law(speed):
    return 0.8 / (1.0 + speed)


def test_a_function_of_ones_own(solo):
    scene = ik.Scene(solo, contacts=feet("FR_FOOT", friction=0.6, restitution=own_law))
    q, v = random_states(solo, 5)
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


def test_redundant_contacts_without_friction_stay_in_the_kernels():
    """Four corners of a sole, of which three would do: one velocity, many splits."""
    talos = ik.Robot.from_example("talos", root="freeflyer")
    corners = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]
    scene = ik.Scene(talos, contacts=[ik.Contact("left_sole_link", at=at) for at in corners])
    q, v = random_states(talos, 20)
    v[:, 2] -= 2.0
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


@pytest.mark.parametrize("root", ["planar", "freeflyer"])
def test_a_chain_on_a_root_that_moves(root):
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(links=6), root=root)
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_6", [0, 5, 0], at=[1, 0, 0])])
    q, v = random_states(robot, 17)
    assert worst_difference(scene, q, v)[0] < 1e-12


def test_angles_far_beyond_a_turn(panda):
    scene = ik.Scene(panda, [ik.AppliedImpulse("panda_hand", [0, 0, 1])])
    q, v = random_states(panda, 9)
    q[3, 2], q[4, 1], q[5, 0] = 1e7, -3e4, 6.3
    assert worst_difference(scene, q, v)[0] < 1e-12


def test_impulses_and_coefficients_that_vary(solo):
    scene = ik.Scene(
        solo,
        [ik.AppliedImpulse("base_link", name="kick"), ik.JointImpulse("FR_KFE", 0.1, name="motor")],
        contacts=feet(*FEET[:2]),
    )
    rng = np.random.default_rng(1)
    q, v = random_states(solo, 24)
    kick, motor = rng.normal(size=(24, 3)), rng.normal(size=(24, 1))
    e, mu = rng.uniform(size=(24, 2)), rng.uniform(size=24)
    batch = solve_batch(
        scene,
        q,
        v,
        impulses={"kick": kick, "motor": motor},
        restitution=e,
        friction={"contacts[0]": mu},
    )
    for i in range(24):
        contacts = [
            *feet(FEET[0], restitution=e[i, 0], friction=mu[i]),
            *feet(FEET[1], restitution=e[i, 1]),
        ]
        blows = [ik.AppliedImpulse("base_link", kick[i]), ik.JointImpulse("FR_KFE", motor[i])]
        impact = ik.solve(ik.Scene(solo, blows, contacts=contacts), q[i], v[i])
        difference = np.abs(batch.v_after[i] - impact.v_after).max()
        assert difference < 1e-11 * np.abs(impact.dv).max()


def test_a_bad_row_is_marked_and_stops_nothing(solo):
    scene = ik.Scene(solo, contacts=feet("FR_FOOT", friction=0.5))
    q, v = random_states(solo, 40)
    whole = solve_batch(scene, q, v).v_after
    q[3, 9], v[11, 0], q[20, 3:7] = np.nan, np.inf, q[20, 3:7] * 1.01
    mu = np.full((40, 1), 0.5)
    mu[30] = -1.0
    batch = solve_batch(scene, q, v, friction=mu)
    assert batch.status[3] == batch.status[11] == Status.NOT_FINITE
    assert batch.status[20] == Status.OFF_MANIFOLD
    assert batch.status[30] == Status.OUT_OF_RANGE
    bad = [3, 11, 20, 30]
    assert np.isnan(batch.v_after[bad]).all()
    good = np.setdiff1d(np.arange(40), bad)
    assert np.array_equal(batch.v_after[good], whole[good])
    assert not batch.valid[bad].any()
    assert batch.valid[good].all()


def test_few_rows_are_as_good_as_many(solo):
    scene = ik.Scene(solo, contacts=feet("FR_FOOT", friction=0.5))
    q, v = random_states(solo, 37)
    many = solve_batch(scene, q, v, threads=2).v_after
    for size in (1, 5, 8, 9, 36):
        few = solve_batch(scene, q[:size], v[:size], threads=1).v_after
        assert np.array_equal(few, many[:size])


def test_branches_that_nothing_reaches_keep_their_speeds():
    robot = ik.Robot.from_example("allegro_right_hand")
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_3.0_tip", [0, 0.1, 0])])
    q, v = random_states(robot, 11, spread=0.5)
    assert worst_difference(scene, q, v)[0] < 1e-12


def test_what_all_rows_share_is_refused_at_once(panda):
    scene = ik.Scene(panda, [ik.AppliedImpulse("panda_hand", [0, 0, 1], name="blow")])
    q, v = random_states(panda, 4)
    with pytest.raises(ik.errors.ShapeError, match="q: expected shape"):
        solve_batch(scene, q[:, :5], v)
    with pytest.raises(ik.errors.ShapeError, match="leading axes"):
        solve_batch(scene, q, v[:3])
    with pytest.raises(ik.errors.ShapeError, match="empty"):
        solve_batch(scene, q[:0], v[:0])
    with pytest.raises(ik.errors.NotFiniteError):
        solve_batch(scene, q[0] * np.nan, v)
    with pytest.raises(ik.errors.UnknownNameError, match="blow"):
        solve_batch(scene, q, v, impulses={"blwo": [0, 0, 1]})
    with pytest.raises(ik.errors.UnknownNameError, match="v_after"):
        solve_batch(scene, q, v, outputs=["v_aftr"])
    with pytest.raises(ik.errors.InputError, match="no contacts"):
        solve_batch(scene, q, v, friction=0.3)
    with pytest.raises(ik.errors.InputError, match="not requested"):
        _ = solve_batch(scene, q, v).dv


def test_progress_counts_all_rows(panda):
    scene = ik.Scene(panda, [ik.AppliedImpulse("panda_hand", [0, 0, 1])])
    told = []
    solve_batch(scene, np.zeros((10_000, 9)), progress=lambda done, total: told.append(done))
    assert told[-1] == 10_000


def test_friction_of_some_contacts_beside_one_by_direction():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    contacts = [
        ik.Contact("ball", friction=ik.EllipticFriction(0.8, 0.2), name="a"),
        ik.Contact("ball", friction=0.3, name="b"),
    ]
    scene = ik.Scene(ball, contacts=contacts)
    with pytest.raises(ik.errors.InputError, match="more than a number"):
        ik.solve_batch(scene, ball.neutral(), friction={"b": [0.1, 0.2]})


@pytest.mark.slow
def test_motions_can_be_loaded_after_numba():
    """Functions called by their address are made as soon as numba is there."""
    code = (
        "import numba, impulsekit.laws.compiled as c; c.use_numba(); import impulsekit.motion.warm"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
