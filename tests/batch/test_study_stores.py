"""Stores of studies: no row that is not the study's own, whatever stops or runs beside."""

from __future__ import annotations

import dataclasses
import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.batch.study.lock import StoreLockedError
from impulsekit.batch.study.store import UNWRITTEN, StudyStore
from impulsekit.cli import main
from impulsekit.errors import InputError
from impulsekit.study import Study, Variation, load_study, open_study, run_study, summarize

from .forked import ForkedCommand

for package in ("xarray", "dask"):
    pytest.importorskip(package)

BODY = """<robot name="s"><link name="b"><inertial><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
<collision><origin xyz="{x} 0 0"/><geometry>{shape}</geometry></collision></link></robot>"""
FLOOR = """<robot name="f"><link name="f"><collision><origin xyz="0 0 -0.5"/>
<geometry><box size="100 100 1"/></geometry></collision></link></robot>"""
SCENE = """
[robots.a]
urdf = "a.urdf"
root = "freeflyer"
[robots.f]
urdf = "f.urdf"
[state.q]
"a/root_joint" = [0, 0, 0.1, 0, 0, 0, 1]
[state.v]
"a/root_joint" = [0, 0, -1, 0, 0, 0]
[[contacts]]
kind = "collision"
first = "a/b"
other = "f/f"
friction = 0.3
[batch]
samples = {samples}
seed = 1
chunk = {chunk}
outputs = ["v_after"]
[[batch.vary]]
what = "velocity"
of = "a/root_joint"
low = -0.2
high = 0.2
"""
BALL = '<sphere radius="0.1"/>'


@pytest.fixture
def files(tmp_path):
    def make(samples=256, chunk=64, shape=BALL, x=0.0):
        (tmp_path / "a.urdf").write_text(BODY.format(x=x, shape=shape))
        (tmp_path / "f.urdf").write_text(FLOOR)
        (tmp_path / "s.toml").write_text(SCENE.format(samples=samples, chunk=chunk))
        return tmp_path / "s.toml"

    return make


class Stopped(Exception):
    pass


def run_until(study, folder, rows):
    def progress(done, total):
        if done >= rows:
            raise Stopped

    with pytest.raises(Stopped):
        run_study(study, folder, progress=progress)


def test_rows_that_were_never_written_are_not_solved(files, tmp_path):
    study = load_study(files())
    run_until(study, tmp_path / "rows", 128)
    rows = open_study(tmp_path / "rows")
    assert (rows["status"].values[:128] == 0).all()
    assert (rows["status"].values[128:] == UNWRITTEN).all()
    assert np.isfinite(rows["v_after"].values[:128]).all()
    assert np.isnan(rows["v_after"].values[128:]).all()
    for given in (tmp_path / "rows", rows):
        summary = summarize(given)
        assert (summary.rows, summary.written, summary.complete) == (256, 128, False)
        assert sum(summary.statuses.values()) == 128
        assert "not complete: 128 of 256" in str(summary)
    run_study(study, tmp_path / "rows")
    assert summarize(tmp_path / "rows").complete


def test_a_store_whose_rows_were_lost_makes_them_again(files, tmp_path):
    study = load_study(files())
    run_study(study, tmp_path / "rows")
    whole = open_study(tmp_path / "rows")["v_after"].values
    (tmp_path / "rows" / "rows" / "2.npz").unlink()
    assert summarize(tmp_path / "rows").written == 192
    run_study(study, tmp_path / "rows")
    assert np.array_equal(open_study(tmp_path / "rows")["v_after"].values, whole)


def write_obj(path, height):
    corners = [(0, 0, 0), (0.2, 0, 0), (0, 0.2, 0), (0, 0, height)]
    faces = ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    path.write_text("\n".join([*("v {} {} {}".format(*c) for c in corners), *faces]) + "\n")


def flip(content, name):
    """Change a bit amid the numbers of an array."""
    # The name stands before the numbers, and in the table at the end.
    at = content.index(f"{name}.npy".encode()) + 180
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: flip(content, "v_after"),
        lambda content: flip(content, "status"),
        lambda content: content[:-8],
        lambda content: b"",
    ],
)
def test_a_chunk_that_was_changed_on_disk_is_told_and_made_again(files, tmp_path, damage):
    study = load_study(files(samples=250))
    run_study(study, tmp_path / "rows")
    whole = open_study(tmp_path / "rows").load()
    # The last chunk is not full.
    file = tmp_path / "rows" / "rows" / "3.npz"
    file.write_bytes(damage(file.read_bytes()))
    for look in (summarize, lambda folder: open_study(folder).load()):
        with pytest.raises(InputError, match=r"chunk 3 .* differs[)]; run the same study again"):
            look(tmp_path / "rows")
    run_study(study, tmp_path / "rows")
    assert open_study(tmp_path / "rows").load().identical(whole)


@pytest.mark.slow
@pytest.mark.parametrize("change", ["place", "size", "shape", "corner of a mesh"])
def test_another_collision_geometry_is_another_study(files, tmp_path, change):
    mesh = '<mesh filename="m.obj"/>'
    write_obj(tmp_path / "m.obj", 0.2)
    first = {"shape": mesh} if "mesh" in change else {}
    run_until(load_study(files(**first)), tmp_path / "rows", 128)
    if "mesh" in change:
        write_obj(tmp_path / "m.obj", 0.25)
    changed = {
        "place": {"x": 0.05},
        "size": {"shape": '<sphere radius="0.11"/>'},
        "shape": {"shape": '<box size="0.2 0.2 0.2"/>'},
        "corner of a mesh": {"shape": mesh},
    }[change]
    with pytest.raises(ik.errors.InputError, match=r"another study: geometry differ"):
        run_study(load_study(files(**changed)), tmp_path / "rows")


def fingerprint_of(robot=None, contact=None, impulses=(), **options):
    robot = ik.Robot.from_example("solo12", root="freeflyer") if robot is None else robot
    contacts = [contact] if contact is not None else []
    settings = {"samples": 64, **options}
    law = settings.pop("law", ik.Law())
    scene = ik.Scene(robot, impulses, contacts=contacts, law=law)
    return Study(scene, robot.neutral(), robot.velocity(), **settings).fingerprint


def test_every_field_of_the_model_is_in_the_fingerprint():
    model = ik.Robot.from_example("solo12", root="freeflyer").model
    base = fingerprint_of(ik.Robot.from_model(model))
    assert fingerprint_of(ik.Robot.from_model(model)) == base
    fields = [name for name in dir(model) if not name.startswith("_") and name != "gravity981"]
    arrays = [name for name in fields if isinstance(getattr(model, name), np.ndarray)]
    assert "armature" in arrays
    for name in arrays:
        other = pin.Model(model)
        values = np.array(getattr(other, name))
        if values.size == 0 or values.dtype != float:
            continue
        values[-1] = np.nextafter(values[-1], 0.123)
        setattr(other, name, values)
        assert fingerprint_of(ik.Robot.from_model(other)) != base, name
    for change in ("inertias", "jointPlacements", "frames"):
        other = pin.Model(model)
        if change == "inertias":
            other.inertias[3].mass = np.nextafter(other.inertias[3].mass, 10.0)
        elif change == "jointPlacements":
            other.jointPlacements[3].translation = model.jointPlacements[3].translation + 1e-15
        else:
            other.frames[3].placement = pin.SE3(np.eye(3), np.array([0.0, 0.0, 1e-15]))
        assert fingerprint_of(ik.Robot.from_model(other)) != base, change


def test_everything_else_that_a_row_depends_on_is_in_the_fingerprint():
    def contact(**options):
        return ik.Contact("FL_FOOT", **{"friction": 0.3, "restitution": 0.5, **options})

    def half(speed):
        return 0.5 * speed / (1.0 + speed)

    def law(e):
        return lambda speed: e

    near = np.nextafter(0.3, 1.0)
    blow = ik.AppliedImpulse("base_link", linear=[0, 0, 1])
    given = [
        fingerprint_of(contact=contact()),
        fingerprint_of(contact=contact(friction=near)),
        fingerprint_of(contact=contact(restitution=ik.Restitution(0.5, 0.1))),
        fingerprint_of(contact=contact(restitution=ik.RestitutionTable([0.0, 1.0], [0.5, near]))),
        fingerprint_of(contact=contact(restitution=half)),
        fingerprint_of(contact=contact(restitution=lambda speed: 0.5)),
        fingerprint_of(contact=contact(restitution=law(0.3))),
        fingerprint_of(contact=contact(restitution=law(near))),
        fingerprint_of(contact=contact(), law=ik.Law(restitution="poisson")),
        fingerprint_of(contact=contact(), impulses=[blow]),
        fingerprint_of(contact=contact(), seed=1),
        fingerprint_of(contact=contact(), chunk=32),
        fingerprint_of(contact=contact(), samples=65),
        fingerprint_of(contact=contact(), outputs=["dv"]),
        fingerprint_of(contact=contact(), vary=[Variation("velocity", low=0.0, high=0.3)]),
        fingerprint_of(contact=contact(), vary=[Variation("velocity", low=0.0, high=near)]),
    ]
    assert len(set(given)) == len(given)
    assert fingerprint_of(contact=contact(restitution=law(0.3))) == given[6]


def test_only_one_run_writes_at_a_time(files, tmp_path):
    study = load_study(files())
    met = []

    def beside(done, total):
        if not met:
            with pytest.raises(StoreLockedError) as caught:
                run_study(load_study(files()), tmp_path / "rows")
            met.append(caught.value)

    run_study(study, tmp_path / "rows", progress=beside)
    assert met[0].process == os.getpid()
    for word in (str(os.getpid()), met[0].host, met[0].since, "rows"):
        assert word in str(met[0])
    run_study(study, tmp_path / "rows")


def same_rows(one, other):
    a, b = open_study(one), open_study(other)
    return all(np.array_equal(a[name].values, b[name].values) for name in a.data_vars)


def test_a_store_that_is_taken_away_gets_nothing_more(files, tmp_path):
    study = load_study(files())
    other = dataclasses.replace(study, seed=2)
    run_study(other, tmp_path / "of_the_other")

    def swap(done, total):
        (tmp_path / "rows").rename(tmp_path / "moved")
        run_study(other, tmp_path / "rows")

    with pytest.raises(StoreLockedError, match="moved or deleted"):
        run_study(study, tmp_path / "rows", progress=swap)
    assert same_rows(tmp_path / "rows", tmp_path / "of_the_other")
    assert summarize(tmp_path / "moved").written == 64


def options(path, folder):
    return ["batch", str(path), "-q", "-o", str(folder), "--threads", "1"]


def start(path, folder, *more):
    command = [sys.executable, "-m", "impulsekit", *options(path, folder), *more]
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        # Where the tests themselves ignore Ctrl-C, as in the background, it would inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def wait_until_written(folder, process):
    while process.poll() is None and not (folder / "rows" / "0.npz").exists():
        time.sleep(0.002)


@pytest.mark.slow
def test_ctrl_c_says_how_to_go_on(files, tmp_path):
    path = files(samples=5_000, chunk=64)
    process = start(path, tmp_path / "rows")
    wait_until_written(tmp_path / "rows", process)
    process.send_signal(signal.SIGINT)
    told = process.communicate(timeout=60)[0]
    assert process.returncode == 130
    assert "of 5000 rows are written" in told
    assert f"batch {path}" in told
    assert "Traceback" not in told


def test_ctrl_c_while_a_chunk_is_written_comes_after_it(files, tmp_path, monkeypatch):
    write, before = StudyStore.write, signal.getsignal(signal.SIGINT)

    def struck(place, index, arrays):
        signal.raise_signal(signal.SIGINT)
        write(place, index, arrays)

    monkeypatch.setattr(StudyStore, "write", struck)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            run_study(load_study(files(samples=256, chunk=64)), tmp_path / "rows")
    finally:
        signal.signal(signal.SIGINT, before)
    assert summarize(tmp_path / "rows").written == 64


@pytest.mark.slow
def test_a_paused_writer_is_named(files, tmp_path):
    path = files(samples=5_000, chunk=64)
    process = start(path, tmp_path / "rows")
    try:
        wait_until_written(tmp_path / "rows", process)
        process.send_signal(signal.SIGSTOP)
        done = CliRunner().invoke(main, ["batch", str(path), "-q", "-o", str(tmp_path / "rows")])
        assert done.exit_code == 2
        assert f"process {process.pid}" in done.output
        assert "paused" in done.output
    finally:
        process.kill()
        process.communicate()


@pytest.mark.slow
@pytest.mark.parametrize("most", [5, pytest.param(50, marks=pytest.mark.sweep)])
def test_killed_and_paused_at_random_moments_two_at_once(files, tmp_path, most):
    """After every kill or pause: each row with a status is the study's own, to the last bit."""
    path = files(samples=768, chunk=64)
    study = load_study(path)
    run_study(study, tmp_path / "fresh")
    truth = open_study(tmp_path / "fresh")
    rng = random.Random(0)
    folder, paused, moments, refused = tmp_path / "rows", [], 0, 0
    turn = 0
    while moments < most:
        pair = [
            ForkedCommand(options(path, folder), tmp_path / f"told{turn}.{i}") for i in range(2)
        ]
        # Half of the moments fall into the start, where the store is made.
        begun = rng.random() < 0.5
        while begun and all(p.poll() is None for p in pair) and not folder.exists():
            time.sleep(0.001)
        time.sleep(rng.uniform(0.0, 0.1) if begun else rng.uniform(0.02, 0.3))
        for process in pair:
            if process.poll() is None:
                moments += 1
                if rng.random() < 0.5:
                    process.kill()
                else:
                    process.pause()
                    paused.append(process)
        assert_own_rows(folder, truth)
        # What was paused goes on beside those that are started then.
        for process in paused[: rng.randint(0, len(paused))]:
            process.send_signal(signal.SIGCONT)
            paused.remove(process)
            pair.append(process)
        for process in pair:
            if process not in paused:
                told = process.communicate(timeout=120)[0]
                assert process.returncode in (0, 2, -signal.SIGKILL), told
                assert "Traceback" not in told
                assert "bug" not in told
                refused += process.returncode == 2
        assert_own_rows(folder, truth)
        turn += 1
        made = (folder / "study.json").exists()
        if made and not paused and summarize(folder).complete:
            folder.rename(tmp_path / f"done{turn}")
    for process in paused:
        process.kill()
        process.communicate()
    run_study(study, folder)
    assert same_rows(folder, tmp_path / "fresh")
    assert refused > 0 or most < 50


def assert_own_rows(folder, truth):
    if not (folder / "study.json").exists():
        return
    rows = open_study(folder)
    written = rows["status"].values != UNWRITTEN
    for name in truth.data_vars:
        assert np.array_equal(rows[name].values[written], truth[name].values[written]), name
    assert summarize(folder).written == written.sum()


def test_a_coefficient_that_cannot_be_told_from_others_is_refused():
    class Odd:
        def __call__(self, speed):
            return 0.5

        def __reduce__(self):
            raise TypeError

    with pytest.raises(ik.errors.InputError, match="an Odd"):
        fingerprint_of(contact=ik.Contact("FL_FOOT", restitution=Odd()))


@pytest.mark.parametrize(
    ("record", "message"),
    [("{", "damaged"), ("[1]", "damaged"), ('{"fingerprint": "", "format": 3}', "another version")],
)
def test_records_of_others_are_refused(files, tmp_path, record, message):
    (tmp_path / "rows").mkdir()
    (tmp_path / "rows" / "study.json").write_text(record)
    study = load_study(files())
    for look in (open_study, summarize, lambda folder: run_study(study, folder)):
        with pytest.raises(InputError, match=message):
            look(tmp_path / "rows")
