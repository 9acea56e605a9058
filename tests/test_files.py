"""Files of users: whole or as they were, whatever goes wrong while they are written."""

from __future__ import annotations

import errno
import io
import os
import resource
import signal
import stat
import zipfile

import numpy as np
import pytest
from click.testing import CliRunner

import impulsekit as ik
from impulsekit.cli import main
from impulsekit.errors import FileError, ImpulsekitError, InputError
from impulsekit.files import (
    open_plain_file,
    read_npz,
    replaced_file,
    write_file,
)


@pytest.fixture(scope="module")
def struck():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])])
    impact = ik.solve(scene, robot.neutral(), robot.velocity())
    motion = ik.simulate(scene, robot.neutral(), robot.velocity(), duration=0.01, samples=3)
    return scene, impact, motion


def writers(struck):
    scene, impact, motion = struck
    return {
        "scene.toml": lambda path: ik.save_scene(path, scene, impact.q, impact.v_before),
        "motion.npz": motion.save,
        "page.html": lambda path: ik.replay(impact, path),
        "sheet.png": lambda path: ik.plots.overview(impact, path),
        "sheet.svg": lambda path: ik.plots.overview(impact, path),
    }


KINDS = ("scene.toml", "motion.npz", "page.html", "sheet.png", "sheet.svg")


@pytest.fixture
def nearly_full_disk():
    """A disk on which no file can be longer than a few bytes."""
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill():
        resource.setrlimit(resource.RLIMIT_FSIZE, (50, limits[1]))

    yield fill
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    signal.signal(signal.SIGXFSZ, handler)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_full_disk_leaves_the_file_that_was_there(struck, tmp_path, nearly_full_disk, kind):
    path, write = tmp_path / kind, writers(struck)[kind]
    write(path)
    before = path.read_bytes()
    nearly_full_disk()
    with pytest.raises(FileError, match=kind) as caught:
        write(path)
    assert caught.value.errno == errno.EFBIG
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [kind]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("what", ["folder", "pipe", "device", "nowhere", "read-only"])
def test_what_cannot_be_written_is_told(struck, tmp_path, kind, what):
    path = tmp_path / kind
    if what == "folder":
        path.mkdir()
    elif what == "pipe":
        os.mkfifo(path)
    elif what == "device":
        os.symlink("/dev/full", path)
    elif what == "nowhere":
        path = tmp_path / "no" / kind
    else:
        path.write_text("mine")
        path.chmod(0o444)
        if os.access(path, os.W_OK):
            pytest.skip("root may write to every file")
    with pytest.raises(FileError, match=kind):
        writers(struck)[kind](path)


@pytest.mark.parametrize("what", ["pipe", "folder", "device", "socket"])
def test_only_plain_files_are_read(tmp_path, what):
    path = tmp_path / "given"
    if what == "pipe":
        os.mkfifo(path)
    elif what == "folder":
        path.mkdir()
    elif what == "device":
        os.symlink("/dev/zero", path)
    else:
        import socket

        socket.socket(socket.AF_UNIX).bind(str(path))
    for read in (ik.load_scene, ik.Robot.from_urdf, ik.Trajectory.load, ik.study.load_study):
        with pytest.raises(ImpulsekitError, match=f"a {what}, not a file"):
            read(path)
    with pytest.raises(OSError, match=f"a {what}"):
        open_plain_file(path)
    done = CliRunner().invoke(main, ["replay", str(path), "--html", str(tmp_path / "page.html")])
    assert done.exit_code == 2
    assert f"a {what}, not a file" in done.output


@pytest.mark.parametrize(
    "arguments",
    [
        ["solve", "--json", "no/a.json"],
        ["solve", "--plot", "no/a.png"],
        ["solve", "--html", "no/a.html"],
        ["simulate", "--output", "no/a.npz"],
        ["simulate", "--plot", "a.doc"],
        ["design", "--json", "no/a.json"],
        ["fit", "--json", "no/a.json"],
        ["replay", "--html", "no/a.html"],
        ["batch", "--plot", "no/a.png"],
        ["batch", "--store", "no.toml/rows"],
    ],
)
def test_a_command_tells_before_its_work_what_it_cannot_write(tmp_path, monkeypatch, arguments):
    """The scene file has a fault as well, and is not even read."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "no.toml").write_text("no scene")
    command, *options = arguments
    done = CliRunner().invoke(main, [command, "no.toml", *options])
    assert done.exit_code == 2
    assert options[1] in done.output
    assert "well-formed" not in done.output


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a.txt").write_text("old")
    (tmp_path / "real" / "a.txt").chmod(0o640)
    os.symlink("real/a.txt", tmp_path / "link.txt")
    write_file(tmp_path / "link.txt", "new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real" / "a.txt").read_text() == "new"
    assert stat.S_IMODE((tmp_path / "real" / "a.txt").stat().st_mode) == 0o640


def test_a_new_file_has_the_permissions_that_open_would_give(tmp_path):
    write_file(tmp_path / "ours", "")
    (tmp_path / "theirs").write_text("")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "theirs").stat().st_mode


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_an_error_while_writing_leaves_the_old_file(tmp_path, error):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(error), replaced_file(path) as file:
        file.write(b"new")
        raise error
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_an_npz_header_is_not_believed(tmp_path):
    """20 GB promised by 200 bytes: the header of an array, or the directory of the archive."""
    held = np.zeros(3)
    whole, header = io.BytesIO(), io.BytesIO()
    np.save(whole, held)
    content = whole.getvalue()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (2_500_000_000,)}
    )
    for bytes_ in (header.getvalue() + held.tobytes(), content + b"\0"):
        path = tmp_path / "a.npz"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("t.npy", bytes_)
        with path.open("rb") as file, pytest.raises(ValueError, match=r"promises \d+ bytes"):
            read_npz(file)
        with pytest.raises(InputError, match=r"a\.npz.*promises"):
            ik.Trajectory.load(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("t.npy", content)
    with path.open("rb") as file:
        np.testing.assert_array_equal(read_npz(file)["t"], held)
    size = len(content).to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(size, (2_000_000_000).to_bytes(4, "little")))
    with path.open("rb") as file, pytest.raises(ValueError, match="promises 2 GB"):
        read_npz(file)
