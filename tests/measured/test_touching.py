"""Ropes that jerk taut and gaps that are functions of q, whose impacts have closed forms."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import brentq

import impulsekit as ik
from impulsekit.design.solved import slopes_by_differences
from impulsekit.measured import Recording, find_impacts, fit_impacts
from impulsekit.measured.found_impacts import at_touch
from tests.measured.bodies import G
from tests.measured.test_recovery import point_scene

E, LENGTH, HEIGHT, WAVE, NOISE, STEP = 0.4, 0.8, 0.05, 5.0, 3e-4, 0.004


def cam(q):
    return q[2] - HEIGHT * np.cos(WAVE * q[0])


# By kind: the contact, its gap at a place and the gap's gradient there, where throws begin.
KINDS = {
    "rope": (
        ik.Rope("point", length=LENGTH, restitution=0.2, name="hit"),
        lambda p: LENGTH - np.linalg.norm(p),
        lambda p: -p / np.linalg.norm(p),
        ([0.1, 0.0, 0.1], [2.0, 0.5, 0.5]),
    ),
    "cam": (
        ik.GapContact(cam, restitution=0.2, name="hit"),
        cam,
        lambda p: np.array([HEIGHT * WAVE * np.sin(WAVE * p[0]), 0.0, 1.0]),
        ([0.1, 0.0, 0.4], [0.5, 0.2, 0.0]),
    ),
}


def thrown(kind, robot, rng):
    """A point that flies, hits once and flies on: v⁺ = v⁻ − (1 + e) n (n·v⁻)/n². With noise."""
    _, gap, normal, (place, v) = KINDS[kind]
    place, v = place + 0.05 * rng.normal(size=3), v + 0.2 * rng.normal(size=3)
    fall = np.array([0.0, 0.0, -G])

    def at(time, place, v):
        return place + v * time + 0.5 * fall * time**2

    later = next(s for s in np.arange(1, 2000) * 1e-3 if gap(at(s, place, v)) < 0.0)
    hit = brentq(lambda s: gap(at(s, place, v)), later - 1e-3, later)
    there, fast = at(hit, place, v), v + fall * hit
    n = normal(there)
    left = fast - (1 + E) * n * (n @ fast) / (n @ n)
    t, turn = np.arange(0.0, hit + 0.15, STEP), np.array([1.0, -2.0, 0.5])
    q = np.array(
        [
            [
                *(at(s, place, v) if s < hit else at(s - hit, there, left)),
                *pin.Quaternion(pin.exp3(turn * s)).coeffs(),
            ]
            for s in t
        ]
    )
    q[:, :3] += NOISE * rng.normal(size=(len(t), 3))
    return Recording(robot, t, q, name=f"{hit}")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_restitution_comes_back_where_noise_leaves_a_gap(kind):
    robot, rng = point_scene().robot, np.random.default_rng(6)
    scene = ik.Scene(robot, contacts=[KINDS[kind][0]], gravity=[0, 0, -G])
    found = find_impacts([thrown(kind, robot, rng) for _ in range(4)], scene)
    assert [each.contacts for each in found.impacts] == [("hit",)] * 4
    # Some of them are found before they touch.
    assert max(each.gaps[0] for each in found.impacts) > 5e-5
    fit = fit_impacts(found.balanced().measurements(scene), restitution=["hit"])
    assert fit.notes == ()
    sigma = np.sqrt(fit.covariance[0, 0])
    assert sigma < 0.003 and abs(fit.values[0] - E) < 3 * sigma


@pytest.mark.parametrize("kind", KINDS)
def test_what_closed_is_brought_to_touch_by_the_likeliest_change(kind):
    contact, gap, normal, (place, _) = KINDS[kind]
    scene = ik.Scene(point_scene().robot, contacts=[contact])
    n = normal(np.array(place))
    # Off by a little along the normal from where it touches.
    q = scene.robot.configuration(root_joint=[*place, 0, 0, 0, 1])
    way = brentq(lambda s: gap(np.array(place) - s * n) - 4e-4, 0.0, 1.0)
    q[:3] -= way * n
    spread = np.diag([4.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    touched = at_touch(scene, ("hit",), q, spread)
    assert abs(gap(touched[:3])) < 1e-9
    n = normal(q[:3])
    likeliest = spread[:3, :3] @ n / (n @ spread[:3, :3] @ n) * 4e-4
    assert touched[:3] == pytest.approx(q[:3] - likeliest, abs=1e-6)
    assert np.array_equal(at_touch(scene, ("hit",), touched, spread), touched)
    assert np.array_equal(at_touch(scene, (), q, spread), q)


def test_slopes_of_a_gap_that_is_a_function_are_those_of_the_closed_form():
    contact, _, normal, _ = KINDS["cam"]
    scene = ik.Scene(point_scene().robot, contacts=[contact])
    x, v, e = 0.1, np.array([0.5, 0.2, -2.0]), contact.restitution
    n, size = normal([x]), 1.0 + normal([x])[0] ** 2
    bend = np.array([HEIGHT * WAVE**2 * np.cos(WAVE * x), 0.0, 0.0])
    q = scene.robot.configuration(root_joint=[x, 0, HEIGHT * np.cos(WAVE * x), 0, 0, 0, 1])
    by_q, by_v = slopes_by_differences(scene, q, [*v, 0, 0, 0])
    assert by_v[:3, :3] == pytest.approx(np.eye(3) - (1 + e) * np.outer(n, n) / size, abs=1e-7)
    turned = bend * (n @ v) + n * (bend @ v) - 2 * n * (n @ v) * (n @ bend) / size
    assert by_q[:3, 0] == pytest.approx(-(1 + e) * turned / size, abs=1e-7)
    assert by_q[:3, 1:3] == pytest.approx(np.zeros((3, 2)), abs=1e-7)
