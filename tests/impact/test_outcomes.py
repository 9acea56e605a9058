"""All outcomes of Routh's process: closed forms, an own integration, laws, and bad input."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit._core import find_outcomes
from impulsekit.impact.contact_law import ContactProblem, solve_contacts
from tests.laws.rows import solved_rows

PHONE = """<robot name="phone"><link name="phone"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="0.4166666666666667" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"""
FALL = 0.442945  # [m/s] after .01 m


def phone(friction=1.0, restitution=0.0, **more):
    robot = ik.Robot.from_urdf(PHONE, root="planar")
    feet = [
        ik.Contact("phone", at=[x, -1, 0], normal=[0, 1, 0], friction=friction, name=name,
                   restitution=restitution, **more)
        for x, name in ((-0.5, "left"), (0.5, "right"))
    ]  # fmt: skip
    return ik.Scene(robot, contacts=feet, gap_bound=9)


def _at_rest():
    """A scene in which nothing touches."""
    robot = phone().robot
    return ik.Scene(robot, [ik.AppliedImpulse("phone", linear=[1, 0, 0])]), robot.neutral(), [0] * 3


def dropped(scene=None, **more):
    scene = phone() if scene is None else scene
    return ik.outcomes(scene, scene.robot.neutral(), [0, -FALL, 0], **more)


def test_a_dropped_phone_has_the_published_extremes():
    """Halm & Posa 2019: v_y⁻ (±.21, −.105, ∓.21), and rest between them."""
    found = dropped()
    right, left = found.extreme([1, 0, 0]), found.extreme([-1, 0, 0])
    assert right == pytest.approx([0.093018, 0.046509, -0.093018], abs=1e-5)
    assert left == pytest.approx([-0.093018, 0.046509, 0.093018], abs=1e-5)
    assert right == pytest.approx(FALL * np.array([0.21, 0.105, -0.21]), abs=1e-9)
    assert found.distance(np.zeros(3)) < 1e-9
    assert np.abs(found.velocities_after).max(axis=1).min() < 1e-9
    assert (len(found), found.jammed, found.gained) == (4096, 0, 0)


def test_no_outcome_of_the_phone_lies_outside_the_true_set():
    """It sticks all the way, so that du_n = W' λ in a plane: two segments from rest."""
    v = dropped().velocities_after
    assert np.allclose(v[:, 0], -v[:, 2], atol=1e-9)
    assert np.allclose(v[:, 1], 0.5 * np.abs(v[:, 0]), atol=1e-9)
    assert v[:, 1].max() <= FALL * 0.105 + 1e-9


def test_more_than_sequences_of_whole_impacts_is_reached():
    v = dropped().velocities_after
    assert ((v[:, 1] > 0.01) & (v[:, 1] < 0.03)).any()


def test_three_balls_in_contact_have_one_inelastic_outcome():
    """Nothing but a common velocity keeps all from approaching."""
    J = np.zeros((6, 3))
    J[2], J[5] = [-1, 1, 0], [0, -1, 1]
    impact = solved_rows(J, [1.0, 0.0, 0.0])
    found = impact.outcomes(samples=256)
    assert found.velocities_after == pytest.approx(np.full((256, 3), 1 / 3), abs=1e-9)


def test_a_rocking_block_turns_on_as_housner_says():
    """Housner 1963: ω⁺/ω⁻ = 1 − 3/2 sin²α of a slender block on its other corner."""
    text = PHONE.replace("phone", "block")
    robot = ik.Robot.from_urdf(text, root="planar")
    feet = [
        ik.Contact("block", at=[x, -1, 0], normal=[0, 1, 0], friction=1, name=name)
        for x, name in ((-0.5, "left"), (0.5, "right"))
    ]
    # It turns about its left corner.
    v = [1.0, -0.5, -1.0]
    found = ik.outcomes(ik.Scene(robot, contacts=feet, gap_bound=9), robot.neutral(), v, samples=64)
    assert found.velocities_after[:, 2] == pytest.approx(np.full(64, -(1 - 1.5 * 0.2)), abs=1e-9)


def problem_of(rng, n, planar):
    """W, u, µ of contacts, J and M⁻¹."""
    nv = int(rng.integers(2 * n if planar else 3 * n, 4 * n))
    J = rng.normal(size=(3 * n, nv))
    if planar:
        J[1::3] = 0.0
    B = rng.normal(size=(nv, nv))
    inverse = B @ B.T / nv + 0.1 * np.eye(nv)
    return J, inverse, rng.normal(size=nv), rng.uniform(0, 2, n)


def cloud(J, inverse, v, mu, e=0.0, directions=None, samples=512, seed=0, threads=1):
    W, u = J @ inverse @ J.T, J @ v
    W = 0.5 * (W + W.T)
    given = np.zeros((0, len(u))) if directions is None else directions
    zero = np.zeros(len(mu))
    contacts = ContactProblem(W, u, u, zero + e, mu, zero).contacts()
    found = find_outcomes(W, u, contacts, samples, np.ascontiguousarray(given), 256, seed, threads)
    return W, u, found.impulses.reshape(-1, len(u)), found.works, found.states


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("contacts", [2, 3])
def test_every_outcome_parts_within_its_cones_and_loses_energy(contacts, planar):
    rng = np.random.default_rng(contacts)
    for e in (0.0, 0.5) * 3:
        given = problem_of(rng, contacts, planar)
        W, u, P, works, states = cloud(*given, e)
        P, works = P[states == 0], works[states == 0]
        after = u + P @ W
        size = np.abs(u).max()
        assert after[:, 2::3].min() > -1e-9 * size
        slip = np.hypot(P[:, 0::3], P[:, 1::3])
        assert (slip <= given[3] * P[:, 2::3] + 1e-9 * size).all()
        assert works.max() <= 1e-9 * (given[2] @ np.linalg.solve(given[1], given[2]))


def integrated(W, u, mu, rng, step):
    """A process of the inclusion in small steps: random shares, friction against the slip."""
    u = u.copy()
    shares = rng.dirichlet(np.full(len(mu), 0.5))
    for _ in range(200_000):
        active = u[2::3] < 0.0
        if not active.any():
            return u
        if rng.random() < 0.01:
            shares = rng.dirichlet(np.full(len(mu), 0.5))
        own = np.where(active, shares, 0.0)
        P = np.zeros(len(u))
        P[2::3] = step * own / own.sum() if own.sum() > 0.0 else step * active
        # As much friction as stops a contact's own slip, at most µ P_n.
        P[0::3] = np.clip(-u[0::3] / np.diag(W)[0::3], -mu * P[2::3], mu * P[2::3])
        u += W @ P
    raise AssertionError("no end")


def test_own_integrations_in_small_steps_stay_inside_the_bounds():
    rng = np.random.default_rng(3)
    for _ in range(6):
        given = problem_of(rng, 2, True)
        W, u, *_ = cloud(*given)
        rows = np.vstack([W[[0, 2, 3, 5]], -W[[0, 2, 3, 5]]])
        _, _, P, _, states = cloud(*given, directions=rows)
        found = (u + P[states == 0] @ W)[:, [0, 2, 3, 5]]
        size = np.abs(u).max()
        for _ in range(4):
            own = integrated(W, u, given[3], rng, 2e-4 * size / np.diag(W).max())[[0, 2, 3, 5]]
            assert (own >= found.min(axis=0) - 2e-3 * size).all()
            assert (own <= found.max(axis=0) + 2e-3 * size).all()


@pytest.mark.parametrize("planar", [True, False])
def test_sequences_along_the_path_are_outcomes(planar):
    rng = np.random.default_rng(11)
    law = ik.Law(slip="path", order="sequential")
    for _ in range(25):
        J, inverse, v, mu = problem_of(rng, 2, planar)
        W, u, P, _, states = cloud(J, inverse, v, mu)
        zero = np.zeros(2)
        own = solve_contacts(ContactProblem(W, u, u, zero, mu, zero), law)
        off = np.abs((P[states == 0] - own.impulse) @ W).max(axis=1)
        assert off.min() <= 1e-6 * np.abs(u).max()


def test_the_outcomes_depend_on_the_seed_and_not_on_threads():
    given = problem_of(np.random.default_rng(5), 3, False)
    rows = np.eye(9)
    one, two, other = (
        cloud(*given, directions=rows, samples=64, seed=s, threads=t)[2]
        for s, t in ((1, 1), (1, 3), (2, 3))
    )
    assert one.tobytes() == two.tobytes()
    assert one.tobytes() != other.tobytes()
    fewer = cloud(*given, samples=32, seed=1)[2]
    assert fewer.tobytes() == one[:32].tobytes()


def test_one_contact_has_the_outcome_of_poissons_law_along_the_path():
    J, inverse, v, mu = problem_of(np.random.default_rng(8), 1, False)
    J *= np.sign(-(J[2] @ v))
    W, u, P, _, _ = cloud(J, inverse, v, mu, e=0.6)
    law = ik.Law(restitution="poisson", slip="path")
    zero = np.zeros(1)
    own = solve_contacts(ContactProblem(W, u, u, zero + 0.6, mu, zero), law).impulse
    assert np.abs(P - own).max() < 1e-8


def test_expansions_that_gain_energy_are_left_out_and_counted():
    found = dropped(phone(restitution=1.0))
    assert found.gained > 0
    assert len(found) + found.gained + found.jammed == 4096
    assert found.energy.max() <= found.impact.energy.before * (1 + 1e-9)


def test_loads_and_impacts_of_single_outcomes():
    robot = ik.Robot.from_example("solo12", root="freeflyer")
    feet = ["FL_FOOT", "HR_FOOT"]
    scene = ik.Scene(
        robot, contacts=[ik.Contact(name, friction=0.7) for name in feet], gap_bound=9,
        constraints=[ik.JointLock("FL_HAA")],
    )  # fmt: skip
    fall = robot.velocity(root_joint=[0, 0, -1, 0, 0, 0])
    found = ik.outcomes(scene, robot.neutral(), fall, samples=64)
    for k in (0, 17):
        own = found.impact_with(found.impulses[k])
        assert own.residuals.momentum < 1e-12
        assert own.residuals.constraint < 1e-12
        assert own.v_after == pytest.approx(found.velocities_after[k], abs=1e-10)
        assert own.energy.after == pytest.approx(found.energy[k], rel=1e-9)
        assert own.energy.imbalance < 1e-9
        knee = own.joint_loads["HR_KFE"]
        assert found.loads["HR_KFE"][k] == pytest.approx([*knee.force, *knee.moment], abs=1e-9)
    low, high = found.joint_loads["HR_KFE"]
    assert (low < high).any()
    assert "HR_KFE" in ik.report(found)
    assert "inner bounds" in ik.report(found)


def test_hulls_and_plots():
    pytest.importorskip("matplotlib")
    found = dropped(samples=200)
    ring = found.hull([0, 1])
    assert ring.max(axis=0) == pytest.approx([0.21 * FALL, 0.105 * FALL])
    assert len(found.hull([0])) == 2
    assert len(found.hull([[1, 0, 1]])) == 1
    assert "sequence" in [
        text.get_text() for text in ik.plots.outcome_cloud(found, 0, 1).get_legend().get_texts()
    ]
    with pytest.raises(ik.errors.RangeError, match="entries of v, 0 to 2"):
        found.hull([3])
    with pytest.raises(ik.errors.ShapeError, match="weights"):
        found.extreme([1.0])


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: dropped(samples=0), "RangeError", "samples"),
        (lambda: dropped(samples=2.5), "RangeError", "samples"),
        (lambda: dropped(seed=-1), "RangeError", "seed"),
        (lambda: dropped(seed=2**64), "RangeError", "seed"),
        (lambda: dropped(phone(tangential_restitution=0.5)), "InputError", "tangential"),
        (lambda: dropped(phone(adhesion=0.5)), "InputError", '"left" has adhesion'),
        (lambda: dropped(phone(rolling=0.1)), "InputError", "rolling"),
        (lambda: dropped(phone(ik.StaticKinetic(0.5, 0.4))), "InputError", "a number"),
        (lambda: ik.outcomes(*_at_rest()), "InputError", "no contact"),
    ],
)
def test_bad_input_is_one_clear_error(call, error, words):
    with pytest.raises(getattr(ik.errors, error), match=words):
        call()
