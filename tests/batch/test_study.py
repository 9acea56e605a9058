"""Studies: drawn the same everywhere, resumed bit for bit."""

import errno
import hashlib
import pathlib

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.batch.masses import scaled_robot
from impulsekit.batch.study.lock import StoreFullError
from impulsekit.cli import main
from impulsekit.study import load_study, open_study, run_study, summarize

for package in ("xarray", "dask"):
    pytest.importorskip(package)

SCENE = """
[robot]
example = "panda"

[[impulses]]
name = "blow"
frame = "panda_hand"
linear = [0, 0, 1]

[batch]
samples = {samples}
seed = 3
chunk = {chunk}
outputs = ["v_after", "energy_change"]

[[batch.vary]]
what = "configuration"
low = -0.3
high = 0.3

[[batch.vary]]
what = "impulse"
of = "blow"
distribution = "normal"
mean = 1.0
deviation = 0.1

[[batch.vary]]
what = "direction"
low = 0.0
high = 0.5
"""


@pytest.fixture
def scene_file(tmp_path):
    def make(samples=1000, chunk=256):
        path = tmp_path / "scene.toml"
        path.write_text(SCENE.format(samples=samples, chunk=chunk))
        return path

    return make


def contents(folder):
    """Every file of a store, by name, as a digest."""
    root = pathlib.Path(folder)
    return {
        str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in root.rglob("*")
        if path.is_file()
    }


def test_rows_can_be_solved_again_alone(scene_file, tmp_path):
    study = load_study(scene_file())
    run_study(study, tmp_path / "rows")
    rows = open_study(tmp_path / "rows")
    assert rows.sizes["row"] == 1000
    assert rows["v_after"].attrs["units"]
    for i in (0, 255, 256, 999):
        wrench = rows["impulses"][i].values
        scene = ik.Scene(study.scene.robot, [ik.AppliedImpulse("panda_hand", wrench[:3])])
        impact = ik.solve(scene, rows["q"][i].values, study.v)
        assert np.abs(impact.v_after - rows["v_after"][i].values).max() < 1e-12
    force = rows["impulses"].values[:, :3]
    angles = np.arccos(force[:, 2] / np.linalg.norm(force, axis=1))
    assert 0.0 < angles.min() < 0.01
    assert 0.49 < angles.max() < 0.5


def test_a_run_that_stopped_goes_on_bit_for_bit(scene_file, tmp_path):
    study = load_study(scene_file())
    run_study(study, tmp_path / "whole")

    class Stopped(Exception):
        pass

    def stop(done, total):
        if done > 300:
            raise Stopped

    with pytest.raises(Stopped):
        run_study(study, tmp_path / "parts", progress=stop)
    told = []
    run_study(study, tmp_path / "parts", progress=lambda done, total: told.append(done))
    assert told == [768, 1000]
    assert contents(tmp_path / "whole") == contents(tmp_path / "parts")


def test_a_full_disk_is_told_and_what_is_done_stays(scene_file, tmp_path, monkeypatch):
    study = load_study(scene_file())
    whole = np.savez
    calls = []

    def full(file, **arrays):
        calls.append(1)
        if len(calls) == 3:
            file.write(b"so far it goes")
            raise OSError(errno.ENOSPC, "No space left on device")
        whole(file, **arrays)

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(StoreFullError, match="no space left"):
        run_study(study, tmp_path / "rows")
    monkeypatch.undo()
    told = []
    run_study(study, tmp_path / "rows", progress=lambda done, total: told.append(done))
    assert told == [768, 1000]


def test_the_command(scene_file, tmp_path):
    store = str(tmp_path / "rows")
    done = CliRunner().invoke(main, ["batch", str(scene_file()), "-o", store, "-q"])
    assert done.exit_code == 0, done.output
    assert "1000  SOLVED" in done.output
    again = CliRunner().invoke(main, ["batch", str(scene_file(999)), "-o", store, "-q"])
    assert again.exit_code == 2
    assert "another study" in again.output


def test_masses_that_vary_are_kept_with_the_rows(scene_file, tmp_path):
    path = scene_file()
    path.write_text(
        path.read_text()
        + """
[[batch.vary]]
what = "mass"
low = 0.8
high = 1.25

[[batch.vary]]
what = "mass"
of = "panda_hand"
distribution = "normal"
mean = 1.0
deviation = 0.3
low = 0.1
"""
    )
    study = load_study(path)
    run_study(study, tmp_path / "rows")
    rows = open_study(tmp_path / "rows")
    links = rows["link"].values.tolist()
    assert {"panda_link1", "panda_hand"} <= set(links)
    factors = rows["masses"].values
    assert factors.shape == (1000, len(links))
    hand = links.index("panda_hand")
    others = np.delete(factors, hand, axis=1)
    assert 0.8 <= others.min() < 0.81
    assert 1.24 < others.max() <= 1.25
    assert np.unique(factors[0]).size == len(links)
    assert factors[:, hand].std() > 0.25
    for i in (0, 999):
        robot = scaled_robot(study.scene.robot, dict(zip(links, factors[i], strict=True)))
        blow = ik.AppliedImpulse("panda_hand", rows["impulses"][i].values[:3])
        impact = ik.solve(ik.Scene(robot, [blow]), rows["q"][i].values, study.v)
        assert np.abs(impact.v_after - rows["v_after"][i].values).max() < 1e-12
    assert summarize(tmp_path / "rows").rows == 1000
