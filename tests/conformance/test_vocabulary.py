"""Every entry of the vocabulary, through every way of using it."""

from __future__ import annotations

import inspect
import pickle

import numpy as np
import pytest

import impulsekit as ik

from .differences import assert_true
from .entries import ENTRIES, FORCES, true_after

SPEED = 1e-9
# Rows by differences are right to this.
BY_DIFFERENCES = 1e-8
# Of motions, over half a second.
MOTION = 1e-8


def named(table, **flags):
    chosen = [n for n, e in table.items() if all(getattr(e, k) == v for k, v in flags.items())]
    return pytest.mark.parametrize("name", chosen)


def test_the_tables_hold_every_entry():
    """All classes of the public face that a scene is made of; a new one has to be added here."""
    none = {"Robot", "Scene", "Law", "Impact", "Trajectory", "ImpactBatch", "MotionBatch"}
    none |= {"Simulation"}
    none |= {"Status", "MotionStatus", "Hertz", "HuntCrossley", "MeasuredCurve", "MaterialPair"}
    classes = {name for name in ik.__all__ if inspect.isclass(getattr(ik, name))} - none
    held = {name.split("-")[0] for name in (*ENTRIES, *FORCES)}
    assert classes <= held, classes - held


@named(ENTRIES)
def test_solve(name):
    entry = ENTRIES[name]
    impact = ik.solve(entry.scene, entry.q, entry.v)
    assert impact.is_valid()
    wanted = true_after(entry)
    assert np.abs(impact.v_after - wanted).max() < BY_DIFFERENCES * np.abs(entry.v).max()


@named(ENTRIES)
def test_solve_batch(name):
    entry = ENTRIES[name]
    speeds = [entry.v, 0.9 * entry.v]
    batch = ik.solve_batch(entry.scene, entry.q, speeds)
    for v, after in zip(speeds, batch.v_after, strict=True):
        one = ik.solve(entry.scene, entry.q, v).v_after
        assert np.abs(after - one).max() < SPEED * np.abs(entry.v).max()


@named(ENTRIES)
def test_simulate(name):
    """What is held stays held, what is kept apart stays apart, and the impact is that of solve."""
    entry = ENTRIES[name]
    motion = ik.simulate(entry.scene, entry.q, entry.v, duration=0.02, samples=5, accuracy="high")
    assert motion.status.finished
    time, impact = motion.impacts[0]
    assert time == 0.0
    after = ik.solve(entry.scene, entry.q, entry.v).v_after
    assert np.abs(impact.v_after - after).max() < SPEED * np.abs(entry.v).max()
    if entry.gap is None or entry.aim is not None or entry.ends == 1.0:
        return
    start = np.array(entry.gap(entry.q))
    for q in motion.q:
        off = np.array(entry.gap(q)) - start
        sign = -1.0 if name.startswith("Rope") else 1.0
        assert np.abs(off).max() < MOTION if entry.ends == 0.0 else sign * off.min() > -MOTION


@named(ENTRIES, plain=True)
def test_derivatives(name):
    entry = ENTRIES[name]
    scene = entry.near or entry.scene
    found = ik.derivatives(ik.solve(scene, entry.q, entry.v))
    assert found.status.exists or found.edges
    if not found.status.exists:
        return
    assert_true(scene, entry.q, entry.v)


@named(ENTRIES)
def test_pickling(name):
    entry = ENTRIES[name]
    impact = ik.solve(entry.scene, entry.q, entry.v)
    scene, again = pickle.loads(pickle.dumps((entry.scene, impact)))
    np.testing.assert_array_equal(again.v_after, impact.v_after)
    np.testing.assert_array_equal(ik.solve(scene, entry.q, entry.v).v_after, impact.v_after)


@named(ENTRIES)
def test_scene_files(name, tmp_path):
    entry, path = ENTRIES[name], tmp_path / "scene.toml"
    if not entry.text:
        with pytest.raises(ik.errors.InputError, match="cannot hold"):
            ik.save_scene(path, entry.scene, entry.q, entry.v)
        return
    ik.save_scene(path, entry.scene, entry.q, entry.v)
    file = ik.load_scene(path)
    after = ik.solve(entry.scene, entry.q, entry.v).v_after
    np.testing.assert_array_equal(ik.solve(file.scene, file.q, file.v).v_after, after)


@named(FORCES)
def test_forces(name, tmp_path):
    """An impact knows none of them; a motion follows its closed form, pickled and from a file."""
    pushed = FORCES[name]
    impact = ik.solve(pushed.scene, pushed.q, pushed.v)
    np.testing.assert_array_equal(impact.v_after, pushed.v)
    scenes = [pushed.scene, pickle.loads(pickle.dumps(pushed.scene))]
    if pushed.text:
        ik.save_scene(tmp_path / "scene.toml", pushed.scene, pushed.q, pushed.v)
        scenes.append(ik.load_scene(tmp_path / "scene.toml").scene)
    for scene in scenes:
        motion = ik.simulate(
            scene, pushed.q, pushed.v, duration=pushed.duration, samples=6, accuracy="high"
        )
        assert motion.status.finished
        for t, q, v in zip(motion.t, motion.q, motion.v, strict=True):
            np.testing.assert_allclose((q[0], v[0]), pushed.expected(t), rtol=0, atol=MOTION)
