"""Fits of coefficients and inertias to synthetic measurements."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.measured import Measurement, fit_impacts
from impulsekit.models import pendulum_urdf


def thrown(e=0.5, mu=0.2, count=8, seed=0):
    """A scene with wrong coefficients, and throws of a box that lands on a corner, slipping."""
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    corner = ik.Contact("box", at=[0.15, 0.1, -0.05], restitution=e, friction=mu, name="floor")
    rng = np.random.default_rng(seed)
    throws = []
    for _ in range(count):
        q = pin.integrate(box.model, box.neutral(), rng.uniform(-0.3, 0.3, 6))
        v = np.array([*rng.uniform(2, 4, 2), -rng.uniform(1, 3), *rng.normal(size=3)])
        throws.append((q, v))
    return ik.Scene(box, contacts=[corner]), throws


def measured(truth, scene, throws, sigma, rng, told=True):
    found = []
    for q, v in throws:
        after = ik.solve(truth, q, v).v_after
        noisy = after + sigma * rng.normal(size=len(after))
        found.append(Measurement(scene, q, v, noisy, sigma if told else None))
    return found


def fit(measurements):
    return fit_impacts(measurements, restitution=["floor"], friction=["floor"])


def test_exact_measurements_give_the_coefficients_back():
    scene, throws = thrown()
    truth, _ = thrown(0.73, 0.31)
    found = fit(measured(truth, scene, throws, 0.0 + 1e-12, np.random.default_rng(0)))
    assert found.values == pytest.approx([0.73, 0.31], abs=1e-9)
    assert found.names == ("floor: restitution", "floor: friction")
    assert found["floor: friction"] == found.values[1] and found.converged


def test_numbers_that_were_not_measured_do_not_count():
    scene, throws = thrown()
    truth, _ = thrown(0.73, 0.31)
    full = measured(truth, scene, throws, 1e-9, np.random.default_rng(0))
    partial = []
    for m in full:
        after = np.array(m.v_after)
        after[3:] = np.nan
        partial.append(Measurement(scene, m.q, m.v_before, after, m.sigma))
    found = fit(partial)
    assert found.values == pytest.approx([0.73, 0.31], abs=1e-6)
    assert found.freedom == 3 * len(throws) - 2


def test_inertias_of_a_link():
    robot = ik.Robot.from_urdf(pendulum_urdf(2))
    rng = np.random.default_rng(3)
    names = {"joint_2": ["mass", "mz", "iyy"]}

    def scene_of(robot, at):
        return ik.Scene(robot, [ik.AppliedImpulse("link_2", linear=[1, 0, 0], at=at)])

    changed = pin.Model(robot.model)
    values = changed.inertias[2].toDynamicParameters()
    values[[0, 3, 6]] *= [1.3, 1.2, 1.15]
    changed.inertias[2] = pin.Inertia.FromDynamicParameters(values)
    heavier = ik.Robot.from_model(changed)
    seen = []
    for _ in range(6):
        q, at = rng.uniform(-1, 1, 2), [0, 0, -rng.uniform(0.2, 1)]
        after = ik.solve(scene_of(heavier, at), q, [0.0, 0.0]).v_after
        seen.append(Measurement(scene_of(robot, at), q, [0.0, 0.0], after, 1e-6))
    found = fit_impacts(seen, inertias=names)
    assert found.values == pytest.approx(values[[0, 3, 6]], rel=1e-6)


def test_what_no_contact_tells_is_said_and_is_not_converged():
    scene, throws = thrown(0.5, 9.0)
    found = fit(measured(scene, scene, throws, 1e-3, np.random.default_rng(1)))
    assert not found.converged
    assert any("floor: friction is not determined" in note for note in found.notes)


def test_noise_far_above_the_given_sigma_is_a_misfit_and_widens_the_intervals():
    truth, throws = thrown(0.6, 0.25, count=12)
    rng = np.random.default_rng(5)
    seen = [
        Measurement(truth, m.q, m.v_before, m.v_after, 1e-6)
        for m in measured(truth, truth, throws, 1e-2, rng)
    ]
    found = fit(seen)
    assert any("times the given sigma" in note for note in found.notes)
    assert found.noise == pytest.approx(1e4, rel=0.4)
    low, high = found.intervals().T
    assert (low < [0.6, 0.25]).all() and (high > [0.6, 0.25]).all()
    assert (high - low > 1e-4).all()
    fair = fit([Measurement(m.scene, m.q, m.v_before, m.v_after, 1e-2) for m in seen])
    assert not fair.notes and not fair.estimated


def test_intervals_stay_where_coefficients_may_lie_and_reached_bounds_are_said():
    truth, throws = thrown(0.99, 0.2)
    found = fit(measured(truth, truth, throws, 0.3, np.random.default_rng(2), told=False))
    (low, high), (least, _) = found.intervals()
    assert 0.0 <= low <= high <= 1.0 and least >= 0.0
    # Speeds that no restitution up to 1 explains.
    faster = [
        Measurement(truth, q, v, ik.solve(truth, q, v).v_after - 0.6 * np.eye(6)[2] * v[2])
        for q, v in throws
    ]
    assert any("reaches its bound 1" in note for note in fit(faster).notes)


def noisy_impacts(rng, truth, scene, throws, outliers=0):
    """Impacts with noise in q, v- and v+ of a covariance that couples them, and some wrong ones."""
    sigma = np.repeat([2e-3, 1e-2, 1e-2], 6)
    mixing = np.linalg.cholesky(0.7 * np.eye(18) + 0.3)
    covariance = (mixing @ mixing.T) * np.outer(sigma, sigma)
    found = []
    for k, (q, v) in enumerate(throws):
        noise = sigma * (mixing @ rng.normal(size=18))
        after = ik.solve(truth, q, v).v_after + noise[12:]
        if k < outliers:
            after = after + rng.normal(size=6) * [1, 1, 1, 5, 5, 5]
        seen = pin.integrate(scene.robot.model, q, noise[:6]), v + noise[6:12]
        found.append(ik.measured.Measurement(scene, *seen, after, covariance=covariance))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("outliers", [0, 1])
def test_errors_in_variables_and_outliers_are_covered(outliers):
    truth, _ = thrown(0.6, 0.25)
    robust = "biweight" if outliers else "none"
    covered, drawn, runs = np.zeros(2), np.zeros(2), 5
    for seed in range(runs):
        scene, throws = thrown(0.5, 0.3, count=12, seed=seed)
        seen = noisy_impacts(np.random.default_rng(seed), truth, scene, throws, outliers)
        found = ik.measured.fit_impacts(
            seen, restitution=["floor"], friction=["floor"], robust=robust
        )
        for count, (low, high) in (
            (covered, found.intervals().T),
            (drawn, np.percentile(found.resampled(200), [2.5, 97.5], axis=0)),
        ):
            count += (low <= [0.6, 0.25]) & (high >= [0.6, 0.25])
    assert (covered >= 0.8 * runs).all()
    assert (drawn >= 0.6 * runs).all()


def test_a_fit_that_starts_where_every_contact_sticks_finds_the_friction():
    scene, throws = thrown(0.5, 5.0)
    truth, _ = thrown(0.7, 0.15)
    found = fit(measured(truth, scene, throws, 1e-6, np.random.default_rng(3)))
    assert found.values == pytest.approx([0.7, 0.15], abs=1e-4)
    assert found.converged and not found.notes
