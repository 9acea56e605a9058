"""Recordings with noise, lag, scale, a floor that is off and 5 % outliers: all of it comes back."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.measured import Recording, calibrate, find_impacts, fit_impacts
from impulsekit.measured.floor import rest_of
from tests.measured.bodies import G

from ..robots import one_body

E, MU, SCALE, FLOOR, LAG, RATE = 0.5, 0.15, 0.98, 0.004, 0.003, 125
NOISE = np.array([3e-4] * 3 + [3e-3] * 3)
# How far outliers are off [m, rad], as of a marker that was taken for another.
WILD = np.array([0.03] * 3 + [0.2] * 3)


def point_scene():
    """A body that turns in flight and touches with its mass centre alone."""
    robot = one_body("point", 0.3, 0.0001)
    floor = ik.Contact("point", restitution=0.4, friction=0.2, name="floor")
    return ik.Scene(robot, contacts=[floor], gravity=[0, 0, -G])


def way_of(place, v):
    """(start, place, velocity, acceleration) of each flight, of the slide and of the rest.

    In closed form: u_n⁺ = −e u_n⁻, and |Δu_t| = µ (1 + e) |u_n⁻| or all of u_t.
    """
    t, parts, fall = 0.0, [], np.array([0, 0, -G])
    while True:
        parts.append((t, place, v, fall))
        last = (v[2] + np.sqrt(v[2] ** 2 + 2 * G * place[2])) / G
        t, place, v = t + last, place + v * last + 0.5 * fall * last**2, v + fall * last
        place[2], down, slip = 0.0, -v[2], np.hypot(*v[:2])
        v[:2] *= max(0.0, 1.0 - MU * (1 + E) * down / max(slip, 1e-9))
        v[2] = E * down
        if v[2] < 0.02:
            break
    rest, slip = t, np.hypot(*v[:2])
    if slip > 0.0:
        slow = -MU * G / slip * np.array([*v[:2], 0.0])
        parts.append((t, place, np.array([*v[:2], 0.0]), slow))
        last = slip / (MU * G)
        t, place = t + last, place + parts[-1][2] * last + 0.5 * slow * last**2
    return [*parts, (t, place, np.zeros(3), np.zeros(3))], rest


def recorded(scene, rng, outliers=0.05):
    """One throw until it has lain for a quarter of a second, as a poor recording."""
    turn, speed = rng.uniform(0, 2 * np.pi), rng.uniform(0.9, 1.6)
    v = np.array([speed * np.cos(turn), speed * np.sin(turn), rng.uniform(-0.2, 0.2)])
    parts, rest = way_of(np.array([*rng.uniform(-0.3, 0.3, 2), rng.uniform(0.25, 0.4)]), v)
    t = np.arange(0, parts[-1][0] + 0.25, 1 / RATE) + 1e-3 * rng.uniform()
    starts = np.array([part[0] for part in parts])

    def at(time):
        start, place, v, rate = parts[max(0, int(np.searchsorted(starts, time, "right")) - 1)]
        late = time - start
        return place + v * late + 0.5 * rate * late**2, v + rate * late

    first, omega = pin.exp3(rng.normal(size=3)), 4 * rng.normal(size=3)
    q, v = np.zeros((len(t), 7)), np.zeros((len(t), 6))
    for k, time in enumerate(t):
        axes, before = first @ pin.exp3(omega * min(time, rest)), max(time - LAG, 0.0)
        pose = [*SCALE * (at(time)[0] + [0, 0, FLOOR]), *pin.Quaternion(axes).coeffs()]
        v[k, :3] = SCALE * axes.T @ at(before)[1] + 0.02 * rng.normal(size=3)
        v[k, 3:] = omega * (before < rest) + 0.1 * rng.normal(size=3)
        off = NOISE * rng.normal(size=6)
        if rng.uniform() < outliers:
            off += WILD * rng.normal(size=6)
            v[k, :3] += 0.5 * rng.normal(size=3)
        q[k] = pin.integrate(scene.robot.model, np.array(pose), off)
    return Recording(scene.robot, t, q, v=v, name=f"{rng.uniform()}")


def scores(seed, count):
    """(found − true) / its standard deviation of e, µ, floor, lag and scale, and (found − true)."""
    scene, rng = point_scene(), np.random.default_rng(seed)
    throws = [recorded(scene, rng) for _ in range(count)]
    found = calibrate(throws, scene)
    impacts = find_impacts([found.apply(each) for each in throws], found.scene(scene))
    fit = fit_impacts(
        impacts.balanced().measurements(found.scene(scene)),
        restitution=["floor"], friction=["floor"], robust="biweight",
    )  # fmt: skip
    # Half of a 95 % interval is 1.96 standard deviations.
    spread = np.diff(fit.intervals()).ravel() / (2 * 1.959964)
    names = ("floor_height", "velocity_lag", "length_scale")
    off = [getattr(found, n) - x for n, x in zip(names, (FLOOR, LAG, SCALE), strict=True)]
    off = np.array([*(fit.values - [E, MU]), *off])
    # Likewise for Student's quantiles.
    spread = [*spread, *(np.ptp(found.intervals()[name]) / (2 * 1.959964) for name in names)]
    return off / spread, off


def test_a_rest_is_found_between_outliers():
    scene, rng = point_scene(), np.random.default_rng(5)
    throw = recorded(scene, rng, outliers=0.0)
    q = throw.q.copy()
    for k in (-3, -9, -14, -15):
        q[k] = pin.integrate(scene.robot.model, q[k], WILD)
    found = rest_of(Recording(scene.robot, throw.t, q))
    # The median of 18 samples, each with 0.3 mm of noise.
    assert found[:3] == pytest.approx(throw.q[-20:, :3].mean(axis=0), abs=4e-4)
    flying = throw.part(0.0, 0.2)
    assert rest_of(flying) is None


@pytest.mark.parametrize("rate", [125, 500, 2000])
def test_the_top_of_a_flight_is_no_rest(rate):
    scene, t = point_scene(), np.arange(0, 0.3, 1 / rate)
    q = np.tile([0.0, 0, 0, 0, 0, 0, 1], (len(t), 1))
    q[:, 2] = 1.0 - 0.5 * G * (t - 0.15) ** 2
    q[:, :3] += 5e-4 * np.random.default_rng(0).normal(size=(len(t), 3))
    assert rest_of(Recording(scene.robot, t, q)) is None


@pytest.mark.slow
def test_coefficients_floor_and_lag_come_back():
    score, off = scores(3, 4)
    assert (np.abs(score) < 4.0).all()
    # e, µ, floor [m], lag [s], scale.
    assert (np.abs(off) < [0.005, 0.005, 5e-4, 5e-4, 5e-3]).all()
