"""A lone foot under a blow that alone would throw it keeps its digits in a batch."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.batch.result import OUTPUTS
from impulsekit.batch.solve import solve_batch
from impulsekit.laws.status import Status
from tests.batch.compare import random_states
from tests.reference.models import mass_matrix
from tests.truths.digits import velocity_after

pytest.importorskip("numba")

EPS = np.finfo(float).eps
ROWS = 2000


@pytest.fixture(scope="module")
def bolt():
    return ik.Robot.from_example("bolt")


@pytest.fixture(scope="module")
def states(bolt):
    return random_states(bolt, ROWS)


def thrown_leg(bolt, **coefficients):
    """The blow alone would throw the foot at up to 1000 m/s."""
    blow = ik.AppliedImpulse(
        "FL_UPPER_LEG", [0.54, -0.88, -1.07], [0.2, 0.68, 1.28], at=[0.04, 0.03, 0.13]
    )
    foot = ik.Contact(
        "FL_LOWER_LEG", at=[0.1, -0.12, 0.09], normal=[0.8, -0.42, 0.42], **coefficients
    )
    return ik.Scene(bolt, [blow], contacts=[foot])


def farthest(scene, q, v, batch, count):
    """The rows that lose most beside free motion, and those farthest from ``solve``."""
    free = solve_batch(ik.Scene(scene.robot, scene.impulses), q, v).v_after
    held = np.abs(batch.v_after).max(axis=1)
    lost = np.abs(free).max(axis=1) / held
    alone = np.array([ik.solve(scene, *row).v_after for row in zip(q, v, strict=True)])
    apart = np.abs(alone - batch.v_after).max(axis=1) / held
    lost[batch.status != Status.SOLVED] = 0.0
    apart[batch.status != Status.SOLVED] = 0.0
    return {*np.argsort(lost)[-count:], *np.argsort(apart)[-count:]}


def condition(robot, q):
    return np.linalg.cond(mass_matrix(robot.model, q))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "restitution"),
    [
        (0.6, 0.0),
        pytest.param(0.15, 0.5, marks=pytest.mark.slow),
        pytest.param(0.0, 0.4, marks=pytest.mark.slow),
    ],
)
def test_speeds_are_right_to_the_condition_of_the_masses(bolt, states, friction, restitution):
    scene = thrown_leg(bolt, friction=friction, restitution=restitution)
    q, v = states
    batch = solve_batch(scene, q, v)
    for row in farthest(scene, q, v, batch, 5):
        exact = np.array([float(x) for x in velocity_after(scene, q[row], v[row])])
        off = np.abs(batch.v_after[row] - exact).max() / np.abs(exact).max()
        assert batch.plan.kernel and batch.status[row] == Status.SOLVED
        assert off < min(1e-12, 10.0 * condition(bolt, q[row]) * EPS)


def test_all_that_is_told_of_the_impact_belongs_together(bolt, states):
    """M Δv = I, and the work of all impulses is the change of the kinetic energy."""
    q, v = states
    batch = solve_batch(thrown_leg(bolt, friction=0.6), q, v, outputs=OUTPUTS)
    for row in range(0, ROWS, 10):
        masses = mass_matrix(bolt.model, q[row])
        left = masses @ batch.dv[row] - batch.generalized_impulse[row]
        assert np.abs(left).max() < 1e-14 * np.linalg.norm([0.54, -0.88, -1.07])
        gained = 0.5 * batch.dv[row] @ masses @ (v[row] + batch.v_after[row])
        assert abs(batch.energy_change[row] - gained) < 1e-12


def test_a_state_has_one_answer_whoever_stands_beside_it(bolt, states):
    scene = thrown_leg(bolt, friction=0.6)
    q, v = states
    batch = solve_batch(scene, q, v, outputs=OUTPUTS)
    for row in range(0, ROWS, 100):
        alone = solve_batch(scene, q[row : row + 1], v[row : row + 1], outputs=OUTPUTS)
        for name in ("v_after", "contact_impulses", "energy_change", "generalized_impulse"):
            assert np.array_equal(getattr(alone, name)[0], getattr(batch, name)[row])
