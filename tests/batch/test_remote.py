"""Batches on Dask give the rows that they give here."""

import numpy as np
import pytest

import impulsekit as ik
from tests.batch.compare import random_states

da = pytest.importorskip("dask.array")


@pytest.fixture(scope="module")
def scene():
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    return ik.Scene(
        solo,
        [ik.AppliedImpulse("base_link", name="kick")],
        contacts=[ik.Contact("FR_FOOT", friction=0.5)],
    )


def test_dask_arrays_in_and_out(scene):
    q, v = random_states(scene.robot, 100)
    kick = np.random.default_rng(0).normal(size=(100, 3))
    mu = np.linspace(0.1, 0.9, 100)
    outputs = ("v_after", "energy_change")
    arguments = {
        "impulses": {"kick": kick},
        "friction": {"contacts[0]": mu},
        "masses": {"base_link": np.linspace(0.5, 2.0, 100), "FR_FOOT": 1.5},
        "outputs": outputs,
    }
    here = ik.solve_batch(scene, q, v, **arguments)
    lazy = ik.solve_batch(scene, da.from_array(q, chunks=(37, -1)), v, **arguments)
    assert lazy.v_after.chunks[0] == (37, 37, 26)
    assert np.array_equal(lazy.v_after.compute(scheduler="synchronous"), here.v_after)
    assert np.array_equal(lazy.energy_change.compute(scheduler="synchronous"), here.energy_change)
    assert np.array_equal(lazy.status.compute(scheduler="synchronous"), here.status)


def test_what_all_rows_share_is_left_whole_where_its_length_is_that_of_the_batch(scene):
    q, v = random_states(scene.robot, scene.robot.nq)
    impulses = {"kick": np.random.default_rng(0).normal(size=(len(v), 3))}
    here = ik.solve_batch(scene, q[0], v, impulses=impulses, friction=[0.3])
    speeds = da.from_array(v, chunks=(4, -1))
    lazy = ik.solve_batch(scene, q[0], speeds, impulses=impulses, friction=[0.3])
    assert np.array_equal(lazy.v_after.compute(scheduler="synchronous"), here.v_after)


@pytest.mark.slow
def test_a_client(scene):
    distributed = pytest.importorskip("distributed")
    q, v = random_states(scene.robot, 3000)
    here = ik.solve_batch(scene, q, v)
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster, set_as_default=False) as client:
        there = ik.solve_batch(scene, q, v, client=client)
    assert np.array_equal(here.v_after, there.v_after)
