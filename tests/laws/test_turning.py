"""Rolling and torsional friction at impacts: closed forms, the statement, no change at zero."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.impact.contact_law import ContactProblem, Turning, solve_contacts

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
MASS, INERTIA = 0.5, 5e-4
R = 0.05


def bounced(v, law=None, **coefficients):
    floor = ik.Contact("ball", at=[0, 0, -R], **coefficients)
    scene = ik.Scene(BALL, contacts=[floor], law=law or ik.Law(), gap_bound=9)
    return ik.solve(scene, BALL.neutral(), BALL.velocity(root_joint=v))


@pytest.mark.parametrize("law", [ik.Law(), ik.Law("poisson")])
@pytest.mark.parametrize("rolling", [1e-4, 1e-3, 1.0])
def test_rolling_friction_at_one_bounce(law, rolling):
    """It rolls on with (I + m R²) ω⁺ = I ω + m R v − ρ P_n, or stops."""
    v, w, e, fall = 2.0, 15.0, 0.5, 1.5
    impact = bounced([v, 0, -fall, 0, w, 0], law, restitution=e, friction=5.0, rolling=rolling)
    normal = (1 + e) * MASS * fall
    after = (INERTIA * w + MASS * R * v - rolling * normal) / (INERTIA + MASS * R * R)
    after = max(after, 0.0)
    assert impact.is_valid() and ik.check(impact).agrees
    assert impact.v_after == pytest.approx([R * after, 0, e * fall, 0, after, 0], abs=1e-12)
    turning = impact.contacts[0].points[0].turning
    assert turning.rolling == ("rolling" if after else "sticking")
    assert turning.impulse[1] == pytest.approx(
        -min(rolling * normal, INERTIA * w + MASS * R * v), rel=1e-12
    )
    assert abs(impact.energy.imbalance) < 1e-13


@pytest.mark.parametrize(("torsion", "left"), [(2e-4, 12 - 2e-4 * 1.2 / INERTIA), (1.0, 0.0)])
def test_torsional_friction_at_one_bounce(torsion, left):
    impact = bounced([0, 0, -2.0, 0, 0, 12.0], restitution=0.2, torsion=torsion)
    assert impact.v_after == pytest.approx([0, 0, 0.4, 0, 0, left], abs=1e-12)
    turning = impact.contacts[0].points[0].turning
    assert turning.spin == ("spinning" if left else "sticking")
    assert turning.work == pytest.approx(0.5 * INERTIA * (left**2 - 12**2), rel=1e-12)
    assert impact.contacts[0].angular_impulse == pytest.approx(
        [0, 0, INERTIA * (left - 12)], rel=1e-12
    )


def test_all_six_rows_of_a_body_without_symmetry():
    """Against its statement, in the world's axes, on a box struck at a corner."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    floor = ik.Contact(
        "box", at=[0.1, -0.05, -0.03], restitution=0.4, friction=0.2, rolling=8e-3, torsion=5e-3
    )
    q = box.configuration(root_joint=[0, 0, 0.1, *(np.array([0.2, -0.3, 0.4, 0.8]) / 0.93**0.5)])
    v = box.velocity(root_joint=[0.3, -0.8, -2.0, 4.0, 3.0, -5.0])
    impact = ik.solve(ik.Scene(box, contacts=[floor], gap_bound=9), q, v)
    assert impact.is_valid() and ik.check(impact).agrees
    point = impact.contacts[0].points[0]
    normal, turning = point.impulse[2], point.turning
    assert point.velocity_after[2] == pytest.approx(-0.4 * point.velocity_before[2], rel=1e-12)
    for impulse, speed, limit in (
        (point.impulse[:2], point.velocity_after[:2], 0.2 * normal),
        (turning.impulse[:2], turning.velocity_after[:2], 8e-3 * normal),
        (turning.impulse[2:], turning.velocity_after[2:], 5e-3 * normal),
    ):
        size = np.linalg.norm(speed)
        if size > 1e-9:
            assert impulse == pytest.approx(-limit * speed / size, rel=1e-9)
        else:
            assert np.linalg.norm(impulse) <= limit * (1 + 1e-12)
    assert impact.energy.change < 0 and abs(impact.energy.imbalance) < 1e-13


@pytest.mark.parametrize("restitution", ["newton", "poisson"])
def test_without_coefficients_the_law_is_that_of_friction(restitution):
    """Rows of turning that resist nothing leave the answer of the other solver, to rounding."""
    rng = np.random.default_rng(7)
    for _ in range(30):
        n = int(rng.integers(1, 4))
        rows = rng.normal(size=(6 * n, 6 * n + 3))
        W, u = rows @ rows.T, rng.normal(size=6 * n)
        u[2 : 3 * n : 3] = -np.abs(u[2 : 3 * n : 3])
        e, mu, zero = rng.uniform(0, 0.5, n), rng.uniform(0, 0.4, n), np.zeros(n)
        turning = Turning(np.arange(n), zero, zero)
        law = ik.Law(restitution)
        six = solve_contacts(ContactProblem(W, u, u, e, mu, zero, turning=turning), law)
        W, u = W[: 3 * n, : 3 * n], u[: 3 * n]
        three = solve_contacts(ContactProblem(W, u, u, e, mu, zero), law)
        assert six.residual < 1e-13 and not six.impulse[3 * n :].any()
        assert six.velocity_after[: 3 * n] == pytest.approx(three.velocity_after, abs=1e-11)


def test_zero_coefficients_change_no_bit():
    v = [1.3, 0.2, -2.0, 1.0, 7.0, -3.0]
    plain = bounced(v, restitution=0.3, friction=0.2)
    zero = bounced(v, restitution=0.3, friction=0.2, rolling=0.0, torsion=0)
    assert zero.v_after.tobytes() == plain.v_after.tobytes()
    assert zero.contacts[0].points[0].turning is None
    assert not zero.contacts[0].angular_impulse.any()


def test_redundant_corners_share_the_moments():
    """A box on four corners that spins: the resultant is that of one patch."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer").with_ground()
    floor = ik.Collision("box", "ground", rolling=1e-3, torsion=2e-3)
    half = 0.05
    scene = ik.Scene(box, contacts=[floor])
    q = box.configuration(root_joint=[0, 0, half, 0, 0, 0, 1])
    impact = ik.solve(scene, q, box.velocity(root_joint=[0, 0, -1.0, 0, 0, 4.0]))
    assert impact.is_valid() and len(impact.contacts[0].points) == 4
    normal = impact.contacts[0].impulse[2]
    assert impact.contacts[0].angular_impulse[2] == pytest.approx(-2e-3 * normal, rel=1e-9)
    inertia = box.model.inertias[1].inertia[2, 2]
    assert impact.v_after[5] == pytest.approx(4.0 - 2e-3 * normal / inertia, rel=1e-10)


def test_batches_solve_such_rows_one_by_one():
    floor = ik.Contact("ball", at=[0, 0, -R], restitution=0.5, friction=0.4, rolling=1e-3)
    scene = ik.Scene(BALL, contacts=[floor], gap_bound=9)
    v = np.random.default_rng(3).normal(size=(5, 6)) - [0, 0, 3, 0, 0, 0]
    batch = ik.solve_batch(scene, BALL.neutral(), v)
    assert "rolling" in " ".join(batch.plan.why) and batch.valid.all()
    for row, own in zip(batch.v_after, v, strict=True):
        assert row.tobytes() == ik.solve(scene, BALL.neutral(), own).v_after.tobytes()


@pytest.mark.parametrize(
    ("law", "more"),
    [
        (ik.Law("stronge", "path"), {}),
        (ik.Law(slip="path"), {}),
        (ik.Law(order="sequential"), {}),
        (ik.Law("lzb"), {"stiffness": 1.0}),
        (ik.Law(), {"adhesion": 1.0}),
    ],
)
def test_other_laws_refuse_it(law, more):
    contact = ik.Contact("ball", rolling=1e-3, **more)
    with pytest.raises(ik.errors.InputError, match="rolling and torsion need"):
        ik.Scene(BALL, contacts=[contact], law=law)


@pytest.mark.parametrize("field", ["rolling", "torsion"])
@pytest.mark.parametrize("value", [-1e-3, np.inf, np.nan])
def test_bad_coefficients_are_refused(field, value):
    with pytest.raises(ik.errors.ImpulsekitError, match=f"{field} must be"):
        ik.Contact("ball", **{field: value})


def test_what_has_no_meaning_with_them_says_so():
    impact = bounced([0, 0, -2.0, 0, 0, 12.0], torsion=1e-3)
    for refuses in (
        ik.derivatives,
        lambda i: ik.force_history(i, ik.Hertz(E=1e7, nu=0.3, radius=1)),
    ):
        with pytest.raises(ik.errors.InputError, match="rolling"):
            refuses(impact)
