"""Derivatives of impacts whose slip is followed along the path."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit._core import follow_path
from impulsekit.impact.derivatives import DerivativeStatus
from impulsekit.impact.derivatives.path_law import path_derivative
from impulsekit.scene.law import RESTITUTIONS

from .test_derivatives import _differences, arm, ball, blow, contacts, falling

LAWS = ("newton", "poisson", "stronge")


def impulse_of(x, law):
    """P of W, the velocity at the start, u_n⁻, e and µ in one vector (12,)."""
    t11, t12, t22, n1, n2, nn = x[:6]
    W = np.array([t11, t12, n1, t12, t22, n2, n1, n2, nn])
    code = RESTITUTIONS.index(law)
    return np.array(follow_path(W, x[9], x[6:9].copy(), x[10], x[11], code)[:3])


def random_hit(seed):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(3, 5))
    W = half @ half.T / 3
    block = [W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2]]
    un = -rng.uniform(0.5, 3)
    slip = rng.normal(size=2) * rng.choice([0.2, 1, 3])
    return np.array([*block, *slip, un, un, rng.uniform(0.1, 0.9), rng.choice([0.1, 0.4, 1.0])])


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(8))
def test_the_law_alone_against_differences(seed, law):
    x = random_hit(seed)
    found = path_derivative(tuple(x[:6]), x[6:9].tolist(), x[9], x[10], x[11], law)
    assert found.impulse == pytest.approx(impulse_of(x, law), rel=1e-10)
    assert found.edges == ()
    for k in range(12):
        h = 5e-5 * max(abs(x[k]), 0.3) * np.eye(12)[k]
        coarse, fine = (
            (impulse_of(x + s * h, law) - impulse_of(x - s * h, law)) / (2 * s * h[k])
            for s in (2, 1)
        )
        truth = (4 * fine - coarse) / 3
        scale = max(1.0, np.abs(found.table).max())
        assert np.abs(found.table[:, k] - truth).max() < 1e-8 * scale


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("across", [0.1, 0.3, 1.0, 3.0])
def test_what_slips_across_comes_to_rest_with_the_slip(across, law):
    """In a plane slip r ends at p = r₀/(µ W₁₁); across it u₂ ~ r^(W₂₂/W₁₁) ends by −u₂/W₂₂."""
    block = 1.0, 0.0, across, 0.0, 0.0, 1.0
    found = path_derivative(block, [0.2, 0.0, -1.0], -1.0, 0.5, 0.5, law)
    assert found.impulse == pytest.approx([-0.2, 0.0, 1.5], rel=1e-13)
    assert found.table[1, 7] == pytest.approx(-1.0 / across, rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("mu", [0.0, 0.05, 0.3, 3.0])
def test_one_contact_of_an_arm(law, mu):
    hold = [ik.FrameAnchor("upper", "fore", directions=("x",), axes="local")]
    order = ik.Law(restitution=law, slip="path")
    scene = ik.Scene(arm(), [blow("fore", 7)], hold, contacts(1, mu, 0.6), law=order)
    assert_true(scene, *falling())


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("mu", [0.05, 3.0])
def test_contacts_one_after_the_other_along_their_paths(law, mu):
    order = ik.Law(restitution=law, slip="path", order="sequential")
    scene = ik.Scene(arm(), [blow("fore", 7)], contacts=contacts(3, mu, 0.6), law=order)
    q, v = falling(9)
    assert ik.solve(scene, q, v).outcome.contacts.iterations > 1
    assert_true(scene, q, v)


def assert_true(scene, q, v):
    """All derivatives of v⁺ against differences of solves; those of P close the books."""
    impact = ik.solve(scene, q, v)
    found = ik.derivatives(impact)
    assert found.status is DerivativeStatus.EXISTS
    for ours, theirs in zip(
        (found.dv_after_dq, found.dv_after_dv), _differences(scene, q, v), strict=True
    ):
        assert np.abs(ours - theirs).max() < 1e-8 * max(1.0, np.abs(theirs).max())
    own = scene.contacts[0]
    for table, what in (
        (found.dv_after_drestitution, "restitution"),
        (found.dv_after_dfriction, "friction"),
    ):
        if getattr(own, what) > 0.0:
            truth = by_coefficient(scene, q, v, what)
            ours = table["contacts[0]"]
            assert np.abs(ours - truth).max() < 1e-8 * max(1.0, np.abs(truth).max())
    # M dv = dI + Aᵀ dλ + Jᵀ dP by v⁻, where M, A and J stand still.
    M = impact.mechanics.mass_matrix
    left = M @ (found.dv_after_dv - np.eye(len(v)))
    for parts in found.contacts.values():
        assert parts.dv.shape == (3, len(v))
    jacobians = {}
    for touch in impact.outcome.touches:
        name = scene.entry_names("contacts")[touch.entry]
        jacobians[name] = touch.axes @ touch.jacobian
    for name, parts in found.contacts.items():
        left = left - jacobians[name].T @ parts.dv
    for name, parts in found.constraints.items():
        index = scene.entry_names("constraints").index(name)
        where = impact.mechanics.constraint_rows.slices[index]
        left = left - impact.mechanics.constraint_matrix[where].T @ parts.dv
    assert np.abs(left).max() < 1e-9 * np.abs(M).max()


def by_coefficient(scene, q, v, what):
    from dataclasses import replace

    def after(change):
        first, *rest = scene.contacts
        value = getattr(first, what) + change
        changed = replace(scene, contacts=[replace(first, **{what: value}), *rest])
        return ik.solve(changed, q, v).v_after

    h = 1e-3 * max(getattr(scene.contacts[0], what), 0.1)
    coarse, fine = ((after(s) - after(-s)) / (2 * s) for s in (2 * h, h))
    return (4 * fine - coarse) / 3


def test_a_ball_struck_at_its_centre_is_known_by_hand():
    # W is 1/m: slip ends after u_t/µ of the normal way, or not at all.
    for speed, by_friction, by_speed in ((0.1, 0.0, 0.0), (3.0, -1.6, 1.0)):
        order = ik.Law(restitution="stronge", slip="path")
        touch = ik.Contact("ball", friction=0.5, restitution=0.6)
        scene = ik.Scene(ball(), contacts=[touch], law=order)
        impact = ik.solve(scene, ball().neutral(), [speed, 0, -1.0, 0, 0, 0])
        found = ik.derivatives(impact)
        assert found.status.exists
        # v_x⁺ = v_x − µ (1 + e) |v_z| while it slips.
        assert found.dv_after_dfriction["contacts[0]"][0] == pytest.approx(by_friction, abs=1e-9)
        assert found.dv_after_dv[0, 0] == pytest.approx(by_speed, abs=1e-9)
        assert found.dv_after_drestitution["contacts[0]"][2] == pytest.approx(1.0, abs=1e-9)


def test_without_restitution_a_little_brings_a_little():
    for law in LAWS:
        order = ik.Law(restitution=law, slip="path")
        touch = [ik.Contact("ball", friction=0.1)]
        scene = ik.Scene(ball(), contacts=touch, law=order)
        impact = ik.solve(scene, ball().neutral(), [1.0, 0, -1.0, 0, 0, 0])
        found = ik.derivatives(impact).dv_after_drestitution["contacts[0]"]
        assert found[[0, 2]] == pytest.approx([-0.1, 1.0], abs=1e-9)


def test_slip_that_ends_with_the_impact_is_an_edge():
    # v_x = µ (1 + e) |v_z|: it comes to a stop in the last moment.
    order = ik.Law(restitution="poisson", slip="path")
    touch = ik.Contact("ball", friction=0.5, restitution=0.5)
    scene = ik.Scene(ball(), contacts=[touch], law=order)
    impact = ik.solve(scene, ball().neutral(), [0.75 + 1e-9, 0, -1.0, 0, 0, 0])
    found = ik.derivatives(impact)
    assert found.status is DerivativeStatus.MODE_EDGE
    assert "slip ends just as" in found.edges[0]


def test_by_inertia_along_the_path():
    source = arm()
    order = ik.Law(restitution="stronge", slip="path")
    own = contacts(1, 0.1, 0.6)
    q, v = falling()
    scene = ik.Scene(source, [blow("fore", 7)], contacts=own, law=order)
    found = ik.derivatives(ik.solve(scene, q, v)).dv_after_dinertia("shoulder")
    joint_id = source.joint_id("shoulder")

    def after(change):
        model = pin.Model(source.model)
        values = model.inertias[joint_id].toDynamicParameters() + change
        model.inertias[joint_id] = pin.Inertia.FromDynamicParameters(values)
        robot = ik.Robot.from_model(model)
        changed = ik.Scene(robot, [blow("fore", 7)], contacts=own, law=order)
        return ik.solve(changed, q, v).v_after

    for k, direction in enumerate(np.eye(10)):
        coarse, fine = (
            (after(h * direction) - after(-h * direction)) / (2 * h) for h in (2e-4, 1e-4)
        )
        truth = (4 * fine - coarse) / 3
        assert np.abs(found[:, k] - truth).max() < 1e-7 * max(1.0, np.abs(truth).max())


@pytest.mark.parametrize("order", ["sequential", "simultaneous"])
@pytest.mark.parametrize("restitution", ["poisson", "stronge"])
def test_a_contact_of_what_is_held_fast_has_an_end(restitution, order):
    """Rounding of its velocity, met by a mobility of rounding, was once followed for minutes."""
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    law = ik.Law(restitution, "path", order)
    for seed in (1, 2, 5):
        rng = np.random.default_rng(seed)
        normal = rng.normal(size=3)
        hold = ik.FrameAnchor("ball", at=rng.normal(size=3))
        floor = ik.Contact("ball", at=rng.normal(size=3), normal=normal / np.linalg.norm(normal),
                           restitution=0.3, friction=1.0)  # fmt: skip
        scene = ik.Scene(ball, [], [hold], [floor], law=law, gap_bound=9.0)
        found = ik.derivatives(ik.solve(scene, ball.neutral(), rng.normal(size=6)))
        assert np.abs(found.dv_after_dv).max() < 1e-11
        assert np.abs(found.dv_after_dq).max() < 1e-7


def two_robots(seed, law):
    """Two arms beside each other, a contact with friction on each, and the scene of each alone."""
    rng = np.random.default_rng(seed)
    robot = ik.combine(
        a=ik.Robot.from_example("panda"), b=ik.Robot.from_urdf("models/double_pendulum.urdf")
    )
    touching = [
        ik.Contact(
            link,
            at=rng.normal(size=3) * 0.1,
            normal=normal,
            friction=mu,
            restitution=e,
            name=link[0],
        )
        for link, normal, mu, e in (
            ("a/panda_hand", rng.normal(size=3), 0.3, 0.6),
            ("b/link_2", (0.3, 0.0, 1.0), 0.5, 0.4),
        )
    ]
    order = ik.Law(law, "path")
    scenes = [
        ik.Scene(robot, contacts=some, law=order, gap_bound=1e9)
        for some in (touching, touching[:1], touching[1:])
    ]
    q = pin.integrate(robot.model, robot.neutral(), rng.uniform(-0.5, 0.5, robot.nv))
    return scenes, q, rng.normal(size=robot.nv)


@pytest.mark.parametrize("law", LAWS)
def test_two_that_do_not_act_on_each_other(law):
    """Each along its own path at one instant: the changes are those of each alone."""
    compared = 0
    for seed in range(12):
        (both, *each), q, v = two_robots(seed, law)
        impact = ik.solve(both, q, v)
        if not impact.status.valid or not all(c.impulse.any() for c in impact.contacts):
            continue
        found = ik.derivatives(impact)
        if not found.status.exists:
            continue
        compared += 1
        for name in ("dv_after_dv", "dv_after_dq", "dv_after_dfriction", "dv_after_drestitution"):
            alone = [getattr(ik.derivatives(ik.solve(scene, q, v)), name) for scene in each]
            if isinstance(alone[0], np.ndarray):
                start = np.eye(len(v)) if name == "dv_after_dv" else 0.0
                expected = alone[0] + alone[1] - start
                np.testing.assert_allclose(getattr(found, name), expected, atol=1e-9)
            else:
                for one in alone:
                    for key, column in one.items():
                        np.testing.assert_allclose(getattr(found, name)[key], column, atol=1e-9)
        assert ik.check(impact).agrees
    assert compared >= 2


def test_smooth_ones_that_act_on_each_other_beside_a_rough_one_are_refused():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    robot = ik.combine(a=ball, b=ball)
    touching = [
        ik.Contact("a/ball", at=[x, 0, -0.1], normal=[x, 0, 1], restitution=0.5)
        for x in (-0.05, 0.05)
    ]
    touching.append(ik.Contact("b/ball", at=[0, 0, -0.1], friction=0.3))
    scene = ik.Scene(robot, contacts=touching, law=ik.Law("newton", "path"), gap_bound=1e9)
    v = robot.velocity()
    v[[2, 6, 8]] = -1.0, 0.3, -1.0
    impact = ik.solve(scene, robot.neutral(), v)
    assert impact.status.valid
    with pytest.raises(ik.errors.InputError, match="scenes of their own"):
        ik.derivatives(impact)
