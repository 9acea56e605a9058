"""Batches while kernels are not compiled yet: by ``solve``, as a whole, within a budget."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.batch import meanwhile
from impulsekit.batch.run import BatchRun
from impulsekit.laws.store import cache_folder

FRESH = """
import numpy as np
import impulsekit as ik
robot = ik.Robot.from_example("panda")
scene = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])])
blows = np.random.default_rng(0).normal(size=(20, 3))
batch = ik.solve_batch(scene, robot.neutral(), impulses=blows)
print(batch.single.all(), batch.valid.all())
"""


def struck():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])])
    blows = np.random.default_rng(3).normal(size=(70, 3))
    blows[5] = np.nan
    return scene, robot.neutral(), blows


@pytest.fixture
def not_compiled(monkeypatch):
    """As on a fresh installation."""
    monkeypatch.setattr(BatchRun, "is_compiled", False)
    monkeypatch.setattr(meanwhile, "_spent", {})
    token = meanwhile._kernels_only.set(False)
    yield
    meanwhile._kernels_only.reset(token)


def test_rows_are_those_of_kernels(not_compiled):
    scene, q, blows = struck()
    told = []
    batch = ik.solve_batch(
        scene, q, impulses=blows, outputs=("dv", "energy_change", "reactions"),
        progress=lambda *rows: told.append(rows),
    )  # fmt: skip
    assert batch.single.all() and batch.plan.kernel and told[-1] == (70, 70)
    with meanwhile.by_kernels_only():
        kernels = ik.solve_batch(
            scene, q, impulses=blows, outputs=("dv", "energy_change", "reactions")
        )
    assert not kernels.single.any()
    assert batch.status.tolist() == kernels.status.tolist()
    assert batch.uniqueness.tolist() == kernels.uniqueness.tolist()
    assert batch.status[5] == int(ik.Status.NOT_FINITE) and np.isnan(batch.dv[5]).all()
    for name in batch.arrays:
        size = np.nanmax(np.abs(kernels.arrays[name]))
        np.testing.assert_allclose(batch.arrays[name], kernels.arrays[name], atol=1e-12 * size)


@pytest.mark.parametrize("budget", [0.0, 1e-9])
def test_beyond_the_budget_kernels_solve_all_rows(not_compiled, monkeypatch, budget):
    monkeypatch.setattr(meanwhile, "BUDGETS", 3 * (budget,))
    scene, q, blows = struck()
    batch = ik.solve_batch(scene, q, impulses=blows)
    assert not batch.single.any() and batch.status[5] == int(ik.Status.NOT_FINITE)
    with meanwhile.by_kernels_only():
        kernels = ik.solve_batch(scene, q, impulses=blows)
    np.testing.assert_array_equal(batch.v_after, kernels.v_after)
    assert batch.uniqueness.tolist() == kernels.uniqueness.tolist()


def test_many_small_batches_are_compiled_in_the_end(not_compiled, monkeypatch):
    monkeypatch.setattr(meanwhile, "BUDGETS", (0.05, 0.0, 0.0))
    scene, q, blows = struck()
    ways = [ik.solve_batch(scene, q, impulses=blows[:4]).single.all() for _ in range(200)]
    assert ways[0] and not ways[-1]
    assert ways == sorted(ways, reverse=True)


def test_what_ran_is_compiled():
    scene, q, blows = struck()
    ik.solve_batch(scene, q, impulses=blows[:2])
    token = meanwhile._kernels_only.set(False)
    try:
        assert not ik.solve_batch(scene, q, impulses=blows[:2]).single.any()
    finally:
        meanwhile._kernels_only.reset(token)


@pytest.mark.slow
def test_a_fresh_installation_does_not_wait(tmp_path):
    """Neither is anything said of compiling."""
    out = subprocess.run(
        [sys.executable, "-c", FRESH],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert out.stdout.split() == ["True", "True"] and out.stderr == ""
    assert not list(tmp_path.rglob("*solve_blocks*"))


FIRST = """
import numpy as np, pinocchio as pin
import impulsekit as ik
from impulsekit.batch.meanwhile import by_kernels_only
from impulsekit.laws.store import Store
solo = ik.Robot.from_example("solo12", root="freeflyer")
legs = ("FL", "FR", "HL", "HR")
feet = [ik.Contact(f"{leg}_FOOT", friction=0.6, restitution=0.3) for leg in legs]
scene = ik.Scene(solo, contacts=feet)
rng = np.random.default_rng(0)
q = np.array([pin.integrate(solo.model, solo.neutral(), s) for s in rng.uniform(-1, 1, (64, 18))])
asked, load = set(), Store.load_overload
def noted(store, sig, context):
    asked.add(store._path(sig, context).name.partition("-")[0])
    return load(store, sig, context)
Store.load_overload = noted
with by_kernels_only():
    batch = ik.solve_batch(scene, q, rng.normal(size=(64, 18)))
assert batch.valid.all() and not batch.single.any()
print(*asked)
"""


@pytest.mark.slow
def test_a_first_batch_compiles_nothing_that_its_rows_do_not_need(tmp_path):
    """No bilateral rows, no single contact, no searches behind those that mostly do.

    Laws that other tests have compiled are loaded: what is asked for would be compiled.
    """
    (tmp_path / "impulsekit").mkdir()
    for path in cache_folder().glob("laws.*.code"):
        shutil.copy(path, tmp_path / "impulsekit")
    out = subprocess.run(
        [sys.executable, "-c", FIRST],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    made = set(out.stdout.split())
    assert {"batch.kernels.block.solve_blocks", "laws.frictional.frictional"} <= made
    assert not made & {
        "batch.kernels.held.hold", "batch.kernels.block._held_again",
        "batch.kernels.law._one_touches", "batch.kernels.left.is_left",
        "laws.approach.sweep", "laws.coulomb.coulomb", "laws.unloading.unload",
        "laws.frictional._search_on", "laws.redundant._tell_shared",
        "laws.coupling._feedback_by_eigenvalues", "laws.even_shares._share_dependent",
        "laws.even_shares._shift_moves",
    }  # fmt: skip
    # Of all others these alone have the law of one contact compiled in.
    assert not any(name.startswith("laws.single.") for name in made)
