"""Rolling and torsional friction at impacts: closed forms, the statement, no change at zero."""

import numpy as np
import pytest

import impulsekit as ik

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


@pytest.mark.parametrize("how", [{"torsion": 0.01}, {"rolling": 0.01}], ids=str)
def test_what_falls_without_spin_is_solved(how):
    """A residual beside speeds of turning that are rounding would say that it is not."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer").with_ground()
    flat = ik.Collision("box", "ground", restitution=0.3, friction=0.5, **how)
    q = box.configuration(root_joint=ik.pose([0, 0, 0.5]))
    motion = ik.simulate(ik.Scene(box, contacts=[flat]), q, box.velocity(), duration=1.0)
    assert motion.status.finished, motion.detail
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer").with_ground()
    touch = ik.Collision("ball", "ground", restitution=0.5, friction=0.5, **how)
    q = ball.configuration(root_joint=ik.pose([0, 0, 0.05], rpy=[0.3, 0.2, 0.1]))
    v = ball.velocity(root_world=[0, 0, -0.9, 0, 0, 0], q=q)
    impact = ik.solve(ik.Scene(ball, contacts=[touch]), q, v)
    assert impact.is_valid()
    assert impact.velocity_at("ball").after == pytest.approx([0, 0, 0.45], abs=1e-14)
