"""Poisson's restitution in batches, against single solves."""

import numpy as np
import pytest

import impulsekit as ik
from tests.batch.compare import random_states, worst_difference

pytest.importorskip("numba")

POISSON = ik.Law(restitution="poisson")
FEET = ("FR_FOOT", "FL_FOOT", "HR_FOOT", "HL_FOOT")


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.3, 0.9, 3.0])
@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_one_foot(solo, friction, restitution):
    contact = ik.Contact("FR_FOOT", friction=friction, restitution=restitution)
    blow = ik.AppliedImpulse("base_link", [0.3, -0.2, -1])
    q, v = random_states(solo, 60)
    worst, _batch = worst_difference(ik.Scene(solo, [blow], contacts=[contact], law=POISSON), q, v)
    assert worst < 1e-12


def test_feet_that_do_not_rub(solo):
    values = (0.5, 0.0, 1.0, ik.RestitutionTable([0.0, 2.0], [0.9, 0.2]))
    contacts = [ik.Contact(f, restitution=e) for f, e in zip(FEET, values, strict=True)]
    q, v = random_states(solo, 150)
    worst, _batch = worst_difference(ik.Scene(solo, contacts=contacts, law=POISSON), q, v)
    assert worst < 1e-12


@pytest.mark.slow
def test_feet_that_rub(solo):
    values = ((0.5, 0.4), (0.0, 0.8), (0.7, 0.0), (0.3, 0.2))
    contacts = [
        ik.Contact(f, restitution=e, friction=mu) for f, (e, mu) in zip(FEET, values, strict=True)
    ]
    q, v = random_states(solo, 150)
    worst, _batch = worst_difference(ik.Scene(solo, contacts=contacts, law=POISSON), q, v)
    assert worst < 1e-12


def test_beside_a_held_foot_and_joint_stops(solo):
    contacts = [
        ik.Contact("FR_FOOT", restitution=0.6, friction=0.5),
        ik.JointStop("HL_HFE", upper=0.3, restitution=0.4),
        ik.JointStop("HR_KFE", lower=-0.2, restitution=ik.Restitution(0.9, capture_speed=1.0)),
    ]
    scene = ik.Scene(solo, constraints=[ik.PointAnchor("FL_FOOT")], contacts=contacts, law=POISSON)
    q, v = random_states(solo, 150, seed=1)
    worst, _batch = worst_difference(scene, q, v)
    assert worst < 1e-12


def test_four_corners_share_and_spring_back():
    talos = ik.Robot.from_example("talos", root="freeflyer")
    corners = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]
    contacts = [ik.Contact("left_sole_link", at=at, restitution=0.5) for at in corners]
    q, v = random_states(talos, 20)
    v[:, 2] -= 2.0
    worst, _batch = worst_difference(ik.Scene(talos, contacts=contacts, law=POISSON), q, v)
    assert worst < 1e-12


def test_coefficients_that_vary(solo):
    rng = np.random.default_rng(5)
    contacts = [ik.Contact(f, restitution=0.5, friction=0.5) for f in FEET[:2]]
    scene = ik.Scene(solo, contacts=contacts, law=POISSON)
    q, v = random_states(solo, 60)
    e, mu = rng.uniform(0, 1, (60, 2)), rng.uniform(0, 1, (60, 2))
    batch = ik.solve_batch(scene, q, v, restitution=e, friction=mu)
    for i in range(60):
        own = [
            ik.Contact(f, restitution=e[i, k], friction=mu[i, k]) for k, f in enumerate(FEET[:2])
        ]
        alone = ik.solve(ik.Scene(solo, contacts=own, law=POISSON), q[i], v[i])
        assert np.abs(batch.v_after[i] - alone.v_after).max() < 1e-12 * np.abs(v[i]).max()


def test_tangential_restitution_is_refused(solo):
    contact = ik.Contact("FR_FOOT", friction=0.5, tangential_restitution=0.5)
    with pytest.raises(ik.errors.InputError, match="tangential"):
        ik.Scene(solo, contacts=[contact], law=POISSON)
