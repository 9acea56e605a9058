"""Restitution that follows the approach speed, in batches."""

import numpy as np
import pytest

import impulsekit as ik
from tests.batch.compare import random_states, worst_difference

pytest.importorskip("numba")

TABLE = ik.RestitutionTable([0.1, 0.5, 1.0, 2.0], [0.9, 0.7, 0.75, 0.1])


@pytest.fixture(scope="module")
def solo():
    return ik.Robot.from_example("solo12", root="freeflyer")


def test_a_table_at_one_foot(solo):
    contact = ik.Contact("FR_FOOT", restitution=TABLE, friction=0.3)
    q, v = random_states(solo, 100)
    worst, _batch = worst_difference(ik.Scene(solo, contacts=[contact]), q, v)
    assert worst < 1e-12


def test_tables_beside_numbers_and_capture_speeds(solo):
    other = ik.RestitutionTable([0.3], [0.4])
    values = (TABLE, 0.5, other, ik.Restitution(0.8, capture_speed=1.0))
    feet = ("FR_FOOT", "FL_FOOT", "HR_FOOT", "HL_FOOT")
    contacts = [ik.Contact(f, restitution=e) for f, e in zip(feet, values, strict=True)]
    q, v = random_states(solo, 100)
    worst, _batch = worst_difference(ik.Scene(solo, contacts=contacts), q, v)
    assert worst < 1e-12


@pytest.mark.parametrize("own", [TABLE, ik.Restitution(0.9, capture_speed=5.0)])
def test_restitutions_given_with_the_batch_hold_at_every_speed(solo, own):
    contact = ik.Contact("FR_FOOT", restitution=own)
    q, v = random_states(solo, 20)
    given = ik.solve_batch(ik.Scene(solo, contacts=[contact]), q, v, restitution=0.6)
    plain = ik.Scene(solo, contacts=[ik.Contact("FR_FOOT", restitution=0.6)])
    assert np.abs(given.v_after - ik.solve_batch(plain, q, v).v_after).max() < 1e-13


def test_a_function_of_ones_own_is_called_state_by_state(solo):
    contact = ik.Contact("FR_FOOT", restitution=lambda speed: 1.0 / (1.0 + speed))
    q, v = random_states(solo, 4)
    worst, batch = worst_difference(ik.Scene(solo, contacts=[contact]), q, v)
    assert any("function of one's own" in line for line in batch.plan.why)
    assert worst < 1e-13
